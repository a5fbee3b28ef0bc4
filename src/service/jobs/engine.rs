//! What jobs need of a simulator: to judge a scene, to run it, to mend a recording that was cut off.
//!
//! The queue and the HTTP routes know only this trait, so that they can be tested without finite elements. The engine
//! that ships is [`super::simulator::Simulator`].

use super::control::RunControl;
use super::{JobFailure, RunProgress};
use crate::plan::PlanReport;
use crate::service::meshes::{MeshFormat, MeshRefusal, MeshReport, MeshShelf};
use serde::{Deserialize, Serialize};
use std::path::Path;
use utoipa::ToSchema;

/// Something that is wrong, or odd, in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SceneProblem {
    /// `error` or `warning`.
    pub severity: String,
    /// Kind of the problem, stable, for programs.
    pub code: String,
    /// Where in the document, as a JSON pointer (RFC 6901); empty for the whole document.
    pub pointer: String,
    /// What is wrong.
    pub message: String,
    /// The value found; null when there is none.
    pub value: serde_json::Value,
    /// What the value must keep to.
    pub limit: String,
    /// What to do about it.
    pub remedy: String,
}

/// What is known of a scene that may run.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedScene {
    /// Its name.
    pub name: String,
    /// The name of the question: a digest of the document and its meshes.
    pub content_hash: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// What is odd, but not wrong.
    pub warnings: Vec<SceneProblem>,
}

/// What a scene would be, without running it.
#[derive(Clone, Debug)]
pub struct ScenePreview {
    /// What is known of it.
    pub checked: CheckedScene,
    /// The bodies and their meshes.
    pub bodies: Vec<BodyPreview>,
    /// What the plan keeps and leaves out, and what it will cost.
    pub plan: PlanReport,
}

/// A body of a scene, with its mesh in place.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct BodyPreview {
    /// Its name.
    pub name: String,
    /// Its mesh.
    pub mesh: MeshReport,
}

/// One run that a worker asks for.
pub struct RunOrder<'a> {
    /// The scene document as it was submitted.
    pub scene: &'a [u8],
    /// The meshes that it may name.
    pub meshes: &'a MeshShelf,
    /// Where the recording goes.
    pub recording: &'a Path,
    /// Threads of the run.
    pub threads: usize,
    /// How it is stopped.
    pub control: &'a RunControl,
    /// Told how far it has come, as often as the engine likes.
    pub progress: &'a mut dyn FnMut(RunProgress),
}

/// How a run ended that began.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// How it ended.
    pub ending: RunEnding,
    /// Its summary.
    pub summary: Option<serde_json::Value>,
    /// How far it came.
    pub progress: RunProgress,
    /// Sentences that the user should read.
    pub warnings: Vec<String>,
}

/// The ways a run ends.
#[derive(Clone, Debug, PartialEq)]
pub enum RunEnding {
    /// It reached the end time.
    Finished,
    /// It was stopped.
    Stopped,
    /// It went wrong, and this is why.
    Failed(JobFailure),
}

/// A simulator.
pub trait Engine: Send + Sync + 'static {
    /// Judges a scene without compiling it: whether it may run.
    ///
    /// # Errors
    /// Every problem of the scene at once.
    fn check(&self, scene: &[u8], meshes: &MeshShelf) -> Result<CheckedScene, Vec<SceneProblem>>;

    /// Judges a scene and compiles it: what it would be, and what it would cost.
    ///
    /// # Errors
    /// Every problem of the scene at once.
    fn preview(&self, scene: &[u8], meshes: &MeshShelf) -> Result<ScenePreview, Vec<SceneProblem>>;

    /// Runs a scene to its end. The recording is closed and readable however it ends.
    ///
    /// # Errors
    /// The diagnosis of a run that could not begin.
    fn run(&self, order: RunOrder<'_>) -> Result<RunReport, JobFailure>;

    /// Closes a recording that was cut off by the loss of its writer, and marks it incomplete.
    ///
    /// # Errors
    /// A sentence that says why nothing of it can be read.
    fn mend_recording(&self, recording: &Path) -> Result<(), String>;

    /// Reads and judges an uploaded mesh, of the format given or of the one that it looks like.
    ///
    /// # Errors
    /// Why it is not one.
    fn inspect_mesh(
        &self,
        file: &Path,
        format: Option<MeshFormat>,
    ) -> Result<(MeshFormat, MeshReport), MeshRefusal>;
}
