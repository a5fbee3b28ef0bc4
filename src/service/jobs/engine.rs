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

impl SceneProblem {
    /// An error about the document as a whole.
    pub fn of_document(message: &str) -> Self {
        Self {
            severity: "error".into(),
            code: "not_compilable".into(),
            pointer: String::new(),
            message: message.to_owned(),
            value: serde_json::Value::Null,
            limit: String::new(),
            remedy: String::new(),
        }
    }
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
    /// Nodes.
    pub nodes: u64,
    /// Elements.
    pub elements: u64,
    /// Volume of the mesh [m³].
    pub volume_m3: f64,
    /// Mass of the mesh [kg].
    pub mass_kg: f64,
    /// Lower and upper corner of the box around it [m].
    pub bounding_box_m: [[f64; 3]; 2],
    /// Smallest scaled Jacobian of all corners and quadrature points, 1 for a brick [-].
    pub min_scaled_jacobian: f64,
    /// The element where that is.
    pub worst_element: u32,
    /// Largest ratio of longest to shortest edge in one element [-]; null where an edge has no length.
    pub max_aspect_ratio: Option<f64>,
    /// Shortest edge [m].
    pub min_edge_m: f64,
    /// Its parts.
    pub parts: Vec<PartPreview>,
    /// What the mesh says of itself.
    pub notes: Vec<String>,
}

/// A part of a body.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PartPreview {
    /// Its name.
    pub name: String,
    /// Elements.
    pub elements: u64,
    /// Mass [kg].
    pub mass_kg: f64,
}

/// One run that a worker asks for.
pub struct RunOrder<'a> {
    /// The scene document as it was submitted.
    pub scene: &'a [u8],
    /// The meshes that it may name.
    pub meshes: &'a MeshShelf,
    /// Where the recording goes when it is whole; until then it is [`crate::record::partial_path`] of that.
    pub recording: &'a Path,
    /// Threads of the run.
    pub threads: usize,
    /// How it is stopped.
    pub control: &'a RunControl,
    /// Told how far it has come, as often as the engine likes.
    pub progress: &'a mut dyn FnMut(RunProgress),
    /// Told parts of the result as they come: the kind of the event and its data.
    pub tell: &'a mut dyn FnMut(&'static str, &serde_json::Value),
    /// Where results are kept by content, for all jobs.
    pub results: &'a Path,
}

/// How a run ended that began.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// How it ended.
    pub ending: RunEnding,
    /// Its summary, as JSON text.
    pub summary: Option<String>,
    /// How far it came.
    pub progress: RunProgress,
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

    /// Judges a study of a scene.
    ///
    /// # Errors
    /// Every problem of the study and its scene at once.
    fn check_study(&self, study: &[u8], meshes: &MeshShelf) -> Result<CheckedScene, Vec<SceneProblem>>;

    /// Judges a what-if question, whose base is a scene in it.
    ///
    /// # Errors
    /// Every problem of the question and its scene at once.
    fn check_what_if(&self, question: &[u8], meshes: &MeshShelf) -> Result<CheckedScene, Vec<SceneProblem>>;

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

    /// Makes a whole recording of the partial one that a lost writer left, and marks it incomplete.
    ///
    /// # Errors
    /// A sentence that says why nothing of it can be read.
    fn mend_recording(&self, recording: &Path) -> Result<(), String>;

    /// Writes what a recording has so far to `target`, a whole file of its own.
    ///
    /// # Errors
    /// A sentence that says why there is nothing yet.
    fn snapshot(&self, recording: &Path, target: &Path) -> Result<(), String>;

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
