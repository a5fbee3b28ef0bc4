//! One run of a scene document with another setting of the numerics: what every study is made of.

use super::setting::Setting;
use super::single::{RunError, RunRequest, RunResult, run_with_error_bars};
use crate::measure::ErrorBars;
use crate::mesh::MeshError;
use crate::scene::document::{Generator, MeshDocument, SceneDocument};
use crate::scene::{Budget, MeshSource, Problems, Scene, load_document, on_meshes_of};
use crate::step::{Interrupt, Recorder};

/// The scene, and what each of its runs may have.
#[derive(Clone, Copy)]
pub(super) struct Variants<'a> {
    /// The scene.
    pub document: &'a SceneDocument,
    /// Its meshes.
    pub source: &'a dyn MeshSource,
    /// What a run may cost.
    pub budget: &'a Budget,
    /// Threads of each run.
    pub threads: usize,
    /// Asked before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
}

/// Why a setting was not run.
#[derive(Debug, thiserror::Error)]
pub(super) enum NotRun {
    /// The setting has no mesh.
    #[error("the mesh cannot be made so coarse, or there is none")]
    NoSuchMesh,
    /// Splitting on the facets is nothing else.
    #[error("no generator of the scene knows a curved surface")]
    NoCurvedSurface,
    /// The scene with the setting is refused.
    #[error("{}", .0.first_error().map_or_else(|| .0.to_string(), ToString::to_string))]
    Refused(Problems),
    /// Its meshes cannot be split.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// It cannot be compiled.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl Variants<'_> {
    /// Runs the scene with a setting, and no step beyond `longest` [s]. A run that failed is a result.
    pub fn run(&self, setting: &Setting, longest: Option<f64>) -> Result<RunResult, NotRun> {
        if setting.on_facets {
            if !self.document.bodies.iter().any(|body| body.mesh.as_ref().is_some_and(is_curved)) {
                return Err(NotRun::NoCurvedSurface);
            }
            // As many elements are judged by the budget.
            self.scene(&Setting { on_facets: false, ..*setting }, longest, None)?;
        }
        let mut scene = self.scene(setting, longest, None)?;
        if setting.on_facets {
            scene.split_on_facets()?;
        }
        self.run_scene(&scene, None)
    }

    /// The scene with a setting, and no step beyond `longest` [s]; with the meshes of a scene that is `like` it, if it is.
    pub fn scene(
        &self,
        setting: &Setting,
        longest: Option<f64>,
        like: Option<&Scene>,
    ) -> Result<Scene, NotRun> {
        let mut document = setting.apply(self.document).ok_or(NotRun::NoSuchMesh)?;
        if let Some(longest) = longest {
            document.integrator.limit_step(longest);
        }
        like.and_then(|scene| on_meshes_of(scene, &document, self.budget))
            .unwrap_or_else(|| load_document(document, self.source, self.budget).map(|loaded| loaded.scene))
            .map_err(NotRun::Refused)
    }

    /// Runs a scene with a setting; `also` sees every frame.
    pub fn run_scene(&self, scene: &Scene, also: Option<&mut dyn Recorder>) -> Result<RunResult, NotRun> {
        let request = RunRequest {
            scene,
            sinks: Vec::new(),
            threads: self.threads,
            interrupt: self.interrupt,
            progress: &mut |_| {},
            also: also.map(|recorder| recorder as &mut dyn Recorder),
        };
        // Settings have none of their own: they are what error bars are made of.
        Ok(run_with_error_bars(request, None, |_| ErrorBars::NotAsked)?)
    }
}

/// Whether a mesh is made by a generator whose nodes lie on a surface that its facets are not.
fn is_curved(mesh: &MeshDocument) -> bool {
    let is_flat =
        |generator: &Generator| matches!(generator, Generator::Block { .. } | Generator::LayeredBlock { .. });
    matches!(mesh, MeshDocument::Generator(generator) if !is_flat(generator))
}
