//! Clients that hang up before they are answered: what has begun is done to its end.

use crate::support::client::Client;
use crate::support::*;
use serde_json::Value;
use std::time::Duration;

/// Sends a request, and hangs up after so many milliseconds.
fn hang_up(client: &Client, (method, path, more): (&str, &str, &str), body: &str, after_ms: u64) {
    let head = format!(
        "{method} {path} HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\n{more}Content-Length: {}\r\n\r\n",
        client.address,
        body.len()
    );
    let stream = client.raw((head + body).as_bytes());
    std::thread::sleep(Duration::from_millis(after_ms));
    drop(stream);
}

/// Number of recordings that a server keeps.
fn recordings(server: &Server) -> usize {
    server.files().iter().filter(|file| file.extension().is_some_and(|end| end == "mcap")).count()
}

#[test]
fn a_job_whose_client_hangs_up_begins_at_once() {
    let server = Server::start();
    let client = server.client();
    for after_ms in 0..15 {
        let key = format!("key-{after_ms}");
        let (scene, header) = (quick().to_string(), format!("Idempotency-Key: {key}\r\n"));
        hang_up(&client, ("POST", "/v1/jobs", &header), &scene, after_ms);
        let headers = [("Content-Type", "application/json"), ("Idempotency-Key", key.as_str())];
        let answer = client.send("POST", "/v1/jobs", &headers, scene.as_bytes());
        assert_eq!(answer.status, 202, "{answer:?}");
        // No other job arrives meanwhile.
        wait_for(&client, answer.header("location").unwrap(), "succeeded");
    }
}

#[test]
fn a_run_stops_whose_cancellation_was_not_waited_for() {
    let server = Server::start();
    let client = server.client();
    for after_ms in 0..6 {
        let job = submit(&client, &endless());
        wait_for(&client, &job, "running");
        hang_up(&client, ("POST", &format!("{job}/cancel"), ""), "", after_ms);
        std::thread::sleep(Duration::from_millis(50));
        if client.get(&job).json()["cancel_requested"] != Value::Bool(true) {
            client.post(&format!("{job}/cancel"));
        }
        wait_for(&client, &job, "cancelled");
    }
}

#[test]
fn files_go_whose_deletion_was_not_waited_for() {
    let server = Server::start();
    let client = server.client();
    for after_ms in 0..10 {
        let (job, _) = finished(&client, &quick());
        assert_eq!(recordings(&server), 1);
        hang_up(&client, ("DELETE", &job, ""), "", after_ms);
        std::thread::sleep(Duration::from_millis(20));
        client.delete(&job);
        eventually("the recording is gone", || recordings(&server) == 0);
    }
}
