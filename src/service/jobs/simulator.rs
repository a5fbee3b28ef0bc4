//! The production engine: loads, compiles and runs scenes as the command line does.

use super::engine::{CheckedScene, Engine, JsonDocument, Meshes, RunOrder, RunReport, ScenePreview};
use super::failures::{internal, invalid_scene, without_paths};
use super::scene_loader::{SceneLoader, checked};
use super::scene_size;
use super::spending::Spending;
use super::study_job;
use super::what_if_job;
use super::{JobKind, Phase, Progress};
use crate::mesh::Mesh;
use crate::mesh::quality::{first_beyond_range, quality};
use crate::mesh::read::stl::{ClosedSurface, read_stl};
use crate::mesh::read::{MeshFormat, read_mesh};
use crate::mesh::segmentation::read::read_labels;
use crate::mesh::segmentation::{LabelVolume, ScanInspection};
use crate::plan::compile;
use crate::record::{McapRecorder, RecordingInfo, reindex_incomplete, snapshot};
use crate::scene::json;
use crate::scene::problem::Pointer;
use crate::scene::{Loaded, Problem, Problems};
use crate::service::config::ServiceConfig;
use crate::service::meshes::{MeshQualityReport, MeshRefusal, MeshReport, MeshShelf};
use crate::step::{Ending, Failure};
use crate::study::{RunRequest, run_scene};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// Loads, compiles and runs scenes within a budget.
#[derive(Debug)]
pub struct Simulator {
    scenes: SceneLoader,
}

impl Simulator {
    /// A simulator with the limits of the service.
    pub fn new(config: &ServiceConfig) -> Self {
        Self { scenes: SceneLoader::new(config) }
    }

    /// [`Engine::check`] on any meshes.
    pub(super) fn check_on(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &dyn Meshes,
    ) -> Result<CheckedScene, Problems> {
        match kind {
            JobKind::Simulation => Ok(checked(&self.scenes.load(&document.parsed, meshes)?)),
            JobKind::Study => study_job::check(&self.scenes, document, meshes),
            JobKind::WhatIf => what_if_job::check(&self.scenes, document, meshes),
        }
    }

    /// [`Engine::preview`] on any meshes.
    pub(super) fn preview_on(
        &self,
        scene: &JsonDocument,
        meshes: &dyn Meshes,
    ) -> Result<ScenePreview, Problems> {
        let loaded = self.scenes.load(&scene.parsed, meshes)?;
        let plan = compile(&loaded.scene).map_err(|error| not_compilable(&error).alone())?;
        Ok(ScenePreview { checked: checked(&loaded), bodies: loaded.bodies, plan: plan.report })
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
        scene_size::elements(kind, &document.parsed.value, meshes)
    }

    fn check(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &MeshShelf,
    ) -> Result<CheckedScene, Problems> {
        self.check_on(kind, document, meshes)
    }

    fn preview(&self, scene: &JsonDocument, meshes: &MeshShelf) -> Result<ScenePreview, Problems> {
        self.preview_on(scene, meshes)
    }

    fn run(&self, mut order: RunOrder<'_>) -> Result<RunReport, Failure> {
        let document = order.document;
        let parsed = json::read(document, u64::MAX).map_err(|error| {
            invalid_scene(&Problem::error("syntax", &Pointer::root(), error.to_string()).alone())
        })?;
        match order.kind {
            JobKind::Simulation => {
                let loaded = self.scenes.scene_of(&parsed, order.meshes)?;
                self.simulate(&loaded, &mut order)
            }
            JobKind::Study => study_job::run(&self.scenes, parsed.value, &mut order),
            JobKind::WhatIf => what_if_job::run(&self.scenes, &parsed.value, &mut order),
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
        content: &mut dyn Read,
        bytes: u64,
        format: Option<MeshFormat>,
    ) -> Result<(MeshFormat, MeshReport), MeshRefusal> {
        let refusal = |message: String| MeshRefusal { message };
        let mut read = Vec::new();
        if let Err(error) = content.take(bytes).read_to_end(&mut read) {
            tracing::error!(%error, "an upload cannot be read");
            return Err(refusal("the storage of the service failed: send it again".into()));
        }
        let bytes = read.as_slice();
        let format = format.or_else(|| MeshFormat::sniff(bytes));
        let format =
            format.ok_or_else(|| refusal("the file begins like no format that is known here".into()))?;
        if let Some(volume) = format.volume() {
            let labels = read_labels(bytes, volume, self.scenes.budget().mesh_bytes);
            let labels = labels.map_err(|error| refusal(error.to_string()))?;
            return Ok((format, scan_report(&labels)));
        }
        if format == MeshFormat::Stl {
            let surface = read_stl(bytes).map_err(|error| refusal(error.to_string()))?;
            return Ok((format, surface_report(&surface)));
        }
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

/// Report on an uploaded scan: its voxels count as elements, those of label n as a part `label_<n>`.
fn scan_report(volume: &LabelVolume) -> MeshReport {
    let found = ScanInspection::of(volume);
    let [low, high] = found.bounding_box_m;
    let labelled = || found.labels.iter().filter(|label| label.label != 0);
    let lengths = || found.spacing_m.into_iter();
    let volumes = labelled().map(|label| format!("label {}: {:.4e} m³", label.label, label.volume_m3));
    MeshReport {
        nodes: found.voxels.iter().map(|n| *n as u64 + 1).product(),
        elements: labelled().map(|label| label.voxels).sum(),
        parts: labelled().map(|label| (format!("label_{}", label.label), label.voxels)).collect(),
        node_sets: BTreeMap::new(),
        bounding_box_min: low,
        bounding_box_max: high,
        quality: MeshQualityReport {
            min_scaled_jacobian: 1.0,
            worst_element: 0,
            negative_elements: 0,
            first_negative_elements: Vec::new(),
            folded_elements: 0,
            max_aspect_ratio: Some(lengths().fold(0.0, f64::max) / lengths().fold(f64::INFINITY, f64::min)),
            coincident_nodes: 0,
            min_edge: lengths().fold(f64::INFINITY, f64::min),
            max_edge: lengths().fold(0.0, f64::max),
            volume: labelled().map(|label| label.volume_m3).sum(),
        },
        notes: found.notes.iter().cloned().chain(volumes).collect(),
    }
}

/// Report on an uploaded surface: its triangles count as elements.
fn surface_report(surface: &ClosedSurface) -> MeshReport {
    let edges = surface.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    let lengths = edges.map(|[a, b]| (surface.points[a as usize] - surface.points[b as usize]).norm());
    let nothing = [f64::INFINITY, f64::NEG_INFINITY];
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(nothing, |[low, high], value| [low.min(value), high.max(value)])
    };
    let [min_edge, max_edge] = range(&mut lengths.into_iter());
    let bounds: [[f64; 2]; 3] = std::array::from_fn(|i| range(&mut surface.points.iter().map(|x| x[i])));
    MeshReport {
        nodes: surface.points.len() as u64,
        elements: surface.triangles.len() as u64,
        parts: BTreeMap::new(),
        node_sets: BTreeMap::new(),
        bounding_box_min: bounds.map(|[low, _]| low),
        bounding_box_max: bounds.map(|[_, high]| high),
        quality: MeshQualityReport {
            min_scaled_jacobian: 1.0,
            worst_element: 0,
            negative_elements: 0,
            first_negative_elements: Vec::new(),
            folded_elements: 0,
            max_aspect_ratio: None,
            coincident_nodes: 0,
            min_edge,
            max_edge,
            volume: surface.volume(),
        },
        notes: vec!["a closed surface of triangles, for a rigid body".into()],
    }
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
        notes: mesh.notes.clone(),
    })
}
