//! The cheaper runs that a run's error bars come from.

use super::Setting;
use super::single::{ending_name, is_stop};
use super::variant::Variants;
use crate::measure::depth_profile::DepthProfile;
use crate::measure::{Cheaper, CheaperRuns, ErrorBars, REFINEMENT};
use crate::scene::document::{ErrorBarsDocument, MeshDocument, SceneDocument};
use crate::scene::{Budget, NoFiles, Scene};
use crate::step::{Ending, Interrupt, Recorder};

/// The mesh of the cheaper runs.
const COARSE: Setting = Setting { mesh_level: -1, ..Setting::OWN };
/// The mesh that shows an order, where one is asked for.
const COARSER: Setting = Setting { mesh_level: -2, ..Setting::OWN };
/// How much looser the contact solver is.
const LOOSER: f64 = 1e3;

/// Runs what the scene asks for, or says why there are no error bars. With the stresses from each of `depths` on [m].
pub(super) fn error_bars(
    scene: &Scene,
    depths: &[f64],
    threads: usize,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> ErrorBars {
    let document = &scene.document;
    if document.solver.error_bars == ErrorBarsDocument::None {
        return ErrorBars::NotAsked;
    }
    let meshes = || document.bodies.iter().filter_map(|body| body.mesh.as_ref());
    if meshes().any(|mesh| matches!(mesh, MeshDocument::File(_))) {
        return ErrorBars::Unknown(
            "a mesh from a file is not made coarser (`contuse study error` makes it finer, which takes longer)".into(),
        );
    }
    let loose = Setting { contact_tolerance: Some(LOOSER * document.contact.tolerance), ..COARSE };
    let variants = Variants { document, source: &NoFiles, budget: &Budget::COMMAND_LINE, threads, interrupt };
    let run = |setting: Setting, longest: Option<f64>| results(&variants, setting, longest, depths);
    let runs = || {
        let coarse = run(COARSE, None)?;
        // Half of the steps that were taken, whatever had cut them: stability, strain, or the times of the fields.
        let longest = document.end_time_s / (REFINEMENT * coarse.steps as f64);
        let three_levels = document.solver.error_bars == ErrorBarsDocument::ThreeLevels;
        Ok(CheaperRuns {
            refinement: coarsening(document),
            small_steps: run(COARSE, Some(longest))?,
            loose_contact: run(loose, None)?,
            coarser: three_levels.then(|| run(COARSER, None)).transpose()?,
            coarse,
        })
    };
    runs().map_or_else(ErrorBars::Unknown, |runs| ErrorBars::From(Box::new(runs)))
}

/// The least ratio of numbers of elements between the two meshes, of those that are not one: halves are rounded up.
fn coarsening(document: &SceneDocument) -> f64 {
    let mut document = document.clone();
    let mut least = REFINEMENT;
    for body in &mut document.bodies {
        if let Some(MeshDocument::Generator(generator)) = &mut body.mesh {
            for count in generator.counts_mut().iter().filter(|count| *count.elements > 1) {
                let elements = *count.elements;
                least = least.min(f64::from(elements) / f64::from(elements.div_ceil(2)));
            }
        }
    }
    least
}

/// A run with a setting, and no step beyond `longest` [s]; it must come to its end.
fn results(
    variants: &Variants,
    setting: Setting,
    longest: Option<f64>,
    depths: &[f64],
) -> Result<Cheaper, String> {
    let mut profile = DepthProfile::new(depths.to_vec());
    let also: Option<&mut dyn Recorder> = if depths.is_empty() { None } else { Some(&mut profile) };
    let result = variants
        .run(&setting, longest, also)
        .map_err(|error| format!("no run on the coarser mesh ({}): {error}", setting.name()))?;
    match &result.outcome.ending {
        Ending::Finished => {
            Ok(Cheaper::new(result.summary.values(), profile.peaks_from_each(), result.outcome.steps))
        }
        ending => Err(match ending_name(ending) {
            stop if is_stop(&stop) => format!(
                "the run was stopped ({stop}) during the cheaper ones that error bars come from; allow more time, or leave them out \
                 (`--no-error-bars`)"
            ),
            name => format!("the run on the coarser mesh ({}) ended as {name}", setting.name()),
        }),
    }
}
