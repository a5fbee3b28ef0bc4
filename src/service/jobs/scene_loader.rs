//! Scenes of jobs: loaded within the budget of the service, once for validation and job.

use super::engine::{CheckedScene, Meshes, OpenMesh};
use super::failures::invalid_scene;
use crate::scene::cost::FactorSize;
use crate::scene::json::Parsed;
use crate::scene::problem::Pointer;
use crate::scene::{Budget, Loaded, MeshBytes, MeshSource, MeshSourceError, Problem, Problems, load_parsed};
use crate::service::config::RunConfig;
use crate::service::meshes::{MeshShelf, ShelfError};
use crate::step::Failure;
use std::io::Read as _;

/// Element-steps per second of one thread beyond any known machine: a scene that would exceed the deadline even at this
/// speed is refused, without refusing any that could finish in time.
const UNREACHED_ELEMENT_STEPS_PER_SECOND: f64 = 3e7;

/// Floating-point operations per second of one thread, likewise: linear systems are solved on one thread.
const UNREACHED_FLOPS: f64 = 3e11;

/// Loads scenes within the limits of the service.
#[derive(Debug)]
pub struct SceneLoader {
    pub(super) runs: RunConfig,
}

impl SceneLoader {
    /// Loads a scene whose run can finish before the deadline.
    pub fn load(&self, scene: &Parsed, meshes: &dyn MeshSource) -> Result<Loaded, Problems> {
        let loaded = load_parsed(scene, meshes, &self.runs.budget)?;
        self.too_long(&loaded, 1, "/end_time_s").map_or(Ok(loaded), |problem| Err(problem.alone()))
    }

    /// Problem of a scene whose runs cannot finish before the deadline, located in the document.
    pub fn too_long(&self, loaded: &Loaded, runs: u64, place: &str) -> Option<Problem> {
        let element_steps = loaded.estimate.elements as f64 * loaded.estimate.steps as f64;
        let systems_s =
            if loaded.scene.document.integrator.is_implicit() { least_systems_s(loaded) } else { 0.0 };
        // A single run uses all threads for its elements and one for its systems; several runs are parallel.
        let of_run = |threads: usize| element_steps / (UNREACHED_ELEMENT_STEPS_PER_SECOND * threads as f64);
        let least_s = if runs > 1 {
            (of_run(1) + systems_s) * runs as f64 / self.runs.threads_per_what_if as f64
        } else {
            of_run(self.runs.threads_per_job) + systems_s
        };
        let limit_s = self.runs.deadline.as_secs_f64();
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

    /// The scene of an accepted job.
    pub fn scene_of(&self, scene: &Parsed, meshes: &dyn MeshSource) -> Result<Loaded, Failure> {
        self.load(scene, meshes).map_err(|problems| invalid_scene(&problems))
    }

    /// Number of parallel cases of a what-if question.
    pub fn what_if_threads(&self) -> usize {
        self.runs.threads_per_what_if
    }

    /// Budget of a run.
    pub fn budget(&self) -> &Budget {
        &self.runs.budget
    }
}

/// Minimum time of the linear systems of implicit steps [s]: one factorisation, and one solution per step.
fn least_systems_s(loaded: &Loaded) -> f64 {
    let sizes = loaded.scene.bodies.iter().map(|b| FactorSize::of(&b.mesh));
    // A system that cannot be analysed is reported when it is compiled.
    let Ok(factor) = sizes.sum::<Result<FactorSize, _>>() else { return 0.0 };
    (factor.flops + loaded.estimate.steps as f64 * 4.0 * factor.entries) / UNREACHED_FLOPS
}

/// Uploaded meshes by id.
impl MeshSource for MeshShelf {
    fn read(&self, name: &str, limit: u64) -> Result<MeshBytes, MeshSourceError> {
        let OpenMesh { file_name, mut content, .. } = Meshes::open(self, name, limit)?;
        let mut bytes = Vec::new();
        content.read_to_end(&mut bytes).map_err(|error| unreadable(name, &error))?;
        Ok(MeshBytes { file_name, bytes })
    }
}

impl Meshes for MeshShelf {
    fn open(&self, name: &str, limit: u64) -> Result<OpenMesh, MeshSourceError> {
        let mesh = self.find(name).map_err(|error| match error {
            ShelfError::Unknown => MeshSourceError::NotUploaded { name: name.to_owned() },
            ShelfError::Jobs(error) => unreadable(name, &error),
        })?;
        if mesh.bytes > limit {
            return Err(MeshSourceError::TooLarge { name: name.to_owned(), bytes: mesh.bytes, limit });
        }
        let opened = self.content(&mesh).map_err(|error| unreadable(name, &error))?;
        let content = Box::new(opened.ok_or_else(|| unreadable(name, &"it is missing"))?);
        let file_name = format!("{}.{}", mesh.id, mesh.format.extension());
        Ok(OpenMesh { file_name, bytes: mesh.bytes, content })
    }
}

/// Error of an existing mesh that cannot be read: the log has the reason, as paths of the server are not disclosed.
fn unreadable(name: &str, error: &dyn std::fmt::Display) -> MeshSourceError {
    tracing::error!(mesh = name, %error, "a mesh cannot be read");
    MeshSourceError::Unreadable { name: name.to_owned(), reason: "the storage of the service failed".into() }
}

/// What validation reports of a scene.
pub(super) fn checked(loaded: &Loaded) -> CheckedScene {
    CheckedScene {
        name: loaded.scene.document.name.clone(),
        content_hash: loaded.scene.content_hash.clone(),
        end_time_s: loaded.scene.document.end_time_s,
        warnings: loaded.warnings.clone(),
        memory_bytes: loaded.estimate.memory_bytes,
    }
}
