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
fn what_the_storage_does_not_let_go_is_removed_later() {
    let server = Server::start();
    let client = server.client();
    let (job, _) = finished(&client, &quick());
    let (kept, _) = finished(&client, &quick());
    let pending = |server: &Server| {
        let metrics = server.client().get("/metrics").text();
        let line = metrics.lines().find_map(|line| line.strip_prefix("contuse_removals_pending "));
        line.unwrap().to_owned()
    };
    // A folder in its place is no file that could be removed.
    let id = job.rsplit('/').next().unwrap();
    let files = server.files();
    let recording = files.iter().find(|path| path.to_str().unwrap().contains(id)).unwrap();
    std::fs::remove_file(recording).unwrap();
    std::fs::create_dir(recording).unwrap();
    assert_eq!((client.delete(&job).status, pending(&server)), (204, "1".into()));
    problem(&client.get(&job), 404, "job-not-found");
    // Nor does the next process forget it.
    let again = Server::on(server.stop(), |_| {});
    assert_eq!(pending(&again), "1");
    std::fs::remove_dir(recording).unwrap();
    eventually("it is removed", || pending(&again) == "0");
    assert_eq!(again.client().get(&kept).status, 200);
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
