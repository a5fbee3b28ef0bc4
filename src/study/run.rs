//! A requested run of a scene: with its error bars, or to an accuracy.

use super::accuracy::run_to;
use super::error_bars::error_bars;
use super::single::{RunError, RunRequest, RunResult, run_with_error_bars};

/// Runs a scene with the requested error bars, or to the requested accuracy.
///
/// # Errors
/// If the scene cannot be compiled, which validation should have found. Everything later is part of the outcome.
pub fn run_scene(request: RunRequest) -> Result<RunResult, RunError> {
    let scene = request.scene;
    let has_mesh = scene.document.bodies.iter().any(|body| body.mesh.is_some());
    if let Some(requested) = scene.document.accuracy.as_ref().filter(|_| has_mesh) {
        return run_to(request, requested);
    }
    run_with_error_bars(request, None, |r| error_bars(r.scene, &[], r.threads, r.interrupt))
}
