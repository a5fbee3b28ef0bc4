//! `GET /v1/jobs/{id}/recording`

use crate::support::*;
use serde_json::json;

const LENGTH: usize = 700_001;

fn recorded() -> (Server, String) {
    let server = Server::start();
    let mut scene = quick();
    scene["recording_bytes"] = json!(LENGTH);
    scene["name"] = json!("a/b \"c\"");
    let (job, _) = finished(&server.client(), &scene);
    (server, format!("{job}/recording"))
}

#[test]
fn whole_file_with_all_that_is_said_of_it() {
    let (server, address) = recorded();
    let answer = server.client().get(&address);
    assert_eq!(answer.status, 200);
    assert_eq!(answer.body, engine::recording(LENGTH));
    assert_eq!(answer.header("content-length").unwrap(), LENGTH.to_string());
    assert_eq!(answer.header("accept-ranges"), Some("bytes"));
    let name = answer.header("content-disposition").unwrap();
    assert!(name.starts_with("attachment; filename=\"a-b--c-") && name.ends_with(".mcap\""), "{name}");
    let digest = answer.header("repr-digest").unwrap();
    assert!(
        digest.starts_with("sha-256=:") && digest.ends_with("=:") && digest.len() == 9 + 44 + 1,
        "{digest}"
    );

    let head = server.client().send("HEAD", &address, &[], b"");
    assert_eq!(head.status, 200);
    for name in ["content-length", "etag", "repr-digest", "accept-ranges", "content-type"] {
        assert_eq!(head.header(name), answer.header(name), "{name}");
    }
    let partial_head = server.client().send("HEAD", &address, &[("Range", "bytes=0-9")], b"");
    assert_eq!(partial_head.status, 200, "a part is for GET alone");
    assert_eq!(partial_head.header("content-length"), answer.header("content-length"));
}

#[test]
fn parts_fit_together() {
    let (server, address) = recorded();
    let whole = engine::recording(LENGTH);
    let last = LENGTH - 1;
    for (range, expected) in [
        ("bytes=0-0".to_owned(), 0..=0),
        ("bytes=262143-262144".to_owned(), 262_143..=262_144),
        ("bytes=1000-".to_owned(), 1000..=last),
        ("bytes=-100".to_owned(), LENGTH - 100..=last),
        (format!("bytes=0-{}", 10 * LENGTH), 0..=last),
    ] {
        let answer = server.client().get_with(&address, &[("Range", &range)]);
        assert_eq!(answer.status, 206, "{range}");
        let named = format!("bytes {}-{}/{LENGTH}", expected.start(), expected.end());
        assert_eq!(answer.header("content-range"), Some(named.as_str()));
        assert_eq!(answer.body, whole[expected], "{range}");
        assert!(answer.header("repr-digest").is_some());
    }
}

#[test]
fn ranges_that_cannot_be() {
    let (server, address) = recorded();
    for range in
        [format!("bytes={LENGTH}-"), "bytes=-0".to_owned(), "bytes=99999999999999999999999-".to_owned()]
    {
        let answer = server.client().get_with(&address, &[("Range", &range)]);
        problem(&answer, 416, "range-not-satisfiable");
        assert_eq!(answer.header("content-range"), Some(format!("bytes */{LENGTH}").as_str()));
    }
    for range in ["bytes=5-2", "bytes=0-1,4-5", "bytes=x", "lines=0-1", "bytes 0-1"] {
        let answer = server.client().get_with(&address, &[("Range", range)]);
        assert_eq!((answer.status, answer.body.len()), (200, LENGTH), "{range}");
    }
}

#[test]
fn conditions_are_kept() {
    let (server, address) = recorded();
    let client = server.client();
    let etag = client.send("HEAD", &address, &[], b"").header("etag").unwrap().to_owned();
    let part = ("Range", "bytes=0-9");
    assert_eq!(client.get_with(&address, &[part, ("If-Range", &etag)]).status, 206);
    let stale = client.get_with(&address, &[part, ("If-Range", "\"stale\"")]);
    assert_eq!((stale.status, stale.body.len()), (200, LENGTH));
    let same = client.get_with(&address, &[("If-None-Match", &etag)]);
    assert_eq!((same.status, same.header("etag"), same.body.len()), (304, Some(etag.as_str()), 0));
    assert_eq!(client.get_with(&address, &[("If-None-Match", "\"other\"")]).status, 200);
    problem(&client.get_with(&address, &[("If-Match", "\"other\"")]), 412, "precondition-failed");
}

#[test]
fn pages_of_listed_origins_may_read_it() {
    let server = Server::with(|c| c.cors_origins = vec!["https://viewer.example".into()]);
    let (job, _) = finished(&server.client(), &quick());
    let address = format!("{job}/recording");
    let answer =
        server.client().get_with(&address, &[("Origin", "https://viewer.example"), ("Range", "bytes=0-9")]);
    assert_eq!(answer.header("access-control-allow-origin"), Some("https://viewer.example"));
    let exposed = answer.header("access-control-expose-headers").unwrap();
    for name in ["content-length", "content-range", "accept-ranges", "etag", "repr-digest"] {
        assert!(exposed.contains(name), "{name} is not in {exposed}");
    }
    let requested = [
        ("Origin", "https://viewer.example"),
        ("Access-Control-Request-Method", "GET"),
        ("Access-Control-Request-Headers", "range,if-range"),
    ];
    let preflight = server.client().send("OPTIONS", &address, &requested, b"");
    assert_eq!(preflight.status, 200);
    assert!(preflight.header("access-control-allow-headers").unwrap().contains("range"));
}

#[test]
fn nothing_before_the_start() {
    let server = Server::with(|c| c.workers = 0);
    let job = submit(&server.client(), &endless());
    let answer = server.client().get(&format!("{job}/recording"));
    assert!(problem(&answer, 409, "not-yet")["remedy"].as_str().unwrap().contains("events"));
}

#[test]
fn running_job_shows_snapshots_that_do_not_change() {
    let server = Server::start();
    let client = server.client();
    let mut scene = endless();
    scene["grows"] = json!(true);
    let job = submit(&client, &scene);
    let address = format!("{job}/recording");
    eventually("it has recorded", || client.get(&address).status == 200);
    let first = client.get(&address);
    let (etag, place) = (first.header("etag").unwrap(), first.header("content-location").unwrap());
    assert_eq!(first.header("repr-digest"), None);
    assert!(first.header("content-disposition").unwrap().contains("-snapshot-"));

    // A second later there is another, and the first is still what it was.
    eventually("another", || client.get(&address).header("etag").unwrap() != etag);
    assert_eq!(client.get(place).body, first.body);
    let rest = client.get_with(&address, &[("Range", "bytes=100-"), ("If-Range", etag)]);
    assert_eq!((rest.status, rest.body.as_slice()), (206, &first.body[100..]));
    let stale = client.get_with(&address, &[("Range", "bytes=100-"), ("If-Range", "\"stale\"")]);
    assert!(stale.status == 200 && stale.body.len() > first.body.len());
    problem(&client.get(&format!("{address}?snapshot=99")), 410, "snapshot-gone");
    problem(&client.get(&format!("{address}?snapshot=x")), 400, "bad-parameter");

    client.post(&format!("{job}/cancel"));
    wait_for(&client, &job, "cancelled");
    problem(&client.get(place), 410, "snapshot-gone");
    eventually("only the recording is left", || server.files().len() == 1);
    assert!(client.get(&address).header("repr-digest").is_some());
}

#[test]
fn a_recording_that_was_removed_is_reported() {
    let (server, address) = recorded();
    let [file] = &server.files()[..] else { panic!("{:?}", server.files()) };
    std::fs::write(file, b"short").unwrap();
    problem(&server.client().get(&address), 410, "recording-lost");
    std::fs::remove_file(file).unwrap();
    let job = address.strip_suffix("/recording").unwrap();
    for what in ["recording", "report", "export.csv", "export.vtu.tar", "export.stl", "export.ply", "fhir"] {
        problem(&server.client().get(&format!("{job}/{what}")), 410, "recording-lost");
    }
}
