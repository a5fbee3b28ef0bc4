//! Interface of a simulator for jobs: validate a scene, run it, repair an interrupted recording.
//!
//! The queue and the HTTP routes use only this trait, so that they can be tested without finite elements. The
//! production engine is [`super::simulator::Simulator`].

use super::control::RunControl;
use super::held_text::HeldText;
use super::store::Event;
use super::{JobId, JobKind, JobsError, Progress};
use crate::blobs::{BlobStore, hexadecimal};
use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use crate::mesh::section::{Plane, Section};
use crate::plan::PlanReport;
use crate::scene::first_impact::{Approach, FirstScene};
use crate::scene::geometry::BodyGeometry;
use crate::scene::json::{Parsed, read};
use crate::scene::problem::Pointer;
use crate::scene::summary::BodySummary;
use crate::scene::{MeshSource, MeshSourceError, Problem, Problems};
use crate::service::meshes::{MeshRefusal, MeshShelf};
use crate::step::{Ending, Failure};
use crate::study::what_if::Note;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Memory that the values of any document may take [bytes].
const LEAST_MEMORY: u64 = 16 << 20;
/// Memory beyond that for each byte of its text [bytes]: a list of numbers takes less, a list of empty objects more.
const MEMORY_PER_BYTE: u64 = 32;

/// Longest text that is parsed when it is received [bytes]. What a longer one means may take many times its memory: whoever validates it
/// parses it, in a process of its own.
const LONGEST_PARSED: usize = 64 << 10;
/// Code of the problem of a text that is not JSON, or takes too much memory.
pub const NOT_JSON: &str = "syntax";
/// Code of the problem of a document whose validation was killed, which says nothing about it.
pub const NOT_VALIDATED: &str = "not_validated";

/// A received document: its text, which is stored, and its content, parsed once if it is short.
#[derive(Debug)]
pub struct JsonDocument {
    /// Text of the document as received.
    pub text: HeldText,
    parsed: Option<Parsed>,
}

impl JsonDocument {
    /// Reads a text: parses it, or looks only whether it is JSON if it is long.
    ///
    /// # Errors
    /// If it is not JSON, or short and takes many times more memory than its text.
    pub fn read(text: HeldText) -> Result<Self, serde_json::Error> {
        if text.len() <= LONGEST_PARSED {
            let parsed = Some(read(&text, most_memory(&text))?);
            return Ok(Self { text, parsed });
        }
        serde_json::from_slice::<IgnoredAny>(&text)?;
        Ok(Self { text, parsed: None })
    }

    /// Its content and the keys that it repeats, unless it is long.
    pub fn parsed(&self) -> Option<&Parsed> {
        self.parsed.as_ref()
    }

    /// Its content and the keys that it repeats; a long one is parsed.
    ///
    /// # Errors
    /// A problem with the code [`NOT_JSON`]: a number is out of range, or it takes many times more memory than its text.
    pub fn content(&self) -> Result<Cow<'_, Parsed>, Problems> {
        if let Some(parsed) = &self.parsed {
            return Ok(Cow::Borrowed(parsed));
        }
        let parsed = read(&self.text, most_memory(&self.text));
        parsed.map(Cow::Owned).map_err(|error| not_json(&error))
    }

    /// SHA-256 of the text, hexadecimal.
    pub fn digest(&self) -> String {
        hexadecimal(&Sha256::digest(&*self.text))
    }
}

/// Memory that the values of a text may take [bytes].
fn most_memory(text: &[u8]) -> u64 {
    LEAST_MEMORY + MEMORY_PER_BYTE * text.len() as u64
}

/// The problem of a text that is not JSON, or takes too much memory.
pub fn not_json(error: &serde_json::Error) -> Problems {
    Problem::error(NOT_JSON, &Pointer::root(), error.to_string()).alone()
}

/// Properties of a scene that can run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CheckedScene {
    /// Name of the scene.
    pub name: String,
    /// Identity of the question: a digest of the document and its meshes.
    pub content_hash: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// Warnings that do not prevent a run.
    pub warnings: Vec<Problem>,
    /// Memory that its run is expected to take [bytes].
    pub memory_bytes: u64,
}

/// Preview of a scene without running it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ScenePreview {
    /// Properties of the scene.
    pub checked: CheckedScene,
    /// Bodies and their meshes.
    pub bodies: Vec<BodySummary>,
    /// Plan with what it keeps and omits, and its expected cost.
    pub plan: PlanReport,
    /// The bodies as they begin, if they were asked for and are not too large.
    pub geometry: Option<Vec<BodyGeometry>>,
}

/// Meshes that a document may name.
pub trait Meshes: MeshSource + Sync {
    /// Opens the mesh called `name` without reading it.
    ///
    /// # Errors
    /// As [`MeshSource::read`].
    fn open(&self, name: &str, limit: u64) -> Result<OpenMesh, MeshSourceError>;
}

/// A mesh that can be read.
pub struct OpenMesh {
    /// File name; its extension gives the format.
    pub file_name: String,
    /// Size of the content [bytes].
    pub bytes: u64,
    /// The bytes, read from the front once.
    pub content: Box<dyn Read + Send>,
}

/// A mesh file for a call of the engine, read from the front once.
pub struct MeshFile<'a> {
    /// The uploaded bytes, from where they begin.
    pub content: &'a mut dyn Read,
    /// Number of bytes of the upload.
    pub bytes: u64,
    /// Their format; `None`: that which they begin with.
    pub format: Option<MeshFormat>,
    /// Whether anyone waits for the answer; the call ends early if not.
    pub is_wanted: &'a dyn Fn() -> bool,
}

/// A run requested by a worker.
pub struct RunOrder<'a> {
    /// Id of the job, for the log.
    pub job: JobId,
    /// Kind of job that the document requests.
    pub kind: JobKind,
    /// Document accepted at submission.
    pub document: &'a [u8],
    /// Memory that the run may take, where the engine can limit it [bytes].
    pub most_memory: u64,
    /// Meshes that it may name.
    pub meshes: &'a dyn Meshes,
    /// Path of the complete recording; until then it is at [`crate::record::partial_path`] of that.
    pub recording: &'a Path,
    /// Number of threads for the run.
    pub threads: usize,
    /// Control for stopping the run.
    pub control: &'a RunControl,
    /// Receives the progress, as often as the engine chooses.
    pub progress: &'a mut (dyn FnMut(Progress) + Send),
    /// Receives parts of the result as they become available.
    pub emit: &'a mut dyn FnMut(&Event<'_>),
    /// Store of results by content, for all jobs.
    pub blobs: &'a Arc<dyn BlobStore>,
    /// Receives the key of every result by content, before the job reads or stores it.
    pub note_result: Note,
}

/// How a started run ended.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunReport {
    /// Ending of the run.
    pub ending: Ending,
    /// Summary as JSON text.
    pub summary: Option<String>,
    /// Progress when the run ended.
    pub progress: Progress,
}

/// An upload of which a scene is begun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedUpload {
    /// Its id, which is its name in the scene.
    pub id: String,
    /// Name of the file, which says what is in it; the id if it is not known.
    pub name: String,
    /// Its length [bytes].
    pub bytes: u64,
}

/// Interface of a simulator.
pub trait Engine: Send + Sync + 'static {
    /// Number of its processes at the moment.
    fn processes(&self) -> u64 {
        0
    }

    /// Approximate number of elements that the validation of a document makes or reads, without making any; 0 where the
    /// document does not say, `u64::MAX` if it is long. Blocks on the store: not for threads of the runtime.
    fn elements(&self, kind: JobKind, document: &JsonDocument, meshes: &MeshShelf) -> u64;

    /// Validates the document of a job without compiling its scene, and ends early if no one waits for the answer any more. The scene of
    /// a study or of a what-if question is part of its document.
    ///
    /// # Errors
    /// All problems of the document at once.
    fn check(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &MeshShelf,
        is_wanted: &dyn Fn() -> bool,
    ) -> Result<CheckedScene, Problems>;

    /// Validates a scene and compiles it, to preview its properties and its cost, `with_geometry` also its bodies, and ends early if no one
    /// waits for the answer any more.
    ///
    /// # Errors
    /// All problems of the scene at once.
    fn preview(
        &self,
        scene: &JsonDocument,
        with_geometry: bool,
        meshes: &MeshShelf,
        is_wanted: &dyn Fn() -> bool,
    ) -> Result<ScenePreview, Problems>;

    /// Runs a job to its end. The recording is closed and readable if it gives a report.
    ///
    /// # Errors
    /// The diagnosis of a run that could not begin, or that lost its process.
    fn run(&self, order: RunOrder<'_>) -> Result<RunReport, Failure>;

    /// Turns the partial recording of a lost writer into a complete file marked as incomplete.
    ///
    /// # Errors
    /// A sentence that explains why nothing of it can be read.
    fn mend_recording(&self, recording: &Path) -> Result<(), JobsError>;

    /// Writes the recording so far to `target`, as a complete file of its own.
    ///
    /// # Errors
    /// A sentence that explains why there is nothing yet.
    fn snapshot(&self, recording: &Path, target: &Path) -> Result<(), String>;

    /// Reads and checks an uploaded mesh, in the given or the detected format.
    ///
    /// # Errors
    /// Why it is not a mesh.
    fn inspect_mesh(&self, file: MeshFile<'_>) -> Result<(MeshFormat, MeshReport), MeshRefusal>;

    /// A first scene of an uploaded mesh or scan, or of several closed surfaces, whose contents follow each other in `file`; and
    /// where a ball touches it.
    ///
    /// # Errors
    /// Why there is none.
    fn first_scene(
        &self,
        file: MeshFile<'_>,
        uploads: &[NamedUpload],
        approach: &Approach,
    ) -> Result<FirstScene, MeshRefusal>;

    /// The section of an uploaded mesh or scan.
    ///
    /// # Errors
    /// Why there is none.
    fn section(&self, file: MeshFile<'_>, plane: Plane) -> Result<Section, MeshRefusal>;
}
