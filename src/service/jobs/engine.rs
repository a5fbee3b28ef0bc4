//! What jobs need of a simulator: to judge a scene, to run it, to mend a recording that was cut off.
//!
//! The queue and the HTTP routes know only this trait, so that they can be tested without finite elements. The engine
//! that ships is [`super::simulator::Simulator`].

use super::control::RunControl;
use super::store::Event;
use super::{JobKind, Progress};
use crate::blobs::{BlobStore, hexadecimal};
use crate::mesh::read::MeshFormat;
use crate::plan::PlanReport;
use crate::scene::json::{Parsed, read};
use crate::scene::summary::BodySummary;
use crate::scene::{Problem, Problems};
use crate::service::meshes::{MeshRefusal, MeshReport, MeshShelf};
use crate::step::{Ending, Failure};
use sha2::{Digest, Sha256};
use std::path::Path;
use std::sync::Arc;

/// A document that was sent: its text, which is kept, and what it says, read once.
#[derive(Clone, Debug)]
pub struct JsonDocument {
    /// As it came.
    pub text: Vec<u8>,
    /// What it says, and the keys that it has twice.
    pub parsed: Parsed,
}

impl JsonDocument {
    /// Reads a text.
    ///
    /// # Errors
    /// When it is no JSON.
    pub fn read(text: Vec<u8>) -> Result<Self, serde_json::Error> {
        let parsed = read(&text)?;
        Ok(Self { text, parsed })
    }

    /// SHA-256 of the text, hexadecimal.
    pub fn digest(&self) -> String {
        hexadecimal(&Sha256::digest(&self.text))
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
    pub warnings: Vec<Problem>,
}

/// What a scene would be, without running it.
#[derive(Clone, Debug)]
pub struct ScenePreview {
    /// What is known of it.
    pub checked: CheckedScene,
    /// The bodies and their meshes.
    pub bodies: Vec<BodySummary>,
    /// What the plan keeps and leaves out, and what it will cost.
    pub plan: PlanReport,
}

/// One run that a worker asks for.
pub struct RunOrder<'a> {
    /// What the document asks for.
    pub kind: JobKind,
    /// The document as it was accepted.
    pub document: &'a [u8],
    /// What [`Engine::check`] called it.
    pub content_hash: &'a str,
    /// The meshes that it may name.
    pub meshes: &'a MeshShelf,
    /// Where the recording goes when it is whole; until then it is [`crate::record::partial_path`] of that.
    pub recording: &'a Path,
    /// Threads of the run.
    pub threads: usize,
    /// How it is stopped.
    pub control: &'a RunControl,
    /// Told how far it has come, as often as the engine likes.
    pub progress: &'a mut (dyn FnMut(Progress) + Send),
    /// Told parts of the result as they come.
    pub tell: &'a mut dyn FnMut(Event<'static>),
    /// Where results are kept by content, for all jobs.
    pub blobs: &'a Arc<dyn BlobStore>,
}

/// How a run ended that began.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// How it ended.
    pub ending: Ending,
    /// Its summary, as JSON text.
    pub summary: Option<String>,
    /// How far it came.
    pub progress: Progress,
}

/// A simulator.
pub trait Engine: Send + Sync + 'static {
    /// Judges what a job shall be made of, without compiling its scene: whether it may run. The scene of a study or of a what-if
    /// question stands in its document.
    ///
    /// # Errors
    /// Every problem of the document at once.
    fn check(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &MeshShelf,
    ) -> Result<CheckedScene, Problems>;

    /// Judges a scene and compiles it: what it would be, and what it would cost.
    ///
    /// # Errors
    /// Every problem of the scene at once.
    fn preview(&self, scene: &JsonDocument, meshes: &MeshShelf) -> Result<ScenePreview, Problems>;

    /// Runs a job to its end. The recording is closed and readable however it ends.
    ///
    /// # Errors
    /// The diagnosis of a run that could not begin.
    fn run(&self, order: RunOrder<'_>) -> Result<RunReport, Failure>;

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
        bytes: &[u8],
        format: Option<MeshFormat>,
    ) -> Result<(MeshFormat, MeshReport), MeshRefusal>;
}
