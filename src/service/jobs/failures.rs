//! Why jobs fail, beyond what a run says of itself.

use super::JobsError;
use crate::scene::Problems;
use crate::step::{Failure, FailureCause};

/// A job that lost its worker so often.
pub fn worker_lost(attempts: u32) -> Failure {
    Failure::of_no_run(FailureCause::WorkerLost, format!("the process that ran it was lost {attempts} times"))
}

/// A fault of the program. What it was is in the log and not for the world.
pub fn internal() -> Failure {
    Failure {
        remedy: "Report it with the id of the job and the log of the service around its end.".into(),
        ..Failure::of_no_run(FailureCause::Internal, "A fault of the program stopped the run.")
    }
}

/// A scene that was valid when it was accepted.
pub(super) fn invalid_scene(problems: &Problems) -> Failure {
    let errors = problems.0.iter().filter(|problem| problem.is_error());
    let errors: Vec<String> = errors.map(|p| format!("{}: {}", p.pointer, p.message)).collect();
    Failure::of_no_run(FailureCause::InvalidScene, format!("The scene cannot run: {}", errors.join("; ")))
}

/// A study that was stopped by its deadline.
pub(super) fn out_of_time() -> Failure {
    let message = "The wall-clock budget of the job ran out; the summary has what was done until then.";
    Failure {
        remedy:
            "Ask for fewer or coarser meshes and fewer settings, or ask the operator for a longer deadline."
                .into(),
        ..Failure::of_no_run(FailureCause::Deadline, message)
    }
}

/// A study without a run that finished.
pub(super) fn nothing_finished() -> Failure {
    let message = "No run of the study came to its end; the summary says why of each.";
    Failure {
        remedy: "Run the scene by itself first.".into(),
        ..Failure::of_no_run(FailureCause::InvalidScene, message)
    }
}

/// A recording that could not be kept. Paths of the server stay in the log.
pub(super) fn recording_failed(error: &JobsError) -> Failure {
    let reason = error.io_kind().map_or_else(|| "the store failed".to_owned(), |kind| kind.to_string());
    let message = format!("The recording could not be kept: {reason}.");
    Failure {
        remedy: "Look at the free space of the data folder; delete old jobs; submit the scene again.".into(),
        ..Failure::of_no_run(FailureCause::RecordingFailed, message)
    }
}

/// What a run says of its failure, without what is not for the world: the system names the path of a file.
pub(super) fn for_the_world(failure: Failure) -> Failure {
    if failure.cause != FailureCause::RecordingFailed {
        return failure;
    }
    tracing::error!(reason = failure.message, "a recording failed");
    Failure { message: "The recording could not be written.".into(), ..failure }
}
