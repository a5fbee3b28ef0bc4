//! What an owner may keep and ask for, and whose job is next.

use crate::support::client::{Answer, Client, read_answer};
use crate::support::*;
use contuse::service::tokens::Tokens;
use serde_json::json;
use std::io::{BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

const ANNA: &str = "anna-0123456789abcdef";
const BERT: &str = "bert-0123456789abcdef";

fn tokens() -> Tokens {
    Tokens::parse(&format!("anna {ANNA}\nbert {BERT}")).unwrap()
}

/// Clients of two owners.
fn both(server: &Server) -> (Client, Client) {
    (server.client().with_token(ANNA), server.client().with_token(BERT))
}

/// Submits a quick scene with a priority.
fn submit_with(client: &Client, priority: &str) -> String {
    let headers = [("Content-Type", "application/json"), ("Job-Priority", priority)];
    let answer = client.send("POST", "/v1/jobs", &headers, quick().to_string().as_bytes());
    assert_eq!(answer.status, 202, "{answer:?}");
    assert_eq!(answer.json()["priority"], priority);
    answer.header("location").unwrap().to_owned()
}

#[test]
fn one_owner_does_not_keep_the_others_waiting() {
    let server = Server::with(|c| c.tokens = tokens());
    let (anna, bert) = both(&server);
    let running = submit(&anna, &endless());
    wait_for(&anna, &running, "running");
    let many: Vec<String> = (0..20).map(|_| submit(&anna, &endless())).collect();
    let own = submit(&bert, &quick());
    // The position is that among one's own jobs: it says nothing of others.
    assert_eq!(bert.get(&own).json()["queue_position"], 1);
    assert_eq!(anna.get(&many[19]).json()["queue_position"], 20);
    anna.delete(&running);
    wait_for(&bert, &own, "succeeded");
}

#[test]
fn an_owner_orders_own_jobs_by_priority() {
    let server = Server::with(|c| c.workers = 0);
    let client = server.client();
    let jobs = ["low", "normal", "high", "normal"].map(|priority| submit_with(&client, priority));
    let position = |job: &String| client.get(job).json()["queue_position"].as_u64().unwrap();
    assert_eq!(jobs.each_ref().map(position), [4, 2, 1, 3]);
    let headers = [("Content-Type", "application/json"), ("Job-Priority", "urgent")];
    let refused = client.send("POST", "/v1/jobs", &headers, quick().to_string().as_bytes());
    assert!(problem(&refused, 400, "bad-header")["detail"].as_str().unwrap().contains("`high`"));
}

#[test]
fn a_queue_is_not_full_of_the_jobs_of_one_owner() {
    let server = Server::with(|c| {
        (c.workers, c.max_queued, c.tokens) = (0, 8, tokens());
    });
    let (anna, bert) = both(&server);
    submit(&anna, &quick());
    submit(&anna, &quick());
    let refused = anna.post_json("/v1/jobs", &quick());
    problem(&refused, 429, "too-many-requests");
    assert!(refused.header("retry-after").is_some());
    submit(&bert, &quick());
}

#[test]
fn an_owner_keeps_no_more_than_the_quota() {
    let server = Server::with(|c| {
        (c.max_jobs_per_owner, c.max_bytes_per_owner, c.tokens) = (Some(2), Some(5000), tokens());
    });
    let (anna, bert) = both(&server);
    let mut large = quick();
    large["recording_bytes"] = json!(4800);
    let (job, _) = finished(&anna, &large);
    let octets = [("Content-Type", "application/octet-stream")];
    let mesh = [b"$".as_slice(), &[b' '; 500]].concat();
    let upload = |client: &Client| client.send("POST", "/v1/meshes", &octets, &mesh);
    let refused = problem(&upload(&anna), 403, "quota-used");
    assert!(refused["detail"].as_str().unwrap().contains("5000 bytes"), "{refused}");
    assert!(
        server.files().iter().all(|file| !file.to_str().unwrap().contains("meshes")),
        "nothing of it stays"
    );
    // What is one's own is nothing of the others.
    assert_eq!(upload(&bert).status, 201);
    assert_eq!(anna.get("/v1/meshes").json()["meshes"], json!([]));
    finished(&anna, &quick_without_recording());
    let refused = problem(&anna.post_json("/v1/jobs", &quick_without_recording()), 403, "quota-used");
    assert!(refused["detail"].as_str().unwrap().contains("2 jobs"), "{refused}");
    anna.delete(&job);
    assert_eq!(upload(&anna).status, 201);
    submit(&anna, &quick_without_recording());
}

#[test]
fn event_streams_are_limited_for_each_owner() {
    let server = Server::with(|c| {
        (c.max_connections, c.workers, c.tokens) = (16, 0, tokens());
    });
    let (anna, bert) = both(&server);
    let [of_anna, of_bert] = [&anna, &bert].map(|client| format!("{}/events", submit(client, &quick())));
    let mut open: Vec<_> = (0..3).map(|_| anna.follow(&of_anna, None)).collect();
    let refused = anna.get(&of_anna);
    assert!(refused.header("retry-after").is_some());
    problem(&refused, 429, "too-many-requests");
    // Both are behind the same address.
    open.push(bert.follow(&of_bert, None));
    drop(open);
    eventually("those who leave make room", || {
        let stream = anna.raw(
            format!("GET {of_anna} HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {ANNA}\r\n\r\n").as_bytes(),
        );
        let mut status = [0; 12];
        (&stream).read_exact(&mut status).unwrap();
        status.ends_with(b"200")
    });
}

/// The answer to an upload that has begun.
fn answer_to(upload: &TcpStream) -> Answer {
    read_answer(&mut BufReader::new(upload), false)
}

#[test]
fn uploads_under_way_count_for_the_quota() {
    let server = Server::with(|c| (c.max_bytes_per_owner, c.tokens) = (Some(100_000), tokens()));
    let (anna, bert) = both(&server);
    // Refused before any of it is sent.
    problem(&answer_to(&anna.begin_upload(Some(100_001))), 403, "quota-used");
    let under_way = anna.begin_upload(Some(60_000));
    std::thread::sleep(Duration::from_millis(500));
    let mut refused = None;
    eventually("one more is beyond the quota", || {
        let second = anna.begin_upload(Some(50_000));
        second.set_read_timeout(Some(Duration::from_millis(300))).unwrap();
        let is_answered = second.peek(&mut [0]).is_ok_and(|length| length > 0);
        refused = is_answered.then(|| answer_to(&second));
        is_answered
    });
    let refused = refused.unwrap();
    assert!(refused.header("retry-after").is_some());
    let refused = problem(&refused, 429, "too-many-requests");
    assert!(refused["detail"].as_str().unwrap().contains("60000 bytes"), "{refused}");
    // So is one that does not say how much it is, as soon as it is too much.
    let mut unknown = anna.begin_upload(None);
    let chunk = [b"1000\r\n".as_slice(), &[b'$'; 0x1000], b"\r\n"].concat();
    unknown.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
    while unknown.peek(&mut [0]).is_err() {
        unknown.write_all(&chunk).unwrap();
    }
    problem(&answer_to(&unknown), 429, "too-many-requests");
    let mesh = vec![b'$'; 50_000];
    let upload = |client: &Client| {
        client.send("POST", "/v1/meshes", &[("Content-Type", "application/octet-stream")], &mesh).status
    };
    assert_eq!(upload(&bert), 201);
    drop(under_way);
    eventually("those who leave make room", || upload(&anna) == 201);
}

#[test]
fn an_owner_asks_no_more_often_than_one_may() {
    let server = Server::with(|c| (c.max_requests_per_s, c.tokens) = (1, tokens()));
    let (anna, bert) = both(&server);
    let answers: Vec<_> = (0..12).map(|_| anna.get("/v1/jobs")).collect();
    assert!(answers[..10].iter().all(|answer| answer.status == 200), "those of ten seconds");
    problem(&answers[11], 429, "too-many-requests");
    let wait_s: u64 = answers[11].header("retry-after").unwrap().parse().unwrap();
    assert!((1..=2).contains(&wait_s));
    assert_eq!(bert.get("/v1/jobs").status, 200);
    std::thread::sleep(std::time::Duration::from_secs(wait_s));
    assert_eq!(anna.get("/v1/jobs").status, 200);
}

fn quick_without_recording() -> serde_json::Value {
    let mut scene = quick();
    scene["recording_bytes"] = json!(1);
    scene
}

/// A document that says that it has 4 MB, and of which no more comes than what makes it hold memory.
fn slow_document(client: &Client, token: &str) -> TcpStream {
    let head = format!(
        "POST /v1/jobs HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {token}\r\nContent-Type: application/json\r\nContent-Length: 4000000\r\n\r\n",
        client.address
    );
    client.raw((head + &" ".repeat(100_000)).as_bytes())
}

#[test]
fn slow_documents_of_one_owner_do_not_delay_those_of_others() {
    let server = Server::with(|c| c.tokens = tokens());
    let (anna, bert) = both(&server);
    let slow: Vec<TcpStream> = (0..20).map(|_| slow_document(&anna, ANNA)).collect();
    std::thread::sleep(Duration::from_millis(500));
    let large = quick().to_string() + &" ".repeat(3_900_000);
    let begun = Instant::now();
    assert_eq!(bert.post_text("/v1/jobs", &large).status, 202);
    assert!(begun.elapsed() < Duration::from_secs(4), "{:?}", begun.elapsed());
    // One more of the same owner waits for a while, and is refused.
    let refused = anna.post_text("/v1/jobs", &large);
    problem(&refused, 429, "too-many-requests");
    assert!(refused.header("retry-after").is_some());
    drop(slow);
    eventually("those who leave make room", || anna.post_text("/v1/jobs", &large).status == 202);
}
