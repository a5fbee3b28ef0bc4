//! The production engine: loads, compiles and runs scenes as the command line does.

use super::engine::{
    CheckedScene, Engine, JsonDocument, MeshFile, Meshes, NamedUpload, RunOrder, RunReport, ScenePreview,
    not_json,
};
use super::failures::{internal, invalid_scene, without_paths};
use super::scene_loader::{SceneLoader, checked};
use super::scene_size;
use super::spending::Spending;
use super::study_job;
use super::what_if_job;
use super::{JobKind, JobsError, Phase, Progress};
use crate::mesh::quality::first_beyond_range;
use crate::mesh::read::stl::{ClosedSurface, read_stl};
use crate::mesh::read::{MeshFormat, read_mesh};
use crate::mesh::report::MeshReport;
use crate::mesh::section::{Plane, Section};
use crate::mesh::segmentation::LabelVolume;
use crate::mesh::segmentation::read::read_labels;
use crate::mesh::{Mesh, MeshError};
use crate::plan::compile;
use crate::record::{McapRecorder, RecordingInfo, reindex_incomplete, snapshot};
use crate::scene::febio::scene_of_febio;
use crate::scene::first_impact::{Approach, FirstScene};
use crate::scene::first_surfaces::SurfaceFile;
use crate::scene::json;
use crate::scene::problem::Pointer;
use crate::scene::{Loaded, Problem, Problems};
use crate::service::config::RunConfig;
use crate::service::meshes::{MeshRefusal, MeshShelf};
use crate::step::{Ending, Failure};
use crate::study::{RunRequest, run_scene};
use std::io::Read;
use std::path::Path;

/// Elements of the finest mesh that a run to an accuracy is expected to need, over those of the scene: twice the numbers in each direction.
const REFINED: u64 = 8;
/// Largest number of elements of a scene whose bodies are sent to be drawn.
const MOST_DRAWN: usize = 60_000;

/// Loads, compiles and runs scenes within a budget.
#[derive(Debug)]
pub struct Simulator {
    scenes: SceneLoader,
}

impl Simulator {
    /// A simulator with the limits of the service.
    pub fn new(runs: &RunConfig) -> Self {
        Self { scenes: SceneLoader { runs: runs.clone() } }
    }

    /// [`Engine::check`] on any meshes.
    pub(super) fn check_on(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &dyn Meshes,
    ) -> Result<CheckedScene, Problems> {
        let content = document.content()?;
        // For scenes the schema reports repeated keys; members read by name would silently lose one of them. Those of a document that was
        // parsed when it was received are reported there.
        let is_reported = kind == JobKind::Simulation || document.parsed().is_some();
        let repeated = if is_reported { Vec::new() } else { content.problems.clone() };
        Problems(repeated).then(match kind {
            JobKind::Simulation => self.scenes.load(&content, meshes).map(|loaded| {
                let checked = checked(&loaded);
                let refined = if loaded.scene.document.accuracy.is_some() { REFINED } else { 1 };
                let memory_bytes = checked.memory_bytes.saturating_mul(refined);
                CheckedScene { memory_bytes: memory_bytes.min(self.scenes.budget().memory_bytes), ..checked }
            }),
            JobKind::Study => study_job::check(&self.scenes, document, &content.value, meshes),
            JobKind::WhatIf => what_if_job::check(&self.scenes, document, &content.value, meshes),
        })
    }

    /// [`Engine::preview`] on any meshes.
    pub(super) fn preview_on(
        &self,
        scene: &JsonDocument,
        with_geometry: bool,
        meshes: &dyn Meshes,
    ) -> Result<ScenePreview, Problems> {
        let loaded = self.scenes.load(&*scene.content()?, meshes)?;
        let plan = compile(&loaded.scene).map_err(|error| not_compilable(&error).alone())?;
        let geometry = with_geometry.then(|| loaded.scene.geometry(MOST_DRAWN)).flatten();
        Ok(ScenePreview { checked: checked(&loaded), bodies: loaded.bodies, plan: plan.report, geometry })
    }

    /// Reads a mesh, a scan or a surface, in the given or the detected format.
    fn read_mesh_file(&self, file: MeshFile<'_>) -> Result<(MeshFormat, MeshContent), MeshRefusal> {
        let (format, bytes) = received(file)?;
        Ok((format, self.read_content(format, &bytes)?))
    }

    fn read_content(&self, format: MeshFormat, bytes: &[u8]) -> Result<MeshContent, MeshRefusal> {
        let invalid = |error: MeshError| refusal(error.to_string());
        if let Some(volume) = format.volume() {
            let labels = read_labels(bytes, volume, self.scenes.budget().mesh_bytes).map_err(invalid)?;
            Ok(MeshContent::Scan(labels))
        } else if format == MeshFormat::Stl {
            Ok(MeshContent::Surface(read_stl(bytes).map_err(invalid)?))
        } else {
            let mesh = read_mesh(bytes, format).map_err(invalid)?;
            if let Some(element) = first_beyond_range(&mesh) {
                return Err(refusal(format!(
                    "element {element} has no size that can be computed: scale its coordinates"
                )));
            }
            Ok(MeshContent::Mesh(mesh))
        }
    }

    /// Runs a loaded scene and reports its ending and summary.
    fn simulate(&self, loaded: &Loaded, order: &mut RunOrder<'_>) -> Result<RunReport, Failure> {
        let estimated_steps = loaded.estimate.steps;
        let mut reached = Progress::beginning(Phase::Loading);
        let spending = Spending::new(self.scenes.budget(), order.recording);
        // Each report updates the spending and the expected number of steps.
        let mut progress = |p: Progress| {
            spending.note(p.step);
            let expected_steps = Some(expected_steps(p.step, p.progress, estimated_steps));
            reached = Progress { expected_steps, ..p };
            (order.progress)(reached);
        };
        let info = RecordingInfo::of(&loaded.scene, order.document);
        let mut recorder = McapRecorder::new(order.recording, info);
        let result = run_scene(RunRequest {
            scene: &loaded.scene,
            sinks: vec![&mut recorder],
            also: None,
            threads: order.threads,
            interrupt: &|| order.control.interrupt().or_else(|| spending.interrupt()),
            progress: &mut progress,
        });
        let result = result.map_err(|error| invalid_scene(&not_compilable(&error).alone()))?;
        let ending = match result.outcome.ending {
            Ending::Failed { failure } => without_paths(failure).into(),
            other => other,
        };
        // The same text as attached to the recording.
        let summary = result.summary.to_json().map_err(|error| {
            tracing::error!(%error, "the summary cannot be written as JSON");
            internal()
        })?;
        Ok(RunReport { ending, summary: Some(summary), progress: reached })
    }
}

impl Engine for Simulator {
    fn elements(&self, kind: JobKind, document: &JsonDocument, meshes: &MeshShelf) -> u64 {
        document.parsed().map_or(u64::MAX, |parsed| scene_size::elements(kind, &parsed.value, meshes))
    }

    fn check(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &MeshShelf,
        _: &dyn Fn() -> bool,
    ) -> Result<CheckedScene, Problems> {
        self.check_on(kind, document, meshes)
    }

    fn preview(
        &self,
        scene: &JsonDocument,
        with_geometry: bool,
        meshes: &MeshShelf,
        _: &dyn Fn() -> bool,
    ) -> Result<ScenePreview, Problems> {
        self.preview_on(scene, with_geometry, meshes)
    }

    fn run(&self, mut order: RunOrder<'_>) -> Result<RunReport, Failure> {
        let document = order.document;
        let parsed = json::read(document, u64::MAX).map_err(|error| invalid_scene(&not_json(&error)))?;
        match order.kind {
            JobKind::Simulation => {
                let loaded = self.scenes.scene_of(&parsed, order.meshes)?;
                self.simulate(&loaded, &mut order)
            }
            JobKind::Study => study_job::run(&self.scenes, parsed.value, &mut order),
            JobKind::WhatIf => what_if_job::run(&self.scenes, &parsed.value, &mut order),
        }
    }

    fn mend_recording(&self, recording: &Path) -> Result<(), JobsError> {
        reindex_incomplete(recording).map(|_| ()).map_err(|error| match error.into_io() {
            Ok(source) => JobsError::file(recording, source),
            Err(unreadable) => JobsError::Unreadable(unreadable.to_string()),
        })
    }

    fn snapshot(&self, recording: &Path, target: &Path) -> Result<(), String> {
        snapshot(recording, target).map(|_| ()).map_err(|error| error.to_string())
    }

    fn inspect_mesh(&self, file: MeshFile<'_>) -> Result<(MeshFormat, MeshReport), MeshRefusal> {
        let (format, content) = self.read_mesh_file(file)?;
        let report = match content {
            MeshContent::Mesh(mesh) => {
                MeshReport::of(&mesh).ok_or_else(|| refusal("the mesh has no nodes".into()))?
            }
            MeshContent::Scan(labels) => MeshReport::of_scan(&labels),
            MeshContent::Surface(surface) => MeshReport::of_surface(&surface),
        };
        Ok((format, report))
    }

    fn first_scene(
        &self,
        file: MeshFile<'_>,
        uploads: &[NamedUpload],
        approach: &Approach,
    ) -> Result<FirstScene, MeshRefusal> {
        let (format, bytes) = received(file)?;
        let id = uploads.first().map_or("", |upload| upload.id.as_str());
        if format == MeshFormat::Stl {
            return Ok(FirstScene::of_surfaces(&surfaces(&bytes, uploads)?, approach));
        }
        match self.read_content(format, &bytes)? {
            MeshContent::Mesh(_) if format == MeshFormat::Febio => first_scene_of_febio(&bytes, id, approach),
            MeshContent::Mesh(mesh) => Ok(FirstScene::of_mesh(&mesh, id, approach)),
            MeshContent::Scan(labels) => {
                FirstScene::of_scan(&labels, id, approach).map_err(|error| refusal(error.to_string()))
            }
            MeshContent::Surface(_) => {
                Err(refusal("a scene of surfaces is made from all of them together".into()))
            }
        }
    }

    fn section(&self, file: MeshFile<'_>, plane: Plane) -> Result<Section, MeshRefusal> {
        let (_, content) = self.read_mesh_file(file)?;
        let cut = match content {
            MeshContent::Mesh(mesh) => Section::of_mesh(&mesh, plane),
            MeshContent::Scan(labels) => Section::of_scan(&labels, plane),
            MeshContent::Surface(surface) => Section::of_surface(&surface, plane),
        };
        cut.map_err(|error| refusal(error.to_string()))
    }
}

/// The format of a file, given or detected, and its bytes.
fn received(file: MeshFile<'_>) -> Result<(MeshFormat, Vec<u8>), MeshRefusal> {
    let MeshFile { content, bytes, format, .. } = file;
    let mut read = Vec::new();
    if let Err(error) = content.take(bytes).read_to_end(&mut read) {
        tracing::error!(%error, "an upload cannot be read");
        return Err(refusal("the storage of the service failed: send it again".into()));
    }
    let format = format.or_else(|| MeshFormat::sniff(&read));
    Ok((format.ok_or_else(|| refusal("the format of the file is unknown".into()))?, read))
}

/// The surfaces of uploads, whose bytes follow each other.
fn surfaces(mut bytes: &[u8], uploads: &[NamedUpload]) -> Result<Vec<SurfaceFile>, MeshRefusal> {
    let mut files = Vec::with_capacity(uploads.len());
    for NamedUpload { id, name, bytes: count } in uploads {
        let (own, rest) = bytes.split_at((*count as usize).min(bytes.len()));
        let surface = read_stl(own).map_err(|error| refusal(format!("{name}: {error}")))?;
        files.push(SurfaceFile { file: id.clone(), name: name.clone(), surface });
        bytes = rest;
    }
    Ok(files)
}

/// With the materials, conditions, loads and contact of the file.
fn first_scene_of_febio(bytes: &[u8], name: &str, approach: &Approach) -> Result<FirstScene, MeshRefusal> {
    let (mesh, scene) = scene_of_febio(bytes, name, None).map_err(|error| refusal(error.to_string()))?;
    let scene = scene.map_err(|problems| {
        let first = problems.first_error().map_or_else(String::new, ToString::to_string);
        refusal(format!(
            "{} thing(s) of the FEBio file have no counterpart in a scene, the first: {first}; `contuse scene from FILE.feb` names them \
             all, and `contuse convert FILE.feb mesh.msh` keeps the mesh alone",
            problems.0.len()
        ))
    })?;
    Ok(FirstScene::of_scene(&mesh, scene, approach))
}

/// What a file has in it.
enum MeshContent {
    Mesh(Mesh),
    Scan(LabelVolume),
    Surface(ClosedSurface),
}

fn refusal(message: String) -> MeshRefusal {
    MeshRefusal::Invalid(message)
}

/// Total number of steps, extrapolated from the completed fraction of the run; from the estimate while that is too
/// small.
fn expected_steps(step: u64, fraction: f64, estimate: u64) -> u64 {
    const SAYS_SOMETHING: f64 = 0.02;
    if fraction < SAYS_SOMETHING { estimate.max(step) } else { (step as f64 / fraction).round() as u64 }
}

/// Problem of a scene that is only found when its plan is compiled.
fn not_compilable(error: &dyn std::error::Error) -> Problem {
    Problem::error("not_compilable", &Pointer::root(), error.to_string())
}
