//! A requested run of a scene: with its error bars, or to an accuracy.

use super::accuracy::run_to;
use super::error_bars::error_bars;
use super::process::process_cpu_s;
use super::single::{RunError, RunRequest, RunResult, run_with_error_bars};
use std::time::Instant;

/// Runs a scene with the requested error bars, or to the requested accuracy.
///
/// # Errors
/// If the scene cannot be compiled, which validation should have found. Everything later is part of the outcome.
pub fn run_scene(request: RunRequest) -> Result<RunResult, RunError> {
    let scene = request.scene;
    let has_mesh = scene.document.bodies.iter().any(|body| body.mesh.is_some());
    if let Some(requested) = scene.document.accuracy.as_ref().filter(|_| has_mesh) {
        let (wall, cpu) = (Instant::now(), process_cpu_s());
        let result = run_to(request, requested)?;
        // The time of all meshes.
        let cpu_s = process_cpu_s().zip(cpu).map(|(end, start)| end - start);
        return Ok(RunResult { wall_s: wall.elapsed().as_secs_f64(), cpu_s, ..result });
    }
    run_with_error_bars(request, None, |r| error_bars(r.scene, &[], r.threads, r.interrupt))
}
