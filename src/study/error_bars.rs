//! The cheaper runs that a run's error bars come from.

use super::error::Setting;
use super::single::{RunRequest, ending_name, run_scene};
use crate::measure::{CheaperRuns, ErrorBars, Results};
use crate::scene::document::{ErrorBarsDocument, SceneDocument};
use crate::scene::{Budget, NoFiles, Scene, load};
use crate::step::{Ending, Interrupt};

/// The mesh of the cheaper runs, and the divisor of their step.
const COARSE: Setting = Setting { mesh_level: -1, ..Setting::OWN };
const SMALL_STEPS: Setting = Setting { step_divisor: crate::measure::REFINEMENT, ..COARSE };
/// How much looser the contact solver is.
const LOOSER: f64 = 1e3;

/// Runs what the scene asks for, or says why there are no error bars.
pub(super) fn error_bars(
    scene: &Scene,
    threads: usize,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> ErrorBars {
    let document = &scene.document;
    if document.solver.error_bars == ErrorBarsDocument::None {
        return ErrorBars::NotAsked;
    }
    let loose = Setting { contact_tolerance: Some(LOOSER * document.contact.tolerance), ..COARSE };
    let run = |setting: Setting| results(document, setting, threads, interrupt);
    let runs = || {
        Ok(CheaperRuns { coarse: run(COARSE)?, small_steps: run(SMALL_STEPS)?, loose_contact: run(loose)? })
    };
    runs().map_or_else(ErrorBars::Unknown, |runs| ErrorBars::From(Box::new(runs)))
}

fn results(
    document: &SceneDocument,
    setting: Setting,
    threads: usize,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> Result<Results, String> {
    let cheaper = setting.apply(document).ok_or(
        "the mesh cannot be made coarser (`contuse study error` makes it finer instead, which takes longer)",
    )?;
    let document_json = serde_json::to_vec(&cheaper).map_err(|error| error.to_string())?;
    let loaded = load(&document_json, &NoFiles, &Budget::COMMAND_LINE).map_err(|problems| {
        let first = problems.0.iter().find(|problem| problem.is_error()).map(|p| p.message.clone());
        format!("the mesh cannot be made coarser: {}", first.unwrap_or_default())
    })?;
    let request = RunRequest {
        scene: &loaded.scene,
        document_json: &document_json,
        recording: None,
        threads,
        interrupt,
        progress: &mut |_| {},
        also: None,
    };
    let result = run_scene(request).map_err(|error| error.to_string())?;
    match &result.outcome.ending {
        Ending::Finished => Ok(result.summary.values().clone()),
        ending => Err(format!("the run with {} ended as {}", setting.name(), ending_name(ending))),
    }
}
