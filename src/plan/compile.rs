//! Scene → Plan.

use super::Plan;
use crate::scene::Scene;

/// Why a validated scene could not be compiled.
#[derive(Debug, thiserror::Error)]
pub enum CompileError {}

/// Compiles a scene.
///
/// # Errors
/// See [`CompileError`].
pub fn compile(scene: &Scene) -> Result<Plan, CompileError> {
    let _ = scene;
    unimplemented!("skeleton")
}
