//! What holds for every call: tokens, origins, limits of the head, unknown addresses and methods.

use crate::support::*;
use contuse::service::tokens::Tokens;
use std::io::Read;
use std::time::Duration;

const ANNA: &str = "anna-0123456789abcdef";
const BERT: &str = "bert-0123456789abcdef";

fn with_tokens() -> Server {
    Server::with(|c| c.tokens = Tokens::parse(&format!("anna {ANNA}\nbert {BERT}")).unwrap())
}

#[test]
fn nothing_without_a_token() {
    let server = with_tokens();
    let client = server.client();
    for answer in [
        client.get("/v1/jobs"),
        client.post_json("/v1/jobs", &quick()),
        client.with_token("wrong-0123456789abcdef").get("/v1/jobs"),
        client.get_with("/v1/jobs", &[("Authorization", &format!("Basic {ANNA}"))]),
        client.get_with("/v1/jobs", &[("Authorization", "Bearer")]),
        client.get("/v1/jobs/nothing"),
        client.send("POST", "/v1/meshes", &[], b"$"),
        client.get("/metrics"),
    ] {
        problem(&answer, 401, "unauthorized");
        assert_eq!(answer.header("www-authenticate"), Some("Bearer"));
    }
    assert_eq!(client.get("/healthz").status, 200);
    assert_eq!(client.get("/openapi.json").status, 200);
}

#[test]
fn jobs_and_meshes_belong_to_their_token() {
    let server = with_tokens();
    let (anna, bert) = (server.client().with_token(ANNA), server.client().with_token(BERT));
    let (job, _) = finished(&anna, &quick());
    for path in ["", "/events", "/summary", "/recording"] {
        problem(&bert.get(&format!("{job}{path}")), 404, "job-not-found");
    }
    problem(&bert.post(&format!("{job}/cancel")), 404, "job-not-found");
    problem(&bert.delete(&job), 404, "job-not-found");
    assert!(bert.get("/v1/jobs").json()["jobs"].as_array().unwrap().is_empty());
    assert_eq!(anna.get(&job).status, 200);

    let octets = [("Content-Type", "application/octet-stream")];
    let mesh = anna.send("POST", "/v1/meshes", &octets, b"$mesh").json();
    let address = format!("/v1/meshes/{}", mesh["id"].as_str().unwrap());
    problem(&bert.get(&address), 404, "mesh-not-found");
    let mut scene = quick();
    scene["mesh"] = mesh["id"].clone();
    problem(&bert.post_json("/v1/jobs", &scene), 422, "invalid-scene");
    assert_eq!(anna.post_json("/v1/jobs", &scene).status, 202);
}

#[test]
fn keys_belong_to_their_token() {
    let server = with_tokens();
    let headers = [("Content-Type", "application/json"), ("Idempotency-Key", "k")];
    let post = |token, scene: &serde_json::Value| {
        server.client().with_token(token).send("POST", "/v1/jobs", &headers, scene.to_string().as_bytes())
    };
    assert_eq!(post(ANNA, &quick()).status, 202);
    let other = post(BERT, &endless());
    assert_eq!((other.status, other.header("idempotent-replayed")), (202, None));
}

#[test]
fn pages_of_other_origins_change_nothing() {
    let server = Server::with(|c| c.cors_origins = vec!["https://viewer.example".into()]);
    let post = |origin: &str| {
        let headers = [("Content-Type", "application/json"), ("Origin", origin)];
        server.client().send("POST", "/v1/jobs", &headers, quick().to_string().as_bytes())
    };
    problem(&post("https://evil.example"), 403, "cross-origin");
    problem(&post("null"), 403, "cross-origin");
    assert_eq!(post("https://viewer.example").status, 202);
    assert_eq!(post(&format!("http://{}", server.address)).status, 202);
}

#[test]
fn unknown_addresses_and_methods_are_problems() {
    let server = Server::start();
    problem(&server.client().get("/nothing"), 404, "not-found");
    problem(&server.client().get("/v2/jobs"), 404, "not-found");
    problem(&server.client().get("/../../etc/passwd"), 404, "not-found");
    let answer = server.client().send("PUT", "/v1/jobs", &[], b"");
    problem(&answer, 405, "method-not-allowed");
    let allowed = answer.header("allow").unwrap();
    assert!(allowed.contains("GET") && allowed.contains("POST"), "{allowed}");
}

#[test]
fn heads_have_limits() {
    let server = Server::with(|c| c.request_timeout = Duration::from_millis(200));
    let many: Vec<(String, String)> = (0..200).map(|i| (format!("x-{i}"), "y".into())).collect();
    let many: Vec<(&str, &str)> = many.iter().map(|(n, v)| (n.as_str(), v.as_str())).collect();
    assert_eq!(server.client().get_with("/healthz", &many).status, 431);
    assert_eq!(server.client().get_with("/healthz", &[("x-long", &"y".repeat(100_000))]).status, 431);

    // A head that never ends is given up, and so is one that never begins, or no second one.
    let begun = b"GET /healthz HTTP/1.1\r\nHost: x\r\n";
    for bytes in [&begun[..], b"", &[begun, &b"\r\n"[..]].concat()] {
        let mut stream = server.client().raw(bytes);
        let mut rest = Vec::new();
        stream.read_to_end(&mut rest).unwrap();
    }
}

#[test]
fn rubbish_does_not_hurt() {
    let server = Server::start();
    for bytes in [
        &b"\x00\xff\x16\x03\x01"[..],
        b"GET\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"POST /v1/jobs HTTP/1.1\r\nContent-Length: -5\r\n\r\n",
    ] {
        let mut stream = server.client().raw(bytes);
        let _ = stream.shutdown(std::net::Shutdown::Write);
        let mut rest = Vec::new();
        let _ = stream.read_to_end(&mut rest);
    }
    assert_eq!(server.client().get("/healthz").status, 200);
}

#[test]
fn those_who_hang_up_leave_no_room_to_others() {
    let server = Server::start();
    let client = server.client();
    let mut scene = quick();
    scene["counted_check_ms"] = serde_json::json!(100);
    let body = scene.to_string();
    let request = format!(
        "POST /v1/jobs/validate HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
        client.address,
        body.len()
    );
    for _ in 0..10 {
        let stream = client.raw(request.as_bytes());
        std::thread::sleep(Duration::from_millis(20));
        drop(stream);
    }
    assert_eq!(client.post_json("/v1/jobs/validate", &scene).status, 200);
    // Two for the one worker, however the requests ended.
    let [_, most] = *engine::COUNTED_CHECKS.lock().unwrap();
    assert!((1..=2).contains(&most), "{most} at the same time");
}
