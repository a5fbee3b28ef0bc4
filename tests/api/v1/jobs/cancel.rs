//! `POST /v1/jobs/{id}/cancel`

use crate::support::*;

#[test]
fn running_job_stops_and_keeps_its_recording() {
    let server = Server::start();
    let client = server.client();
    let job = submit(&client, &endless());
    wait_for(&client, &job, "running");
    assert_eq!(client.post(&format!("{job}/cancel")).status, 202);
    let end = wait_for(&client, &job, "cancelled");
    assert_eq!(end["recording"]["complete"], false);
    assert_eq!(client.get(&format!("{job}/recording")).status, 200);
    assert_eq!(client.post(&format!("{job}/cancel")).status, 200, "to cancel twice changes nothing");
}

#[test]
fn waiting_job_is_cancelled_at_once() {
    let server = Server::start();
    let client = server.client();
    let first = submit(&client, &endless());
    wait_for(&client, &first, "running");
    let second = submit(&client, &quick());
    let answer = client.post(&format!("{second}/cancel"));
    assert_eq!((answer.status, answer.json()["state"].as_str()), (200, Some("cancelled")));
    let events: Vec<_> = client.follow(&format!("{second}/events"), None).map(|e| e.kind).collect();
    assert_eq!(events, ["queued", "cancelled"]);
    problem(&client.get(&format!("{second}/recording")), 404, "not-left");
}

#[test]
fn finished_job_cannot_be_cancelled() {
    let server = Server::start();
    let (job, _) = finished(&server.client(), &quick());
    problem(&server.client().post(&format!("{job}/cancel")), 409, "job-ended");
    problem(&server.client().post("/v1/jobs/nothing/cancel"), 404, "job-not-found");
    problem(&server.client().get(&format!("{job}/cancel")), 405, "method-not-allowed");
}
