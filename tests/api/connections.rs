//! Clients that stall, and many of them.

use crate::support::client::{Client, read_answer};
use crate::support::*;
use contuse::service::tokens::Tokens;
use serde_json::{Value, json};
use std::io::{BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// The beginning of an upload.
fn stalled_head(client: &Client) -> String {
    format!(
        "POST /v1/meshes HTTP/1.1\r\nHost: {}\r\nContent-Type: application/octet-stream\r\nContent-Length: 1000\r\n\r\n$",
        client.address
    )
}

/// An upload that has begun and goes on no further.
fn stalled_upload(client: &Client) -> TcpStream {
    client.raw(stalled_head(client).as_bytes())
}

/// Whether a request is answered with 200.
fn is_answered(client: &Client, path: &str) -> bool {
    let head = format!("GET {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", client.address);
    let mut text = String::new();
    let _ = client.raw(head.as_bytes()).read_to_string(&mut text);
    text.starts_with("HTTP/1.1 200")
}

#[test]
fn stalled_uploads_and_streams_leave_connections_for_others() {
    let server = Server::with(|c| {
        c.max_connections = 64;
        c.workers = 0;
    });
    let client = server.client();
    let job = submit(&client, &quick());
    let mut open: Vec<TcpStream> = (0..64).map(|_| stalled_upload(&client)).collect();
    let head = format!("GET {job}/events HTTP/1.1\r\nHost: {}\r\n\r\n", client.address);
    open.extend((0..64).map(|_| client.raw(head.as_bytes())));
    // Those beyond the limits are refused, which takes a moment.
    eventually("short requests are answered", || {
        ["/healthz", &job].iter().all(|path| is_answered(&client, path))
    });
    // One more of each kind is refused, and says so.
    let upload = stalled_head(&client);
    for request in [&upload, &head] {
        let mut kept = Vec::new();
        eventually("one more of the kind is refused", || {
            let mut stream = client.raw(request.as_bytes());
            stream.set_read_timeout(Some(Duration::from_millis(500))).unwrap();
            let mut answer = vec![0; 4096];
            // A stalled upload that has its permit is not answered.
            let length = stream.read(&mut answer).unwrap_or(0);
            let text = String::from_utf8_lossy(&answer[..length]).into_owned();
            kept.push(stream);
            text.starts_with("HTTP/1.1 429") && text.contains("retry-after")
        });
    }
    drop(open);
    let mesh = || {
        client.send("POST", "/v1/meshes", &[("Content-Type", "application/octet-stream")], b"$mesh").status
    };
    eventually("those who leave make room", || mesh() < 300);
}

/// Connections with requests that take as long as they stay open.
fn busy(client: &Client, count: usize) -> Vec<TcpStream> {
    validating(client, count, "checks_while_wanted", json!(true))
}

/// Connections with requests to validate a scene with an entry.
fn validating(client: &Client, count: usize, key: &str, value: Value) -> Vec<TcpStream> {
    let mut scene = quick();
    scene[key] = value;
    let (address, scene) = (client.address, scene.to_string());
    let length = scene.len();
    let request = format!(
        "POST /v1/jobs/validate HTTP/1.1\r\nHost: {address}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n{scene}"
    );
    let begin = |_| {
        let stream = client.raw(request.as_bytes());
        // Only so many bodies are received at once.
        std::thread::sleep(Duration::from_millis(20));
        stream
    };
    (0..count).map(begin).collect()
}

/// Asks on a connection that stays open.
fn ask(client: &Client, mut stream: &TcpStream) -> u16 {
    let head = format!("GET /v1/jobs HTTP/1.1\r\nHost: {}\r\n\r\n", client.address);
    stream.write_all(head.as_bytes()).unwrap();
    read_answer(&mut BufReader::new(stream), false).status
}

#[test]
fn the_connection_that_is_idle_for_longest_makes_room() {
    let server = Server::with(|c| c.max_connections = 8);
    let client = server.client();
    let working = validating(&client, 1, "check_ms", json!(5000));
    let mut idle: Vec<TcpStream> = (0..5).map(|_| client.raw(b"")).collect();
    eventually("all have a seat", || idle.iter().skip(1).all(|stream| ask(&client, stream) == 200));
    assert_eq!(client.get("/v1/jobs").status, 200);
    assert_eq!(idle[0].read(&mut [0]).unwrap(), 0, "the one that never asked");
    assert!(idle[1..].iter().all(|stream| ask(&client, stream) == 200));
    for _ in 0..20 {
        idle.push(client.raw(b""));
    }
    eventually("there is room for who asks", || client.get("/v1/jobs").status == 200);
    let mut reader = BufReader::new(&working[0]);
    assert_eq!(read_answer(&mut reader, false).status, 200, "whoever has asked has the answer");
}

#[test]
fn a_connection_is_not_idle_for_ever() {
    let server = Server::with(|c| c.request_timeout = Duration::from_millis(300));
    let client = server.client();
    let mut stream = client.raw(b"");
    assert_eq!(ask(&client, &stream), 200);
    let begun = Instant::now();
    let mut rest = Vec::new();
    stream.read_to_end(&mut rest).unwrap();
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
}

#[test]
fn connections_of_one_address_are_limited() {
    let server = Server::with(|c| c.max_connections = 8);
    let client = server.client();
    let open = busy(&client, 6);
    let refused = client.get("/v1/jobs");
    assert!(refused.header("retry-after").is_some());
    let refused = problem(&refused, 503, "busy");
    assert!(refused["detail"].as_str().unwrap().starts_with("6 connections from your address"), "{refused}");
    // One that says nothing is closed soon.
    let begun = Instant::now();
    assert_eq!(client.raw(b"").read(&mut [0]).unwrap_or(0), 0);
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    drop(open);
    eventually("there is room again", || is_answered(&client, "/v1/jobs"));
}

#[test]
fn an_address_that_has_all_its_connections_is_probed_nevertheless() {
    let server = Server::with(|c| c.max_connections = 64);
    let client = server.client();
    let working = busy(&client, 48);
    // Some are silent, some have begun a request; more come all the time.
    let half_open =
        |n: usize| client.raw(if n.is_multiple_of(2) { b"" } else { b"GET /healthz HTTP/1.1\r\n" });
    let mut open: Vec<TcpStream> = (0..600).map(half_open).collect();
    for round in 0..20 {
        for path in ["/healthz", "/readyz"] {
            let begun = Instant::now();
            assert_eq!(client.get(path).status, 200, "{path}, round {round}");
            assert!(begun.elapsed() < Duration::from_secs(5), "{path}: {:?}", begun.elapsed());
        }
        problem(&client.get("/v1/jobs"), 503, "busy");
        open.extend((0..20).map(half_open));
    }
    drop(working);
}

#[test]
fn a_slow_upload_is_cut_off() {
    let server = Server::with(|c| {
        c.request_timeout = Duration::from_millis(300);
        c.least_rate = 1000;
    });
    let client = server.client();
    // A byte every 50 ms is never silent for long, but too slow.
    let mut slow = stalled_upload(&client);
    let mut writer = slow.try_clone().unwrap();
    let sending = std::thread::spawn(move || {
        for _ in 0..100 {
            std::thread::sleep(Duration::from_millis(50));
            if writer.write_all(b"$").is_err() {
                return;
            }
        }
    });
    let answer = read_answer(&mut BufReader::new(&mut slow), false);
    problem(&answer, 408, "body-too-slow");
    drop(slow);
    sending.join().unwrap();
    assert!(server.files().is_empty(), "{:?}", server.files());
}

#[test]
fn jobs_wait_for_a_disk_without_room() {
    let server = Server::with(|c| c.workers = 0);
    let job = submit(&server.client(), &quick());
    // As if the disk were full.
    let full = Server::on(server.stop(), |c| c.least_free = u64::MAX);
    let client = full.client();
    let refused = client.post_json("/v1/jobs", &quick());
    problem(&refused, 507, "storage-full");
    assert!(refused.header("retry-after").is_some());
    let octets = [("Content-Type", "application/octet-stream")];
    problem(&client.send("POST", "/v1/meshes", &octets, b"$mesh"), 507, "storage-full");
    problem(&client.get("/readyz"), 503, "unavailable");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(client.get(&job).json()["state"], "queued");
    let again = Server::on(full.stop(), |_| {});
    wait_for(&again.client(), &job, "succeeded");
}

/// The status of a large body that is refused before it was read, and whether the whole answer arrived.
fn refusal(client: &Client, (path, token): (&str, &str), megabytes: usize) -> u16 {
    let length = megabytes << 20;
    let head = format!(
        "POST {path} HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {token}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n",
        client.address
    );
    let mut stream = client.raw(head.as_bytes());
    // As clients do that read the answer when they have sent everything.
    let piece = vec![b' '; 1 << 20];
    for _ in 0..megabytes {
        stream.write_all(&piece).unwrap();
    }
    let answer = read_answer(&mut BufReader::new(stream), false);
    assert!(answer.json()["detail"].is_string());
    answer.status
}

#[test]
fn a_refused_upload_has_its_answer() {
    let tokens = Tokens::parse("anna anna-0123456789abcdef\nread read-0123456789abcdef read").unwrap();
    let server = Server::with(|c| {
        c.tokens = tokens;
        c.runs.budget.mesh_bytes = 8 << 20;
    });
    let client = server.client();
    for megabytes in [5, 60] {
        let octets = "/v1/meshes?format=msh";
        for (request, status) in [
            (("/v1/jobs", "anna-0123456789abcdef"), 413),
            (("/v1/jobs", "read-0123456789abcdef"), 403),
            (("/v1/jobs", "stranger"), 401),
            ((octets, "stranger"), 401),
            ((octets, "anna-0123456789abcdef"), 415),
        ] {
            assert_eq!(refusal(&client, request, megabytes), status, "{request:?}, {megabytes} MB");
        }
    }
    for _ in 0..10 {
        client.with_token("stranger").get("/v1/jobs");
    }
    assert_eq!(refusal(&client, ("/v1/jobs", "stranger"), 60), 429);
}
