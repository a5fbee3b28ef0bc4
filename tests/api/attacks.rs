//! Attacks of all kinds on one service, one after the other: its memory stays small, no answer is an error of its own, and the job of
//! an innocent client succeeds.

use crate::support::client::{Answer, Client};
use crate::support::program::Program;
use crate::support::*;
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Most memory that the service may ever have had [bytes].
const MOST_MEMORY: u64 = 150_000_000;
/// Most memory that it keeps after an attack [bytes].
const MOST_KEPT: u64 = 80_000_000;
const OCTETS: [(&str, &str); 1] = [("Content-Type", "application/octet-stream")];

fn ball_on_block(elements: u32) -> Value {
    let mut scene: Value =
        serde_json::from_str(include_str!("../recording/small_ball_on_block.json")).unwrap();
    scene["bodies"][1]["mesh"]["generator"]["elements"] = json!([elements, elements, elements]);
    scene["end_time_s"] = json!(1e-6);
    scene["record"] = json!({ "fields": [] });
    scene
}

/// Sends requests at the same time.
fn all(
    client: &Client,
    count: usize,
    ask: impl Fn(&Client) -> Answer + Copy + Send + 'static,
) -> Vec<JoinHandle<Answer>> {
    let one = |_| {
        let client = client.clone();
        std::thread::spawn(move || ask(&client))
    };
    (0..count).map(one).collect()
}

fn statuses(answers: Vec<JoinHandle<Answer>>) -> Vec<u16> {
    answers.into_iter().map(|answer| answer.join().unwrap().status).collect()
}

/// Bodies that are much work, or much memory, for few bytes.
fn hostile_bodies(client: &Client) {
    // 3.8 MB of unknown keys: the answer has a hundred of them.
    let keys: Vec<String> = (0..210_000).map(|i| format!("\"unknown{i}\":0")).collect();
    let unknown = format!("{{{}}}", keys.join(","));
    for answer in all_bodies(client, unknown, 4) {
        let errors = problem(&answer, 422, "invalid-scene")["errors"].as_array().unwrap().len();
        assert!(errors <= 101 && answer.body.len() < 100_000, "{errors} errors, {} bytes", answer.body.len());
    }
    let empty = format!("[{}]", vec!["{\"\":0}"; 540_000].join(","));
    let deep = "[".repeat(1_000_000);
    let numbers = format!("{{\"name\": {}}}", "9".repeat(3_900_000));
    for text in [empty, deep, numbers] {
        for answer in all_bodies(client, text, 4) {
            assert!([400, 422].contains(&answer.status), "{answer:?}");
        }
    }
    // Said to be compressed: it is not unpacked.
    let headers = [("Content-Type", "application/json"), ("Content-Encoding", "gzip")];
    let answer = client.send("POST", "/v1/jobs", &headers, &[0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3]);
    assert!((400..500).contains(&answer.status), "{answer:?}");
}

/// Validates a body several times at once.
fn all_bodies(client: &Client, text: String, count: usize) -> Vec<Answer> {
    let text: &'static str = text.leak();
    let answers = all(client, count, move |client| client.post_text("/v1/jobs/validate", text));
    answers.into_iter().map(|answer| answer.join().unwrap()).collect()
}

/// A document of 4 MB, most of it blanks.
fn padded(document: &Value) -> String {
    let text = document.to_string();
    format!("{}{}}}", &text[..text.len() - 1], " ".repeat(4_000_000 - text.len()))
}

/// Many large bodies at once, wherever there are bodies, and documents of that size that are read again.
fn many_large_bodies(client: &Client) {
    let scene = ball_on_block(2);
    let first = client.post_text("/v1/jobs", &padded(&scene)).json();
    let plan: &'static str = format!("/v1/jobs/{}/plan", first["id"].as_str().unwrap()).leak();
    let speed = json!([{ "name": "speed", "change": { "kind": "speed_m_per_s" }, "low": 9, "high": 11 }]);
    let of_job = json!({ "job": first["id"], "parameters": speed, "one_at_a_time": true });
    let of_scene = json!({ "scene": scene, "parameters": speed, "one_at_a_time": true });
    let numbers = json!({ "name": vec![0.123_456_78; 350_000] }).to_string();
    let bodies = [
        ("/v1/jobs", padded(&scene)),
        ("/v1/jobs/validate", padded(&scene)),
        ("/v1/jobs/validate", numbers),
        ("/v1/what-if", padded(&of_job)),
        ("/v1/what-if", padded(&of_scene)),
        ("/v1/studies", padded(&json!({ "kind": "error", "scene": scene }))),
    ];
    let bodies: &'static [(&str, String)] = Vec::from(bodies).leak();
    let ask = |client: &Client, n: usize| match bodies.get(n % (bodies.len() + 1)) {
        Some((address, body)) => client.post_text(address, body).status,
        None => client.get(plan).status,
    };
    let clients = (0..32).map(|n| {
        let client = client.clone();
        std::thread::spawn(move || (0..5).map(|i| ask(&client, n + i)).collect::<Vec<u16>>())
    });
    let clients: Vec<_> = clients.collect();
    let statuses: Vec<u16> = clients.into_iter().flat_map(|client| client.join().unwrap()).collect();
    assert!(statuses.iter().all(|status| [200, 202, 422, 429, 503].contains(status)), "{statuses:?}");
    assert!(statuses.iter().filter(|status| **status <= 422).count() > 20, "{statuses:?}");
}

/// A scan of a few hundred kilobytes that unpacks to 300 MB.
fn packed_scan(client: &Client) {
    let mut packed = Command::new("sh");
    packed.args(["-c", "head -c 300000000 /dev/zero | gzip -1"]).stdout(Stdio::piped());
    let packed = packed.output().unwrap().stdout;
    assert!((100_000..10_000_000).contains(&packed.len()));
    let packed: &'static [u8] = packed.leak();
    let upload = move |client: &Client| client.send("POST", "/v1/meshes?format=.nii.gz", &OCTETS, packed);
    let statuses = statuses(all(client, 3, upload));
    assert!(statuses.iter().all(|status| [400, 422, 429, 503].contains(status)), "{statuses:?}");
}

/// Heads that are read in two ways, addresses beyond the folder, ranges of all kinds.
fn hostile_heads(client: &Client, job: &str) {
    let smuggled = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET /v1/jobs HTTP/1.1\r\n\r\n";
    let twice =
        "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4\r\nContent-Length: 5\r\n\r\nabcde";
    let chunk = "POST /v1/meshes HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nfffffffffffffffff\r\n";
    for head in [smuggled, twice, chunk, "GET /\0 HTTP/1.1\r\n\r\n", "\u{16}\u{3}\u{1}"] {
        let mut stream = client.raw(head.as_bytes());
        let _ = stream.shutdown(std::net::Shutdown::Write);
        let mut text = Vec::new();
        let _ = stream.read_to_end(&mut text);
        let text = String::from_utf8_lossy(&text);
        assert!(!text.contains(" 202 ") && !text.contains(" 500 "), "{head:?}: {text}");
    }
    for path in [
        "/../../etc/passwd",
        "/viewer/..%2f..%2fetc%2fpasswd",
        "/viewer//etc/passwd",
        "/v1/meshes/..%2Fjobs.sqlite",
        "/v1/jobs/%00",
    ] {
        assert_eq!(client.get(path).status, 404, "{path}");
    }
    let recording = format!("{job}/recording");
    let many = format!("bytes={}", (0..2000).map(|i| format!("{i}-{i}")).collect::<Vec<_>>().join(","));
    for range in [
        "bytes=99999999999999999999-",
        "bytes=-0",
        "bytes=5-1",
        "lines=1-2",
        "bytes=0-18446744073709551615",
        &many,
    ] {
        let status = client.get_with(&recording, &[("Range", range)]).status;
        assert!([200, 206, 400, 416, 431].contains(&status), "{range:.40}: {status}");
    }
}

/// Hundreds of uploads and of streams that go no further.
fn stalled_connections(client: &Client, job: &str) {
    let upload =
        format!("POST /v1/meshes HTTP/1.1\r\nHost: {}\r\nContent-Length: 1000\r\n\r\n$", client.address);
    let stream = format!("GET {job}/events HTTP/1.1\r\nHost: {}\r\n\r\n", client.address);
    let open: Vec<TcpStream> =
        (0..512).map(|i| client.raw(if i % 2 == 0 { &upload } else { &stream }.as_bytes())).collect();
    eventually("a short request is answered", || {
        let mut text = String::new();
        let mut stream = client.raw(b"");
        let head = format!("GET /healthz HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", client.address);
        let _ = stream.write_all(head.as_bytes());
        let _ = stream.read_to_string(&mut text);
        text.starts_with("HTTP/1.1 200")
    });
    drop(open);
    eventually("there is room again", || client.get("/healthz").status == 200);
}

/// Large scenes to validate, and questions whose cases take more memory than there is; a small job meanwhile.
fn greedy_jobs(client: &Client) {
    let large: &'static str = ball_on_block(40).to_string().leak();
    let validations = all(client, 12, move |client| client.post_text("/v1/jobs/validate", large));
    std::thread::sleep(Duration::from_millis(200));
    let begun = Instant::now();
    let innocent = submit(client, &ball_on_block(2));
    assert!(begun.elapsed() < Duration::from_secs(15), "{:?}", begun.elapsed());
    let question = json!({
        "scene": ball_on_block(48),
        "parameters": [{ "name": "speed", "change": { "kind": "speed_m_per_s" }, "low": 9, "high": 11 }],
        "one_at_a_time": true,
    });
    let ask = |_| {
        let mut answer = None;
        eventually("a question is validated", || {
            answer = Some(client.post_json("/v1/what-if", &question)).filter(|answer| answer.status != 503);
            answer.is_some()
        });
        answer.unwrap()
    };
    let asked: Vec<Answer> = (0..2).map(ask).collect();
    let statuses = statuses(validations);
    assert!(statuses.iter().all(|status| [200, 429, 503].contains(status)), "{statuses:?}");
    wait_for(client, &innocent, "succeeded");
    for answer in asked {
        assert_eq!(answer.status, 202, "{answer:?}");
        let end = wait_for(client, answer.header("location").unwrap(), "failed");
        assert_eq!(end["failure"]["cause"], "out_of_memory", "{end}");
    }
}

#[test]
fn attacks_of_all_kinds_leave_the_service_as_it_was() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path(), &["--max-running-memory", "120M"]);
    let client = &program.client;
    let (job, before) = finished(client, &ball_on_block(2));
    let attack = |name: &str, attack: &dyn Fn()| {
        attack();
        let peak = program.peak_memory();
        assert!(peak < MOST_MEMORY, "{name}: {peak} bytes");
    };
    attack("hostile bodies", &|| hostile_bodies(client));
    attack("many large bodies", &|| many_large_bodies(client));
    let kept = program.resident_memory();
    assert!(kept < MOST_KEPT, "{kept} bytes");
    attack("packed scan", &|| packed_scan(client));
    attack("hostile heads", &|| hostile_heads(client, &job));
    attack("stalled connections", &|| stalled_connections(client, &job));
    attack("greedy jobs", &|| greedy_jobs(client));
    assert_eq!(client.get(&job).json(), before);
    assert_eq!(client.get(&format!("{job}/recording")).status, 200);
    let metrics = client.get("/metrics").text();
    for line in metrics.lines().filter(|line| line.starts_with("contuse_http_requests_total")) {
        assert!(!line.contains("status=\"5") || line.contains("status=\"503\""), "{line}");
    }
    assert!(metrics.lines().any(|line| line == "contuse_run_panics_total 0"), "{metrics}");
    assert!(metrics.lines().any(|line| line == "contuse_processes 0"), "{metrics}");
}
