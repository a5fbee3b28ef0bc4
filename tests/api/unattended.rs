//! What comes without a request: a log that is not read, signals.

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
