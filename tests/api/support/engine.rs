//! An engine that does what the scene says, to test everything around it: how many steps, how long each takes, how it ends.

use contuse::mesh::read::MeshFormat;
use contuse::mesh::report::{MeshQualityReport, MeshReport};
use contuse::mesh::section::{Plane, Section};
use contuse::plan::PlanReport;
use contuse::record::partial_path;
use contuse::scene::first_impact::{Approach, FirstScene};
use contuse::scene::summary::BodySummary;
use contuse::scene::{Problem, Problems, problem::Pointer};
use contuse::service::jobs::engine::{
    CheckedScene, Engine, JsonDocument, MeshFile, NamedUpload, RunOrder, RunReport, ScenePreview,
};
use contuse::service::jobs::{JobKind, JobsError, Phase, Progress};
use contuse::service::meshes::{MeshRefusal, MeshShelf};
use contuse::step::{Ending, Failure, FailureCause, Interrupt};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

pub struct ScriptedEngine;

/// Counted checks at the moment, and the most that there were at the same time, in all services of
/// the process: one test alone counts.
pub static COUNTED_CHECKS: Mutex<[usize; 2]> = Mutex::new([0; 2]);

/// Checks for a while, and counts it.
fn check_counted(ms: u64) {
    {
        let mut checks = COUNTED_CHECKS.lock().unwrap();
        checks[0] += 1;
        checks[1] = checks[1].max(checks[0]);
    }
    std::thread::sleep(Duration::from_millis(ms));
    COUNTED_CHECKS.lock().unwrap()[0] -= 1;
}

#[derive(Deserialize)]
struct Script {
    end_time_s: f64,
    steps: u64,
    #[serde(default)]
    step_ms: u64,
    #[serde(default)]
    ending: Option<String>,
    #[serde(default)]
    recording_bytes: Option<usize>,
    /// The recording grows by a byte with every step.
    #[serde(default)]
    grows: bool,
    /// Where the data folder is moved when the run has ended.
    #[serde(default)]
    leaves_to: Option<PathBuf>,
}

/// What a run leaves that is killed when its recording fills the disk.
const NO_ROOM_TO_MEND: &[u8] = b"larger than the free space";

/// The bytes of a recording of the scripted engine.
pub fn recording(length: usize) -> Vec<u8> {
    (0..length).map(|i| (i * 31 % 251) as u8).collect()
}

fn problem(pointer: &str, message: &str, value: &Value) -> Problem {
    let problem = Problem::error("scripted", &Pointer::from_text(pointer), message);
    problem.value(value.clone()).limit("> 0").remedy("mend it")
}

fn failure(cause: FailureCause) -> Failure {
    let message = "as the script says".into();
    Failure { cause, message, remedy: "none".into(), time_s: Some(1e-4), step: Some(7), element: None }
}

fn report() -> MeshReport {
    let quality = MeshQualityReport {
        min_scaled_jacobian: 1.0,
        worst_element: 0,
        negative_elements: 0,
        first_negative_elements: vec![],
        folded_elements: 0,
        max_aspect_ratio: Some(1.0),
        coincident_nodes: 0,
        min_edge: 1.0,
        max_edge: 1.0,
        volume: 1.0,
    };
    MeshReport {
        nodes: 8,
        elements: 1,
        parts: BTreeMap::from([("cube".into(), 1)]),
        node_sets: BTreeMap::new(),
        bounding_box_min: [0.0; 3],
        bounding_box_max: [1.0; 3],
        quality: Some(quality),
        notes: vec![],
    }
}

impl Engine for ScriptedEngine {
    fn elements(&self, _: JobKind, document: &JsonDocument, _: &MeshShelf) -> u64 {
        document.parsed().and_then(|parsed| parsed.value["elements"].as_u64()).unwrap_or(1)
    }

    fn check(
        &self,
        kind: JobKind,
        document: &JsonDocument,
        meshes: &MeshShelf,
        is_wanted: &dyn Fn() -> bool,
    ) -> Result<CheckedScene, Problems> {
        let content = document.content()?;
        let document = &content.value;
        // The scene of a study or a question is in it.
        let document = if kind == JobKind::Simulation { document } else { &document["scene"] };
        assert!(document["panic_in_check"] != true, "as the script says");
        std::thread::sleep(Duration::from_millis(document["check_ms"].as_u64().unwrap_or(0)));
        while document["checks_while_wanted"] == true && is_wanted() {
            std::thread::sleep(Duration::from_millis(10));
        }
        if let Some(ms) = document["counted_check_ms"].as_u64() {
            check_counted(ms);
        }
        let mut problems = Vec::new();
        for (key, is_good) in [
            ("name", document["name"].is_string()),
            ("end_time_s", document["end_time_s"].as_f64().is_some_and(|t| t > 0.0)),
            ("steps", document["steps"].is_u64()),
        ] {
            if !is_good {
                problems.push(problem(&format!("/{key}"), "not good", &document[key]));
            }
        }
        if let Some(name) = document["mesh"].as_str()
            && meshes.find(name).is_err()
        {
            problems.push(problem("/mesh", "no such mesh", &document["mesh"]));
        }
        if !problems.is_empty() {
            return Err(Problems(problems));
        }
        Ok(CheckedScene {
            name: document["name"].as_str().unwrap().into(),
            content_hash: "0".repeat(64),
            end_time_s: document["end_time_s"].as_f64().unwrap(),
            warnings: vec![],
            memory_bytes: document["memory_bytes"].as_u64().unwrap_or(0),
        })
    }

    fn preview(
        &self,
        scene: &JsonDocument,
        _: bool,
        meshes: &MeshShelf,
        is_wanted: &dyn Fn() -> bool,
    ) -> Result<ScenePreview, Problems> {
        let checked = self.check(JobKind::Simulation, scene, meshes, is_wanted)?;
        let body = BodySummary {
            name: "cube".into(),
            nodes: 8,
            elements: 1,
            volume_m3: 1.0,
            mass_kg: 1.0,
            bounding_box_m: [[0.0; 3], [1.0; 3]],
            quality: None,
            parts: vec![],
            notes: vec![],
        };
        Ok(ScenePreview {
            checked,
            bodies: vec![body],
            plan: PlanReport { nodes: 8, ..PlanReport::default() },
            geometry: None,
        })
    }

    fn run(&self, order: RunOrder<'_>) -> Result<RunReport, Failure> {
        let script: Script = serde_json::from_slice(order.document).unwrap();
        let partial = partial_path(order.recording);
        std::fs::write(&partial, recording(script.recording_bytes.unwrap_or(1000))).unwrap();
        match script.ending.as_deref() {
            Some("panic") => panic!("as the script says, at /secret/path"),
            Some("abort") => std::process::abort(),
            Some("killed") => {
                std::fs::write(&partial, NO_ROOM_TO_MEND).unwrap();
                return Err(failure(FailureCause::Killed));
            }
            Some("refused") => return Err(failure(FailureCause::InvalidScene)),
            _ => {}
        }
        let mut progress =
            Progress { expected_steps: Some(script.steps), ..Progress::beginning(Phase::Stepping) };
        let mut ending = match script.ending.as_deref() {
            Some("failed") => failure(FailureCause::ElementInverted).into(),
            _ => Ending::Finished,
        };
        for step in 0..script.steps {
            match order.control.interrupt() {
                Some(Interrupt::Cancel) => ending = Ending::Cancelled,
                Some(Interrupt::Deadline) => ending = failure(FailureCause::Deadline).into(),
                _ => {}
            }
            if order.control.reason().is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(script.step_ms));
            if script.grows {
                std::fs::OpenOptions::new().append(true).open(&partial).unwrap().write_all(b"+").unwrap();
            }
            progress.step = step + 1;
            progress.progress = progress.step as f64 / script.steps as f64;
            progress.simulated_time_s = script.end_time_s * progress.progress;
            (order.progress)(progress);
        }
        std::fs::rename(&partial, order.recording).unwrap();
        if let Some(elsewhere) = &script.leaves_to {
            let data = order.recording.ancestors().nth(2).unwrap();
            std::fs::rename(data, elsewhere).unwrap();
        }
        let summary = Some(json!({ "peak_force_n": 42.0, "steps": progress.step }).to_string());
        Ok(RunReport { ending, summary, progress })
    }

    fn mend_recording(&self, recording: &Path) -> Result<(), JobsError> {
        let at_path = |error| JobsError::file(recording, error);
        let mut bytes = std::fs::read(partial_path(recording)).map_err(at_path)?;
        if bytes == NO_ROOM_TO_MEND {
            return Err(at_path(std::io::ErrorKind::StorageFull.into()));
        }
        bytes.extend_from_slice(b"mended");
        std::fs::write(recording, bytes).map_err(at_path)?;
        std::fs::remove_file(partial_path(recording)).map_err(at_path)
    }

    fn snapshot(&self, recording: &Path, target: &Path) -> Result<(), String> {
        std::fs::copy(partial_path(recording), target).map(|_| ()).map_err(|e| e.to_string())
    }

    fn inspect_mesh(&self, file: MeshFile<'_>) -> Result<(MeshFormat, MeshReport), MeshRefusal> {
        let mut bytes = Vec::new();
        file.content.read_to_end(&mut bytes).unwrap();
        let format = file.format.or(bytes.starts_with(b"$").then_some(MeshFormat::Gmsh));
        match format {
            Some(format) if !bytes.ends_with(b"broken") => Ok((format, report())),
            _ => Err(MeshRefusal::Invalid("line 1: not a mesh".into())),
        }
    }

    fn first_scene(
        &self,
        _: MeshFile<'_>,
        uploads: &[NamedUpload],
        _: &Approach,
    ) -> Result<FirstScene, MeshRefusal> {
        Ok(FirstScene {
            scene: json!({ "name": uploads[0].name }),
            parts: vec![],
            sets: vec![],
            touches: vec![],
        })
    }

    fn section(&self, _: MeshFile<'_>, plane: Plane) -> Result<Section, MeshRefusal> {
        Ok(Section { at: plane.at.unwrap_or(0.0), parts: vec![] })
    }
}
