//! `DELETE /v1/jobs/{id}`

use crate::support::*;
use std::path::PathBuf;

#[test]
fn finished_job_goes_with_its_files() {
    let server = Server::start();
    let client = server.client();
    let (job, _) = finished(&client, &quick());
    assert_eq!(server.files().len(), 1);
    assert_eq!(client.delete(&job).status, 204);
    assert_eq!(server.files(), Vec::<PathBuf>::new());
    problem(&client.get(&job), 404, "job-not-found");
    problem(&client.get(&format!("{job}/events")), 404, "job-not-found");
    problem(&client.get(&format!("{job}/recording")), 404, "job-not-found");
    problem(&client.delete(&job), 404, "job-not-found");
}

#[test]
fn running_job_is_gone_at_once_and_its_files_soon() {
    let server = Server::start();
    let client = server.client();
    let job = submit(&client, &endless());
    wait_for(&client, &job, "running");
    assert_eq!(client.delete(&job).status, 204);
    problem(&client.get(&job), 404, "job-not-found");
    eventually("its files go", || server.files().is_empty());
    finished(&client, &quick());
}

#[test]
fn key_of_a_deleted_job_is_free() {
    let server = Server::start();
    let client = server.client();
    let headers = [("Content-Type", "application/json"), ("Idempotency-Key", "again")];
    let post = || client.send("POST", "/v1/jobs", &headers, quick().to_string().as_bytes());
    let first = post().header("location").unwrap().to_owned();
    client.delete(&first);
    assert_ne!(post().header("location").unwrap(), first);
}
