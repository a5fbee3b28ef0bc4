//! The run of a scene that people ask for: with its error bars, or to an accuracy.

use super::accuracy::run_to;
use super::error_bars::error_bars;
use super::single::{RunError, RunRequest, RunResult, run_with_error_bars};

/// Runs a scene, with the error bars that it asks for, or to the accuracy.
///
/// # Errors
/// When the scene cannot be compiled, which validation should have found. Everything later is part of the outcome.
pub fn run_scene(request: RunRequest) -> Result<RunResult, RunError> {
    let scene = request.scene;
    if let Some(asked) = &scene.document.accuracy {
        return run_to(request, asked);
    }
    run_with_error_bars(request, None, |r| error_bars(r.scene, &[], r.threads, r.interrupt))
}
