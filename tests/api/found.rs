//! What is lost is found: rows, recordings, the whole store.

use crate::support::program::{Program, SERVE};
use crate::support::*;
use contuse::service::doctor::{Diagnosis, examine};
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool};
use std::path::Path;
use std::process::{Command, Stdio};

pub fn run<T>(work: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap().block_on(work)
}

/// Changes the store of a service that is not running.
pub fn change(data: &Path, statement: &'static str) {
    run(async {
        let options = SqliteConnectOptions::new().filename(data.join("jobs.sqlite"));
        let pool = SqlitePool::connect_with(options).await.unwrap();
        sqlx::query(statement).execute(&pool).await.unwrap();
        pool.close().await;
    });
}

fn diagnosis(data: &Path) -> Diagnosis {
    run(examine(&StoreAddress::in_folder(data))).unwrap()
}

#[test]
fn a_row_that_cannot_be_read_does_not_hide_the_others() {
    let server = Server::start();
    let (bad, _) = finished(&server.client(), &quick());
    let (good, _) = finished(&server.client(), &quick());
    let data = server.stop();
    assert!(diagnosis(data.path()).is_sound());
    change(data.path(), "UPDATE jobs SET warnings = '{' WHERE seq = 1");
    assert_eq!(diagnosis(data.path()).unreadable, [1]);
    let server = Server::on(data, |_| {});
    let jobs = server.client().get("/v1/jobs").json()["jobs"].clone();
    assert_eq!(jobs.as_array().unwrap().len(), 1);
    assert_eq!(jobs[0]["links"]["self"], serde_json::json!(good));
    problem(&server.client().get(&bad), 500, "internal");
    // Not even its id.
    let data = server.stop();
    change(data.path(), "UPDATE jobs SET id = 'x', state = 'running' WHERE seq = 1");
    let server = Server::on(data, |_| {});
    assert_eq!(server.client().get(&good).status, 200);
    finished(&server.client(), &quick());
}

#[test]
fn a_lost_recording_is_reported() {
    let server = Server::start();
    let (job, _) = finished(&server.client(), &quick());
    std::fs::remove_file(&server.files()[0]).unwrap();
    let data = server.stop();
    let lost = diagnosis(data.path()).without_recording;
    assert_eq!(lost.len(), 1);
    assert!(job.ends_with(&lost[0].to_string()));
    let server = Server::on(data, |_| {});
    problem(&server.client().get(&format!("{job}/recording")), 410, "recording-lost");
    assert_eq!(server.client().get(&format!("{job}/summary")).status, 200);
}

#[test]
fn a_lost_store_takes_neither_recordings_nor_meshes_with_it() {
    let server = Server::start();
    finished(&server.client(), &quick());
    let octets = [("Content-Type", "application/octet-stream")];
    server.client().send("POST", "/v1/meshes", &octets, b"$mesh");
    let mut kept = server.files();
    let data = server.stop();
    for end in ["", "-wal", "-shm"] {
        let _ = std::fs::remove_file(data.path().join(format!("jobs.sqlite{end}")));
    }
    let found = diagnosis(data.path());
    assert_eq!((found.store.len(), found.without_job.len()), (1, 1), "{found:?}");
    assert!(Path::new(&found.without_job[0].place).exists() && !data.path().join("jobs.sqlite").exists());
    let server = Server::on(data, |_| {});
    assert!(server.client().get("/v1/jobs").json()["jobs"].as_array().unwrap().is_empty());
    let mut left = server.files();
    left.sort();
    kept.sort();
    assert_eq!(left, kept);
}

#[test]
fn a_lost_log_is_reported_at_the_start_and_by_the_doctor() {
    let data = tempfile::tempdir().unwrap();
    let scene = serde_json::from_str(include_str!("../recording/small_ball_on_block.json")).unwrap();
    let program = Program::start(data.path(), &[]);
    finished(&program.client, &scene);
    program.kill();
    // Killed, with its log: nothing is lost.
    assert!(diagnosis(data.path()).is_sound());
    let program = Program::start(data.path(), &[]);
    let (job, _) = finished(&program.client, &scene);
    program.kill();
    for end in ["-wal", "-shm"] {
        std::fs::remove_file(data.path().join(format!("jobs.sqlite{end}"))).unwrap();
    }
    let copy = tempfile::tempdir().unwrap();
    assert!(
        Command::new("cp").arg("-a").arg(data.path().join(".")).arg(copy.path()).status().unwrap().success()
    );
    // The recording of the job that went with the log can still be had.
    diagnosis(copy.path());
    let found = diagnosis(copy.path());
    assert!(found.store.len() == 1 && found.store[0].contains("the log of jobs.sqlite is lost"), "{found:?}");
    assert!(found.without_job.len() == 1 && found.without_job[0].readable.is_ok(), "{found:?}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
    command.args(SERVE).arg(data.path()).stderr(Stdio::piped());
    let mut program = Program::spawn(command);
    assert_eq!(program.client.get(&job).status, 404);
    let log = program.child.stderr.take().unwrap();
    program.terminate();
    let log = std::io::read_to_string(log).unwrap();
    assert!(log.contains("the log of jobs.sqlite is lost") && log.contains("contuse doctor"), "{log}");
}

#[test]
fn a_damaged_store_is_a_finding() {
    let data = tempfile::tempdir().unwrap();
    std::fs::write(data.path().join("jobs.sqlite"), "this is no store of jobs".repeat(1000)).unwrap();
    let found = diagnosis(data.path());
    assert_eq!(found.store.len(), 1, "{found:?}");
    let busy = Server::start();
    assert!(run(examine(&StoreAddress::in_folder(busy.data.path()))).is_err(), "a service uses it");
}
