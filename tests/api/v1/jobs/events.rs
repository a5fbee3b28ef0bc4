//! `GET /v1/jobs/{id}/events`

use crate::support::*;
use serde_json::json;

#[test]
fn life_of_a_job_is_reported_in_order_and_then_ends() {
    let server = Server::start();
    let client = server.client();
    let job = submit(&client, &json!({ "name": "slow", "end_time_s": 1.0, "steps": 300, "step_ms": 2 }));
    let events: Vec<_> = client.follow(&format!("{job}/events"), None).collect();
    let ids: Vec<u64> = events.iter().map(|e| e.id).collect();
    assert_eq!(ids, (1..=events.len() as u64).collect::<Vec<_>>());
    let kinds: Vec<&str> = events.iter().map(|e| e.kind.as_str()).collect();
    assert_eq!(kinds[..2], ["queued", "running"]);
    assert_eq!(*kinds.last().unwrap(), "succeeded");
    let progress: Vec<f64> = events
        .iter()
        .filter(|e| e.kind == "progress")
        .map(|e| e.data["progress"].as_f64().unwrap())
        .collect();
    assert!(progress.len() >= 3, "{progress:?}");
    assert!(progress.is_sorted());
}

#[test]
fn stream_goes_on_where_it_broke_off() {
    let server = Server::start();
    let client = server.client();
    let (job, _) = finished(&client, &quick());
    let address = format!("{job}/events");
    let all: Vec<_> = client.follow(&address, None).collect();
    let rest: Vec<_> = client.follow(&address, Some(2)).collect();
    assert_eq!(rest, all[2..]);
    let last = all.last().unwrap().id.to_string();
    assert_eq!(client.get_with(&address, &[("Last-Event-ID", &last)]).status, 204, "nothing is left");
    for bad in ["x", "-1", ""] {
        problem(&client.get_with(&address, &[("Last-Event-ID", bad)]), 400, "bad-header");
    }
}

#[test]
fn events_outlive_the_process() {
    let server = Server::start();
    let (job, _) = finished(&server.client(), &quick());
    let before: Vec<_> = server.client().follow(&format!("{job}/events"), None).collect();
    let again = Server::on(server.stop(), |_| {});
    let after: Vec<_> = again.client().follow(&format!("{job}/events"), None).collect();
    assert_eq!(before, after);
}

#[test]
fn silence_is_broken_by_comments() {
    let server = Server::with(|c| c.heartbeat = std::time::Duration::from_millis(50));
    let client = server.client();
    let first = submit(&client, &endless());
    wait_for(&client, &first, "running");
    let waiting = submit(&client, &quick());
    let mut events = client.follow(&format!("{waiting}/events"), None);
    assert!(events.next_block().unwrap().contains("event: queued"));
    assert!(events.next_block().unwrap().starts_with(':'));
    client.delete(&first);
    assert_eq!(events.last().unwrap().kind, "succeeded");
}

#[test]
fn stream_of_a_deleted_job_ends() {
    let server = Server::start();
    let client = server.client();
    let job = submit(&client, &endless());
    wait_for(&client, &job, "running");
    let events = client.follow(&format!("{job}/events"), None);
    client.delete(&job);
    assert!(events.last().unwrap().kind != "succeeded");
}

#[test]
fn more_events_than_a_batch_arrive() {
    let server = Server::start();
    let client = server.client();
    // Every change of the phase is an event, but these are alike: what counts is the number of listeners at once.
    let job = submit(&client, &json!({ "name": "slow", "end_time_s": 1.0, "steps": 200, "step_ms": 2 }));
    let address = format!("{job}/events");
    let received: Vec<Vec<_>> = std::thread::scope(|scope| {
        let listeners: Vec<_> =
            (0..8).map(|_| scope.spawn(|| client.follow(&address, None).collect())).collect();
        listeners.into_iter().map(|l| l.join().unwrap()).collect()
    });
    assert!(received.iter().all(|t| *t == received[0]), "all hear the same");
}
