//! One client cannot make the others wait.

use crate::support::client::{Answer, Client};
use crate::support::*;
use contuse::service::tokens::Tokens;
use serde_json::{Value, json};
use std::time::Duration;

const ANNA: &str = "anna-0123456789abcdef";
const BERT: &str = "bert-0123456789abcdef";

/// A scene whose validation takes a while.
fn large(ms: u64) -> Value {
    let mut scene = quick();
    scene["elements"] = json!(180_000);
    scene["check_ms"] = json!(ms);
    scene
}

/// Sends many validations at once; gives their answers.
fn validations(client: &Client, scene: &Value, count: usize) -> Vec<std::thread::JoinHandle<Answer>> {
    let ask = |_| {
        let (client, scene) = (client.clone(), scene.clone());
        std::thread::spawn(move || client.post_json("/v1/jobs/validate", &scene))
    };
    let all = (0..count).map(ask).collect();
    // They arrive before what follows.
    std::thread::sleep(Duration::from_millis(300));
    all
}

#[test]
fn large_validations_do_not_delay_a_small_scene() {
    let server = Server::start();
    let all = validations(&server.client(), &large(100), 60);
    submit(&server.client(), &quick());
    // It was answered while most of the large ones, one after the other, still waited.
    let waiting = all.iter().filter(|answer| !answer.is_finished()).count();
    assert!(waiting > 30, "{waiting} of 60 wait");
    for answer in all {
        assert_eq!(answer.join().unwrap().status, 200);
    }
}

#[test]
fn a_full_queue_of_validations_refuses_and_says_when_to_come_back() {
    let server = Server::with(|c| c.max_validations_waiting = 4);
    let all = validations(&server.client(), &large(1500), 12);
    let refused = problem(&server.client().post_json("/v1/jobs/validate", &large(0)), 503, "busy");
    assert!(refused["remedy"].as_str().unwrap().contains("Retry-After"));
    assert_eq!(
        server.client().post_json("/v1/jobs/validate", &quick()).status,
        200,
        "small scenes have their own"
    );
    let answers: Vec<Answer> = all.into_iter().map(|answer| answer.join().unwrap()).collect();
    let busy: Vec<&Answer> = answers.iter().filter(|answer| answer.status == 503).collect();
    assert_eq!(busy.len(), 12 - 5, "one validates and four wait");
    assert!(busy.iter().all(|answer| answer.header("retry-after").is_some()));
}

#[test]
fn a_validation_does_not_wait_for_ever() {
    let server = Server::with(|c| c.validation_patience = Duration::from_millis(300));
    let all = validations(&server.client(), &large(1500), 1);
    problem(&server.client().post_json("/v1/jobs/validate", &large(0)), 503, "busy");
    for answer in all {
        assert_eq!(answer.join().unwrap().status, 200);
    }
}

#[test]
fn one_token_does_not_fill_the_queue() {
    let tokens = Tokens::parse(&format!("anna {ANNA}\nbert {BERT}")).unwrap();
    let server = Server::with(|c| {
        c.tokens = tokens;
        c.max_validations_waiting = 8;
    });
    let (anna, bert) = (server.client().with_token(ANNA), server.client().with_token(BERT));
    let all = validations(&anna, &large(1500), 10);
    let refused = anna.post_json("/v1/jobs/validate", &large(0));
    problem(&refused, 429, "too-many-requests");
    assert!(refused.header("retry-after").is_some());
    assert_eq!(bert.post_json("/v1/jobs/validate", &large(0)).status, 200);
    let waiting = all.iter().filter(|answer| !answer.is_finished()).count();
    assert!(waiting > 1, "after the one that validates: {waiting} wait");
    for answer in all {
        answer.join().unwrap();
    }
}

#[test]
fn memory_of_a_document_is_a_multiple_of_its_text() {
    let server = Server::start();
    let many = format!("[{}]", vec!["{\"\":0}"; 500_000].join(","));
    let refused = problem(&server.client().post_text("/v1/jobs/validate", &many), 400, "bad-json");
    assert!(refused["detail"].as_str().unwrap().contains("too much memory"), "{refused}");
}

#[test]
fn a_job_waits_until_its_memory_is_free() {
    let server = Server::with(|c| {
        c.workers = 3;
        // A run may take twice what is expected, and 256 MB.
        c.max_running_memory = 2000 + 2 * (256 << 20);
    });
    let client = server.client();
    let of = |mut scene: Value, bytes: u64| {
        scene["memory_bytes"] = json!(bytes);
        submit(&client, &scene)
    };
    // It takes more than there is, and runs alone.
    let all = of(endless(), 1 << 30);
    wait_for(&client, &all, "running");
    let half = of(endless(), 500);
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(client.get(&half).json()["state"], "queued");
    client.delete(&all);
    wait_for(&client, &half, "running");
    let more = of(quick(), 501);
    let small = of(quick(), 1);
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(client.get(&more).json()["queue_position"], 1);
    assert_eq!(client.get(&small).json()["queue_position"], 2, "no one overtakes");
    client.delete(&half);
    wait_for(&client, &more, "succeeded");
    wait_for(&client, &small, "succeeded");
}
