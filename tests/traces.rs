//! Traces reach a collector: those of a request, and of the run of its job.

// A test fails by panicking; the client is that of the API's tests, which use more of it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::format_push_string, missing_docs, dead_code)]

#[path = "api/support/client.rs"]
mod client;
#[path = "api/support/program.rs"]
mod program;

use program::{Program, SERVE};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What a collector has received: the bodies of all requests.
type Received = Arc<Mutex<Vec<u8>>>;

/// Receives requests of a connection, which each have a body, and accepts them.
fn collect(stream: TcpStream, received: &Received) {
    let mut reader = BufReader::new(stream);
    loop {
        let (mut length, mut line) = (0, String::new());
        while reader.read_line(&mut line).is_ok_and(|count| count > 2) {
            let head = line.to_ascii_lowercase();
            if let Some(digits) = head.strip_prefix("content-length:") {
                length = digits.trim().parse().unwrap();
            }
            line.clear();
        }
        let mut body = vec![0; length];
        if length == 0 || reader.read_exact(&mut body).is_err() {
            return;
        }
        received.lock().unwrap().extend(body);
        let answer = b"HTTP/1.1 200 OK\r\nContent-Type: application/x-protobuf\r\nContent-Length: 0\r\n\r\n";
        reader.get_mut().write_all(answer).unwrap();
    }
}

/// A collector of traces on loopback, with its address.
fn collector() -> (String, Received) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (address, received) = (listener.local_addr().unwrap(), Received::default());
    let collected = Arc::clone(&received);
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let received = Arc::clone(&collected);
            std::thread::spawn(move || collect(stream, &received));
        }
    });
    (format!("http://{address}"), received)
}

fn count(bytes: &[u8], sought: &[u8]) -> usize {
    bytes.windows(sought.len()).filter(|window| *window == sought).count()
}

#[test]
fn a_trace_goes_from_the_client_to_the_run_of_its_job() {
    let (address, received) = collector();
    let data = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
    command.args(SERVE).arg(data.path()).env("OTEL_EXPORTER_OTLP_ENDPOINT", address);
    let program = Program::spawn(command);
    let trace: Vec<u8> = (0xa0..0xb0).collect();
    let traceparent = format!("00-{}-00f067aa0ba902b7-01", contuse::blobs::hexadecimal(&trace));
    let headers = [("Content-Type", "application/json"), ("traceparent", &traceparent)];
    let scene = include_bytes!("recording/small_ball_on_block.json");
    let answer = program.client.send("POST", "/v1/jobs", &headers, scene);
    assert_eq!(answer.status, 202, "{answer:?}");
    let job = answer.header("location").unwrap().to_owned();
    let limit = Instant::now() + Duration::from_secs(120);
    while program.client.get(&job).json()["state"] != "succeeded" {
        assert!(Instant::now() < limit, "it does not end");
        std::thread::sleep(Duration::from_millis(20));
    }
    // Sends what is left.
    assert!(program.terminate().success());
    let bytes = received.lock().unwrap();
    assert!(count(&bytes, b"contuse") > 0, "{} bytes", bytes.len());
    // Of the request and what it waits for, and of the run, which began when the request had been answered.
    for name in ["POST /v1/jobs", "validation", "store", "run", "simulation", "recording"] {
        assert!(count(&bytes, name.as_bytes()) > 0, "{name} is not among the spans");
    }
    assert!(count(&bytes, &trace) >= 6, "all of one trace: {}", count(&bytes, &trace));
}
