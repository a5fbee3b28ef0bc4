//! Failures of jobs other than those of runs.

use super::JobsError;
use crate::scene::Problems;
use crate::step::{Failure, FailureCause};
use std::any::Any;

/// A job that lost its worker too often.
pub fn worker_lost(attempts: u32) -> Failure {
    Failure::of_no_run(FailureCause::WorkerLost, format!("the process that ran it was lost {attempts} times"))
}

/// A run that panicked. Its words are logged, and not disclosed.
pub(super) fn panicked(payload: &(dyn Any + Send)) -> Failure {
    let words = payload.downcast_ref::<&str>().copied();
    let words = words.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    tracing::error!(panic = words.unwrap_or("no words"), "a fault of the program");
    panic_elsewhere()
}

/// A run that panicked in its process, which has logged its words.
pub(super) fn panic_elsewhere() -> Failure {
    Failure::of_no_run(FailureCause::Panicked, "A defect of the program stopped the run: it panicked.")
}

/// A run that was refused memory beyond what it may take.
pub(super) fn out_of_memory(most_bytes: u64) -> Failure {
    let most = most_bytes / 1_000_000;
    let message = format!("The run needed more memory than its limit of {most} MB.");
    Failure::of_no_run(FailureCause::OutOfMemory, message)
}

/// A run whose process was killed or crashed.
pub(super) fn killed(how: &str) -> Failure {
    Failure::of_no_run(FailureCause::Killed, format!("The process of the run was lost: {how}."))
}

/// A defect of the program. Details are in the log, and are not disclosed.
pub fn internal() -> Failure {
    Failure {
        remedy: "Report this with the id of the job and the service log around its end.".into(),
        ..Failure::of_no_run(FailureCause::Internal, "A defect of the program stopped the run.")
    }
}

/// A job whose row in the store is damaged.
pub(super) fn unreadable() -> Failure {
    Failure {
        remedy:
            "Submit the job again, and report it to the operator: `contuse doctor` lists what is damaged."
                .into(),
        ..Failure::of_no_run(FailureCause::Internal, "The job store is damaged: it cannot read this job.")
    }
}

/// A scene that has become invalid since it was accepted.
pub(super) fn invalid_scene(problems: &Problems) -> Failure {
    let errors = problems.0.iter().filter(|problem| problem.is_error());
    let errors: Vec<String> = errors.map(|p| format!("{}: {}", p.pointer, p.message)).collect();
    Failure::of_no_run(FailureCause::InvalidScene, format!("The scene cannot run: {}", errors.join("; ")))
}

/// A study stopped by its deadline.
pub(super) fn out_of_time() -> Failure {
    let message = "The wall-clock budget of the job ran out; the summary covers what was done until then.";
    Failure {
        remedy:
            "Ask for fewer or coarser meshes and fewer settings, or ask the operator for a longer deadline."
                .into(),
        ..Failure::of_no_run(FailureCause::Deadline, message)
    }
}

/// A run that did not stop at its deadline, or took more processor time than its threads have until then.
pub(super) fn beyond_deadline() -> Failure {
    Failure::of_no_run(
        FailureCause::Deadline,
        "The wall-clock budget of the job ran out; its process was ended.",
    )
}

/// A study without a finished run.
pub(super) fn nothing_finished() -> Failure {
    let message = "No run of the study finished; the summary gives the reason for each.";
    Failure {
        remedy: "Run the scene by itself first.".into(),
        ..Failure::of_no_run(FailureCause::InvalidScene, message)
    }
}

/// A recording that could not be stored. Paths of the server stay in the log.
pub(super) fn recording_failed(error: &JobsError) -> Failure {
    let reason = error.io_kind().map_or_else(|| "the store failed".to_owned(), |kind| kind.to_string());
    let message = format!("The recording could not be kept: {reason}.");
    Failure {
        remedy: "Check the free space of the data folder; delete old jobs; submit the scene again.".into(),
        ..Failure::of_no_run(FailureCause::RecordingFailed, message)
    }
}

/// What is said of a recording for which the disk had no room.
const NO_ROOM: &str = "The recording could not be written: the disk was full.";

/// Whether the disk had no room for a recording, be it that others took it.
pub(super) fn lacked_room(failure: &Failure) -> bool {
    failure.cause == FailureCause::RecordingFailed && failure.message == NO_ROOM
}

/// Removes from the failure of a run what must not be disclosed: the system's message contains the path of a file.
pub(super) fn without_paths(failure: Failure) -> Failure {
    if failure.cause != FailureCause::RecordingFailed {
        return failure;
    }
    tracing::error!(reason = failure.message, "a recording failed");
    let is_full = failure.message.contains(&std::io::Error::from(rustix::io::Errno::NOSPC).to_string());
    let message = if is_full { NO_ROOM } else { "The recording could not be written." };
    Failure { message: message.into(), ..failure }
}
