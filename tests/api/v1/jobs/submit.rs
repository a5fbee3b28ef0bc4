//! `POST /v1/jobs`

use crate::support::*;
use serde_json::{Value, json};

#[test]
fn accepted_job_has_an_address_and_is_found_there() {
    let server = Server::start();
    let client = server.client();
    let answer = client.post_json("/v1/jobs", &quick());
    assert_eq!(answer.status, 202);
    let job = answer.json();
    assert_eq!(answer.header("location").unwrap(), job["links"]["self"]);
    assert_eq!(job["name"], "quick");
    assert!(job["notice"].as_str().unwrap().contains("not a medical device"));
    assert_eq!(client.get(job["links"]["self"].as_str().unwrap()).json()["id"], job["id"]);
}

#[test]
fn bad_json_is_answered_with_line_and_column() {
    let server = Server::start();
    let answer = server.client().post_text("/v1/jobs", "{\n  \"name\": oops\n}");
    let body = problem(&answer, 400, "bad-json");
    assert_eq!(body["line"], 2);
    assert!(body["column"] == 11, "{body}");
    for text in ["", "{", "[1,]", "{\"a\":1}x", "\u{0}", &"[".repeat(100_000)] {
        problem(&server.client().post_text("/v1/jobs", text), 400, "bad-json");
    }
    let latin1 = server.client().send(
        "POST",
        "/v1/jobs",
        &[("Content-Type", "application/json")],
        b"{\"name\":\"\xe9\"}",
    );
    problem(&latin1, 400, "bad-json");
}

#[test]
fn every_problem_of_a_scene_is_listed() {
    let server = Server::start();
    for wrong in
        [json!({}), json!([]), json!(null), json!("x"), json!({ "name": 3, "end_time_s": -1, "steps": "x" })]
    {
        let body = problem(&server.client().post_json("/v1/jobs", &wrong), 422, "invalid-scene");
        let pointers: Vec<&Value> =
            body["errors"].as_array().unwrap().iter().map(|e| &e["pointer"]).collect();
        assert_eq!(pointers, ["/name", "/end_time_s", "/steps"]);
    }
    assert_eq!(server.client().get("/v1/jobs").json()["jobs"], json!([]), "nothing was kept");
}

#[test]
fn only_declared_json_is_taken() {
    let server = Server::start();
    let body = quick().to_string();
    for kind in ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x"] {
        let answer = server.client().send("POST", "/v1/jobs", &[("Content-Type", kind)], body.as_bytes());
        problem(&answer, 415, "unsupported-media-type");
    }
    problem(&server.client().send("POST", "/v1/jobs", &[], body.as_bytes()), 415, "unsupported-media-type");
    let charset = [("Content-Type", "application/json; charset=utf-8")];
    assert_eq!(server.client().send("POST", "/v1/jobs", &charset, body.as_bytes()).status, 202);
}

#[test]
fn huge_bodies_are_refused_declared_or_not() {
    let server = Server::with(|c| c.runs.budget.document_bytes = 1000);
    let mut big = quick();
    big["padding"] = json!("x".repeat(2000));
    problem(&server.client().post_json("/v1/jobs", &big), 413, "body-too-large");

    let mut chunked = format!(
        "POST /v1/jobs HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n",
        server.address
    );
    for _ in 0..20 {
        chunked += &format!("64\r\n{}\r\n", " ".repeat(100));
    }
    let stream = server.client().raw(chunked.as_bytes());
    let answer = client::read_answer(&mut std::io::BufReader::new(stream), false);
    problem(&answer, 413, "body-too-large");
}

#[test]
fn slow_bodies_are_given_up() {
    let server = Server::with(|c| c.request_timeout = std::time::Duration::from_millis(200));
    let head = format!(
        "POST /v1/jobs HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: 100\r\n\r\n{{",
        server.address
    );
    let stream = server.client().raw(head.as_bytes());
    let answer = client::read_answer(&mut std::io::BufReader::new(stream), false);
    problem(&answer, 408, "body-too-slow");
}

#[test]
fn same_key_and_body_is_the_same_job() {
    let server = Server::start();
    let client = server.client();
    let headers = [("Content-Type", "application/json"), ("Idempotency-Key", "k-1")];
    let body = quick().to_string();
    let first = client.send("POST", "/v1/jobs", &headers, body.as_bytes());
    let again = client.send("POST", "/v1/jobs", &headers, body.as_bytes());
    assert_eq!((first.status, again.status), (202, 202));
    assert_eq!(first.header("idempotent-replayed"), None);
    assert_eq!(again.header("idempotent-replayed"), Some("true"));
    assert_eq!(first.header("location"), again.header("location"));
    let other = client.send("POST", "/v1/jobs", &headers, endless().to_string().as_bytes());
    problem(&other, 409, "idempotency-key-reused");
    assert_eq!(client.get("/v1/jobs").json()["jobs"].as_array().unwrap().len(), 1);
}

#[test]
fn concurrent_requests_with_one_key_make_one_job() {
    let server = Server::start();
    let headers = [("Content-Type", "application/json"), ("Idempotency-Key", "race")];
    let locations: Vec<(String, bool)> = std::thread::scope(|scope| {
        let posts: Vec<_> = (0..12)
            .map(|_| {
                scope.spawn(|| {
                    let answer =
                        server.client().send("POST", "/v1/jobs", &headers, quick().to_string().as_bytes());
                    assert_eq!(answer.status, 202, "{answer:?}");
                    (
                        answer.header("location").unwrap().to_owned(),
                        answer.header("idempotent-replayed").is_some(),
                    )
                })
            })
            .collect();
        posts.into_iter().map(|p| p.join().unwrap()).collect()
    });
    assert!(locations.iter().all(|(l, _)| *l == locations[0].0));
    assert_eq!(locations.iter().filter(|(_, replayed)| !replayed).count(), 1, "one of them made it");
    assert_eq!(server.client().get("/v1/jobs").json()["jobs"].as_array().unwrap().len(), 1);
}

#[test]
fn bad_keys_are_refused() {
    let server = Server::start();
    for key in ["two words", &"x".repeat(256)] {
        let headers = [("Content-Type", "application/json"), ("Idempotency-Key", key)];
        let answer = server.client().send("POST", "/v1/jobs", &headers, quick().to_string().as_bytes());
        problem(&answer, 400, "bad-header");
    }
}

#[test]
fn a_key_is_of_one_address_and_given_once() {
    let server = Server::start();
    let client = server.client();
    // Of this engine: a scene, and a question about one.
    let mut body = quick();
    body["scene"] = quick();
    let body = body.to_string();
    let headers = [("Content-Type", "application/json"), ("Idempotency-Key", "k-1")];
    let send = |address: &str| client.send("POST", address, &headers, body.as_bytes());
    let first = send("/v1/what-if");
    assert_eq!(first.status, 202, "{first:?}");
    for address in ["/v1/jobs", "/v1/studies"] {
        problem(&send(address), 409, "idempotency-key-reused");
    }
    let again = send("/v1/what-if");
    assert_eq!((again.status, again.header("location")), (202, first.header("location")));

    for other in ["k-2", "k-3"] {
        let headers = [headers[0], ("Idempotency-Key", "k-2"), ("Idempotency-Key", other)];
        let answer = client.send("POST", "/v1/jobs", &headers, quick().to_string().as_bytes());
        problem(&answer, 400, "bad-header");
    }
}

#[test]
fn names_of_files_are_no_meshes() {
    let server = Server::start();
    std::fs::create_dir(server.data.path().join("meshes")).unwrap();
    std::fs::write(server.data.path().join("meshes/ball.msh"), "$").unwrap();
    for name in [
        "../../../../etc/passwd",
        "/etc/passwd",
        "ball.msh",
        "./ball.msh",
        "",
        "http://127.0.0.1/x",
        "a\u{0}b",
    ] {
        let mut scene = quick();
        scene["mesh"] = json!(name);
        let body = problem(&server.client().post_json("/v1/jobs", &scene), 422, "invalid-scene");
        assert_eq!(body["errors"][0]["pointer"], "/mesh", "{name}");
    }
}

#[test]
fn full_queue_says_when_to_come_back() {
    let server = Server::with(|c| c.max_queued = 1);
    let client = server.client();
    let running = submit(&client, &endless());
    wait_for(&client, &running, "running");
    submit(&client, &endless());
    let answer = client.post_json("/v1/jobs", &endless());
    problem(&answer, 503, "unavailable");
    assert!(answer.header("retry-after").is_some());
}

#[test]
fn panic_in_a_check_is_an_answer_without_its_words() {
    let server = Server::start();
    let mut scene = quick();
    scene["panic_in_check"] = json!(true);
    let answer = server.client().post_json("/v1/jobs", &scene);
    let body = problem(&answer, 500, "internal");
    assert!(body["instance"].as_str().unwrap().starts_with("urn:uuid:"));
    assert!(
        !answer.text().contains("script") && !leaks(&answer.text(), server.data.path()),
        "{}",
        answer.text()
    );
    assert_eq!(server.client().post_json("/v1/jobs", &quick()).status, 202, "the service lives on");
}
