//! What comes without a request: a log that is not read, signals, a data folder that is changed.

use crate::support::program::{Program, SERVE};
use crate::support::*;
use std::process::{Command, Stdio};

/// A scene that runs for a moment.
fn small() -> serde_json::Value {
    serde_json::from_str(include_str!("../recording/small_ball_on_block.json")).unwrap()
}

/// The service on a data folder.
fn serve(data: &std::path::Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
    command.args(SERVE).arg(data);
    command
}

#[test]
fn a_log_that_no_one_reads_holds_up_nothing() {
    let data = tempfile::tempdir().unwrap();
    let mut command = serve(data.path());
    command.env("RUST_LOG", "debug").stderr(Stdio::piped());
    let program = Program::spawn(command);
    // Five times as much as the pipe takes.
    for _ in 0..400 {
        assert_eq!(program.client.get("/v1/jobs").status, 200);
    }
    finished(&program.client, &small());
    assert_eq!(program.client.get("/healthz").status, 200);
    assert!(program.terminate().success());
}

#[test]
fn a_hangup_ends_the_service_in_order_and_signals_that_mean_nothing_do_nothing() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path(), &[]);
    for name in ["USR1", "USR2", "ALRM"] {
        program.signal(name);
    }
    finished(&program.client, &small());
    assert!(program.end_by("HUP").success());
}

#[test]
fn a_second_service_is_refused_without_the_file_of_the_lock_too() {
    let data = tempfile::tempdir().unwrap();
    let [lock, runs, elsewhere] = ["lock", "runs", "elsewhere"].map(|name| data.path().join(name));
    let program = Program::start(data.path(), &[]);
    std::fs::remove_file(&lock).unwrap();
    let second = serve(data.path()).output().unwrap();
    let words = String::from_utf8_lossy(&second.stderr);
    assert!(!second.status.success() && words.contains("in use by another process"), "{words}");
    finished(&program.client, &small());
    // Now nothing would refuse it.
    std::fs::rename(&runs, &elsewhere).unwrap();
    eventually("it is not ready", || program.client.get("/readyz").status == 503);
    assert_eq!(program.client.post_json("/v1/jobs", &small()).status, 503);
    std::fs::rename(&elsewhere, &runs).unwrap();
    eventually("it is ready again", || program.client.get("/readyz").status == 200);
    finished(&program.client, &small());
}
