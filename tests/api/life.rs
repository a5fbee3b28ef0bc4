//! Jobs outlive the process that runs them.

use crate::found::run;
use crate::support::*;
use serde_json::json;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool};
use std::sync::Arc;
use std::time::Duration;

/// A job of that many steps, each of some milliseconds, which has begun.
fn running(server: &Server, name: &str, steps: u32, step_ms: u32) -> String {
    let scene = json!({ "name": name, "end_time_s": 1.0, "steps": steps, "step_ms": step_ms });
    let job = submit(&server.client(), &scene);
    wait_for(&server.client(), &job, "running");
    job
}

#[test]
fn one_process_has_the_data() {
    let server = Server::start();
    let path = server.data.path().to_owned();
    assert!(contuse::service::jobs::data_folder::DataFolder::open(&path).is_err());
}

#[test]
fn waiting_jobs_are_taken_up_by_the_next_process() {
    let server = Server::with(|c| c.workers = 0);
    let jobs: Vec<String> = (0..3).map(|_| submit(&server.client(), &quick())).collect();
    let again = Server::on(server.stop(), |_| {});
    for job in jobs {
        wait_for(&again.client(), &job, "succeeded");
    }
}

#[test]
fn shutdown_puts_running_jobs_back_without_counting_the_attempt() {
    let server = Server::start();
    let job = running(&server, "slow", 800, 1);
    let data = server.stop();
    let again = Server::on(data, |_| {});
    let end = wait_for(&again.client(), &job, "succeeded");
    assert_eq!(end["attempts"], 1);
    let kinds: Vec<String> = again.client().follow(&format!("{job}/events"), None).map(|e| e.kind).collect();
    let kept: Vec<&str> = kinds.iter().map(String::as_str).filter(|k| *k != "progress").collect();
    assert_eq!(kept, ["queued", "running", "requeued", "running", "succeeded"]);
}

#[test]
fn shutdown_waits_for_jobs_that_end_in_time() {
    let server = Server::with(|c| c.grace = Duration::from_secs(10));
    let job = running(&server, "short", 300, 1);
    let again = Server::on(server.stop(), |c| c.workers = 0);
    assert_eq!(again.client().get(&job).json()["state"], "succeeded");
}

#[test]
fn a_run_that_does_not_stop_is_handed_back() {
    let server = Server::start();
    running(&server, "stuck", 1, 8000);
    let data = server.stop();
    let (state, attempts) = run(async {
        let options = SqliteConnectOptions::new().filename(data.path().join("jobs.sqlite"));
        let pool = SqlitePool::connect_with(options).await.unwrap();
        let rows: (String, i64) =
            sqlx::query_as("SELECT state, attempts FROM jobs").fetch_one(&pool).await.unwrap();
        rows
    });
    assert_eq!((state.as_str(), attempts), ("queued", 0));
}

#[test]
fn shutdown_ends_event_streams() {
    let server = Server::with(|c| c.workers = 0);
    let job = submit(&server.client(), &quick());
    let mut events = server.client().follow(&format!("{job}/events"), None);
    assert_eq!(events.next().unwrap().kind, "queued");
    let _data: Arc<_> = server.stop();
    assert_eq!(events.next(), None);
}

#[test]
fn what_nothing_refers_to_is_gone_with_the_next_process() {
    let server = Server::start();
    let mesh = [("Content-Type", "application/octet-stream")];
    assert_eq!(server.client().send("POST", "/v1/meshes", &mesh, b"$MeshFormat").status, 201);
    finished(&server.client(), &quick());
    let mut kept = server.files();
    let data = server.stop();
    // A recording whose job somebody lost stays; nothing of a run, a look at one or an upload that was cut off does.
    let orphan = data.path().join("recordings/00000000-0000-7000-8000-000000000000.mcap");
    kept.push(orphan);
    for lost in [
        "runs/1.mcap.partial",
        "snapshots/1-1.mcap",
        "meshes/1.msh",
        "recordings/1.mcap.partial",
        "1-0.partial",
    ] {
        std::fs::create_dir_all(data.path().join(lost).parent().unwrap()).unwrap();
        std::fs::write(data.path().join(lost), "$").unwrap();
    }
    std::fs::write(kept.last().unwrap(), "$").unwrap();
    let again = Server::on(data, |_| {});
    let mut left = again.files();
    left.sort();
    kept.sort();
    assert_eq!(left, kept);
}
