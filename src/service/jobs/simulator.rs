//! The production engine: loads, compiles and runs scenes as the command line does.

use super::checked::Checked;
use super::engine::{CheckedScene, Engine, JsonDocument, RunOrder, RunReport, ScenePreview};
use super::failures::{for_the_world, internal, invalid_scene};
use super::spending::Spending;
use super::study_job;
use super::what_if_job::{self, SharedResults};
use super::{JobKind, Phase, Progress};
use crate::mesh::Mesh;
use crate::mesh::quality::{first_beyond_range, quality};
use crate::mesh::read::{MeshFormat, read_mesh};
use crate::plan::compile;
use crate::record::{McapRecorder, RecordingInfo, reindex_incomplete, snapshot};
use crate::scene::cost::FactorSize;
use crate::scene::elements::without_element;
use crate::scene::json::{self, Parsed};
use crate::scene::problem::Pointer;
use crate::scene::{Budget, Loaded, MeshBytes, MeshSource, MeshSourceError, Problem, Problems, load_parsed};
use crate::service::config::ServiceConfig;
use crate::service::meshes::{MeshQualityReport, MeshRefusal, MeshReport, MeshShelf, ShelfError};
use crate::step::{Ending, Failure};
use crate::study::{RunRequest, run_scene};
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::Path;
use std::time::Duration;

/// Element-steps per second of one thread beyond any known machine: a scene that would exceed the deadline even at this
/// speed is refused, without refusing any that could finish in time.
const UNREACHED_ELEMENT_STEPS_PER_SECOND: f64 = 3e7;

/// Floating-point operations per second of one thread, likewise: linear systems are solved on one thread.
const UNREACHED_FLOPS: f64 = 3e11;

/// Loads, compiles and runs scenes within a budget.
#[derive(Debug)]
pub struct Simulator {
    budget: Budget,
    deadline: Duration,
    threads: usize,
    what_if_threads: usize,
    results: SharedResults,
    checked: Checked,
}

impl Simulator {
    /// A simulator with the limits of the service.
    pub fn new(config: &ServiceConfig) -> Self {
        Self {
            budget: config.budget.clone(),
            deadline: config.deadline,
            threads: config.threads_per_job,
            what_if_threads: config.threads_per_what_if,
            results: SharedResults::default(),
            checked: Checked::new(config.workers.max(1)),
        }
    }

    pub(super) fn load(&self, scene: &Parsed, meshes: &MeshShelf) -> Result<Loaded, Problems> {
        let loaded = load_parsed(scene, meshes, &self.budget)?;
        self.too_long(&loaded, 1, "/end_time_s").map_or(Ok(loaded), |problem| Err(problem.alone()))
    }

    /// Problem of a scene whose runs cannot finish before the deadline, located in the document.
    pub(super) fn too_long(&self, loaded: &Loaded, runs: u64, place: &str) -> Option<Problem> {
        let element_steps = loaded.estimate.elements as f64 * loaded.estimate.steps as f64;
        let systems_s =
            if loaded.scene.document.integrator.is_implicit() { least_systems_s(loaded) } else { 0.0 };
        // A single run uses all threads for its elements and one for its systems; several runs are parallel.
        let of_run = |threads: usize| element_steps / (UNREACHED_ELEMENT_STEPS_PER_SECOND * threads as f64);
        let least_s = if runs > 1 {
            (of_run(1) + systems_s) * runs as f64 / self.what_if_threads as f64
        } else {
            of_run(self.threads) + systems_s
        };
        let limit_s = self.deadline.as_secs_f64();
        (least_s > limit_s).then(|| {
            let message = format!("the run would take at least {least_s:.0} s of wall time");
            let value = if runs > 1 { runs as f64 } else { loaded.scene.document.end_time_s };
            Problem::error("budget_wall_time", &Pointer::from_text(place), message)
                .value(value)
                .limit(format!("a run of at most {limit_s:.0} s"))
                .remedy(
                    "end earlier, take fewer or larger elements, or ask the operator for a longer deadline",
                )
        })
    }
}

/// Minimum time of the linear systems of implicit steps [s]: one factorisation, and one solution per step.
fn least_systems_s(loaded: &Loaded) -> f64 {
    let sizes = loaded.scene.bodies.iter().map(|b| FactorSize::of(&b.mesh));
    // A system that cannot be analysed is reported when it is compiled.
    let Ok(factor) = sizes.sum::<Result<FactorSize, _>>() else { return 0.0 };
    (factor.flops + loaded.estimate.steps as f64 * 4.0 * factor.entries) / UNREACHED_FLOPS
}

impl Simulator {
    /// Keeps the scene of a validated document for its job.
    pub(super) fn keep(&self, checked: CheckedScene, loaded: Loaded) -> CheckedScene {
        self.checked.keep(&checked.content_hash, loaded);
        checked
    }

    /// The scene of a job as validated, if that was recent; otherwise loaded again.
    pub(super) fn scene_of(
        &self,
        content_hash: &str,
        meshes: &MeshShelf,
        scene: impl FnOnce() -> Result<Parsed, Failure>,
    ) -> Result<Loaded, Failure> {
        match self.checked.take(content_hash) {
            Some(loaded) => Ok(loaded),
            None => self.load(&scene()?, meshes).map_err(|problems| invalid_scene(&problems)),
        }
    }

    /// Number of parallel cases of a what-if question.
    pub(super) fn what_if_threads(&self) -> usize {
        self.what_if_threads
    }

    /// Cache of what-if results.
    pub(super) fn results(&self) -> &SharedResults {
        &self.results
    }

    /// Budget of a run.
    pub(super) fn budget(&self) -> &Budget {
        &self.budget
    }

    /// Runs a loaded scene and reports its ending and summary.
    fn simulate(&self, loaded: &Loaded, order: &mut RunOrder<'_>) -> Result<RunReport, Failure> {
        let estimated_steps = loaded.estimate.steps;
        let mut reached = Progress::beginning(Phase::Loading);
        let spending = Spending::new(&self.budget, order.recording);
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
            Ending::Failed { failure } => for_the_world(failure).into(),
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
    fn check(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &MeshShelf,
    ) -> Result<CheckedScene, Problems> {
        match kind {
            JobKind::Simulation => {
                let loaded = self.load(&document.parsed, meshes)?;
                Ok(self.keep(checked(&loaded), loaded))
            }
            JobKind::Study => study_job::check(self, document, meshes),
            JobKind::WhatIf => what_if_job::check(self, document, meshes),
        }
    }

    fn preview(&self, scene: &JsonDocument, meshes: &MeshShelf) -> Result<ScenePreview, Problems> {
        let loaded = self.load(&scene.parsed, meshes)?;
        let plan = compile(&loaded.scene).map_err(|error| not_compilable(&error).alone())?;
        Ok(ScenePreview { checked: checked(&loaded), bodies: loaded.bodies, plan: plan.report })
    }

    fn run(&self, mut order: RunOrder<'_>) -> Result<RunReport, Failure> {
        let document = order.document;
        let parsed = || {
            json::read(document).map_err(|error| {
                invalid_scene(&Problem::error("syntax", &Pointer::root(), error.to_string()).alone())
            })
        };
        match order.kind {
            JobKind::Simulation => {
                let loaded = self.scene_of(order.content_hash, order.meshes, parsed)?;
                self.simulate(&loaded, &mut order)
            }
            JobKind::Study => study_job::run(self, parsed()?.value, &mut order),
            JobKind::WhatIf => what_if_job::run(self, &parsed()?.value, &mut order),
        }
    }

    fn mend_recording(&self, recording: &Path) -> Result<(), String> {
        reindex_incomplete(recording).map(|_| ()).map_err(|error| error.to_string())
    }

    fn snapshot(&self, recording: &Path, target: &Path) -> Result<(), String> {
        snapshot(recording, target).map(|_| ()).map_err(|error| error.to_string())
    }

    fn inspect_mesh(
        &self,
        bytes: &[u8],
        format: Option<MeshFormat>,
    ) -> Result<(MeshFormat, MeshReport), MeshRefusal> {
        let refusal = |message: String| MeshRefusal { message };
        let format = format.or_else(|| MeshFormat::sniff(bytes));
        let format =
            format.ok_or_else(|| refusal("the file begins like no format that is known here".into()))?;
        let mesh = read_mesh(bytes, format).map_err(|error| refusal(error.to_string()))?;
        if let Some(element) = first_beyond_range(&mesh) {
            return Err(refusal(format!(
                "element {element} has no size that can be computed: scale its coordinates"
            )));
        }
        let report = report(&mesh).ok_or_else(|| refusal("the mesh has no nodes".into()))?;
        Ok((format, report))
    }
}

/// Uploaded meshes by id.
impl MeshSource for MeshShelf {
    fn read(&self, name: &str, limit: u64) -> Result<MeshBytes, MeshSourceError> {
        let mesh = self.find(name).map_err(|error| match error {
            ShelfError::Unknown => MeshSourceError::NotUploaded { name: name.to_owned() },
            ShelfError::Jobs(error) => unreadable(name, &error),
        })?;
        if mesh.bytes > limit {
            return Err(MeshSourceError::TooLarge { name: name.to_owned(), bytes: mesh.bytes, limit });
        }
        let mut bytes = Vec::new();
        let opened = self.open(&mesh).map_err(|error| unreadable(name, &error))?;
        let mut blob = opened.ok_or_else(|| unreadable(name, &"it is missing"))?;
        blob.read_to_end(&mut bytes).map_err(|error| unreadable(name, &error))?;
        Ok(MeshBytes { file_name: format!("{}.{}", mesh.id, mesh.format.extension()), bytes })
    }
}

/// Error of an existing mesh that cannot be read: the log has the reason, as paths of the server are not disclosed.
fn unreadable(name: &str, error: &dyn std::fmt::Display) -> MeshSourceError {
    tracing::error!(mesh = name, %error, "a mesh cannot be read");
    MeshSourceError::Unreadable { name: name.to_owned(), reason: "the storage of the service failed".into() }
}

pub(super) fn checked(loaded: &Loaded) -> CheckedScene {
    CheckedScene {
        name: loaded.scene.document.name.clone(),
        content_hash: loaded.scene.content_hash.clone(),
        end_time_s: loaded.scene.document.end_time_s,
        warnings: loaded.warnings.clone(),
    }
}

/// Total number of steps, extrapolated from the completed fraction of the run; from the estimate while that is too
/// small.
fn expected_steps(step: u64, share: f64, estimate: u64) -> u64 {
    const SAYS_SOMETHING: f64 = 0.02;
    if share < SAYS_SOMETHING { estimate.max(step) } else { (step as f64 / share).round() as u64 }
}

/// Problem of a scene that is only found when its plan is compiled.
fn not_compilable(error: &dyn std::error::Error) -> Problem {
    Problem::error("not_compilable", &Pointer::root(), error.to_string())
}

/// Report on an uploaded mesh; `None` if it is empty.
fn report(mesh: &Mesh) -> Option<MeshReport> {
    let quality = quality(mesh)?;
    let mut elements_of_part = vec![0_u64; mesh.parts.len()];
    mesh.part_of.iter().for_each(|&part| elements_of_part[part as usize] += 1);
    let [low, high] = quality.bounding_box_m;
    Some(MeshReport {
        nodes: mesh.nodes.len() as u64,
        elements: mesh.cells.len() as u64,
        parts: mesh.parts.iter().cloned().zip(elements_of_part).collect(),
        node_sets: mesh
            .node_sets
            .iter()
            .map(|(name, set)| (name.clone(), set.len() as u64))
            .collect::<BTreeMap<_, _>>(),
        bounding_box_min: [low.x, low.y, low.z],
        bounding_box_max: [high.x, high.y, high.z],
        quality: MeshQualityReport {
            min_scaled_jacobian: quality.min_scaled_jacobian,
            worst_element: quality.worst_element,
            negative_elements: quality.negative.count as u64,
            first_negative_elements: quality.negative.first,
            folded_elements: quality.folded_corners.count as u64,
            max_aspect_ratio: Some(quality.max_aspect_ratio).filter(|ratio| ratio.is_finite()),
            coincident_nodes: quality.coincident_nodes.count as u64,
            min_edge: quality.min_edge_m,
            max_edge: quality.max_edge_m,
            volume: quality.volume_m3,
        },
        notes: mesh.notes.iter().cloned().chain(without_element(mesh)).collect(),
    })
}
