//! One run of a scene document with a different numerical setting: the building block of every study.

use super::setting::Setting;
use super::single::{RunError, RunRequest, RunResult, run_with_error_bars};
use crate::measure::ErrorBars;
use crate::mesh::MeshError;
use crate::scene::document::{Generator, MeshDocument, SceneDocument};
use crate::scene::{Budget, MeshSource, Problems, Scene, load_document, on_meshes_of};
use crate::step::{Interrupt, Recorder};

/// A scene and the resources of each of its runs.
#[derive(Clone, Copy)]
pub(super) struct Variants<'a> {
    /// Document of the scene.
    pub document: &'a SceneDocument,
    /// Source of its meshes.
    pub source: &'a dyn MeshSource,
    /// Budget of a run.
    pub budget: &'a Budget,
    /// Threads of each run.
    pub threads: usize,
    /// Called before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
}

/// Why a setting was not run.
#[derive(Debug, thiserror::Error)]
pub(super) enum NotRun {
    /// All bodies are rigid.
    #[error("there is no mesh whose error could be estimated")]
    NoMesh,
    /// The mesh cannot be coarsened that far.
    #[error("the mesh cannot be coarsened that far")]
    NoSuchMesh,
    /// Splitting on the facets makes no difference.
    #[error("no generator of the scene has a curved surface")]
    NoCurvedSurface,
    /// The scene with this setting is refused.
    #[error("{}", .0.first_error().map_or_else(|| .0.to_string(), ToString::to_string))]
    Refused(Problems),
    /// The meshes cannot be split.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The scene cannot be compiled.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl Variants<'_> {
    /// Runs the scene with a setting and steps of at most `longest` [s]. A failed run is a result.
    pub fn run(&self, setting: &Setting, longest: Option<f64>) -> Result<RunResult, NotRun> {
        if setting.on_facets {
            if !self.document.bodies.iter().any(|body| body.mesh.as_ref().is_some_and(is_curved)) {
                return Err(NotRun::NoCurvedSurface);
            }
            // The budget applies to the same number of elements.
            self.scene(&Setting { on_facets: false, ..*setting }, longest, None)?;
        }
        let mut scene = self.scene(setting, longest, None)?;
        if setting.on_facets {
            scene.split_on_facets()?;
        }
        self.run_scene(&scene, None)
    }

    /// Scene with a setting and steps of at most `longest` [s]; reuses the meshes of a scene `like` it, if given.
    pub fn scene(
        &self,
        setting: &Setting,
        longest: Option<f64>,
        like: Option<&Scene>,
    ) -> Result<Scene, NotRun> {
        let without = if self.document.has_mesh() { NotRun::NoSuchMesh } else { NotRun::NoMesh };
        let mut document = setting.apply(self.document).ok_or(without)?;
        if let Some(longest) = longest {
            document.integrator.limit_step(longest);
        }
        like.and_then(|scene| on_meshes_of(scene, &document, self.budget))
            .unwrap_or_else(|| load_document(document, self.source, self.budget).map(|loaded| loaded.scene))
            .map_err(NotRun::Refused)
    }

    /// Runs a scene with a setting; `also` receives every frame.
    pub fn run_scene(&self, scene: &Scene, also: Option<&mut dyn Recorder>) -> Result<RunResult, NotRun> {
        let request = RunRequest {
            scene,
            sinks: Vec::new(),
            threads: self.threads,
            interrupt: self.interrupt,
            progress: &mut |_| {},
            also: also.map(|recorder| recorder as &mut dyn Recorder),
        };
        // Settings have no error bars of their own: error bars are estimated from them.
        Ok(run_with_error_bars(request, None, |_| ErrorBars::NotRequested)?)
    }
}

/// The scene with every element split into eight on its facets, `times` over, or the reason why there is none.
pub(super) fn split(scene: &Scene, times: u32) -> Result<Scene, String> {
    let elements = scene.element_count() as f64 * 8.0_f64.powf(f64::from(times));
    if elements > Budget::COMMAND_LINE.elements as f64 {
        return Err(format!("{elements:.0} elements are too many"));
    }
    let mut scene = scene.clone();
    (0..times).try_for_each(|_| scene.split_on_facets()).map_err(|error| error.to_string())?;
    Ok(scene)
}

/// Whether a mesh is generated with nodes on a surface that differs from its facets.
fn is_curved(mesh: &MeshDocument) -> bool {
    let is_flat =
        |generator: &Generator| matches!(generator, Generator::Block(_) | Generator::LayeredBlock(_));
    matches!(mesh, MeshDocument::Generator(generator) if !is_flat(generator))
}
