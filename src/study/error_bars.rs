//! A run with its error bars, and the cheaper runs that these are estimated from.

use super::setting::Setting;
use super::single::{ending_name, is_stop};
use super::variant::{NotRun, Variants};
use crate::measure::depth_profile::DepthProfile;
use crate::measure::{Cheaper, CheaperRuns, ErrorBars, Level, REFINEMENT};
use crate::scene::document::{ErrorBarsDocument, MeshDocument, SceneDocument};
use crate::scene::{Budget, NoFiles, Scene};
use crate::step::{Ending, Interrupt};
use std::f64::consts::FRAC_1_SQRT_2;

/// Numbers of elements of the coarsest mesh, and of that between it and the run's own, in units of the run's own [-]. The second
/// pair is for graded meshes whose elements would be too distorted with half of them.
const COARSER: [[f64; 2]; 2] = [[0.5, FRAC_1_SQRT_2], [FRAC_1_SQRT_2, 0.840_896_415_253_714_6]];
/// How much looser the contact solver is.
const LOOSER: f64 = 1e3;

/// Runs the requested cheaper runs, or explains why there are no error bars. Includes the stresses below each of
/// `depths` [m].
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
    if !document.has_mesh() {
        return ErrorBars::Unknown(NotRun::NoMesh.to_string());
    }
    if document.has_mesh_file() {
        return ErrorBars::Unknown(
            "a mesh from a file cannot be coarsened (`contuse study error` refines it, which takes longer)"
                .into(),
        );
    }
    let variants = Variants { document, source: &NoFiles, budget: &Budget::COMMAND_LINE, threads, interrupt };
    // One or two coarser meshes; step and contact tolerance vary on the coarsest.
    let runs = || {
        let coarser = |[coarse, between]: [f64; 2]| Ok((scene_of(&variants, coarse)?, between));
        let (mesh, between) =
            coarser(COARSER[0]).or_else(|why| coarser(COARSER[1]).map_err(|_: String| why))?;
        let coarse = results(&variants, &mesh, depths)?;
        let [small_steps, loose_contact] = step_and_contact(&variants, &mesh, coarse.steps, depths)?;
        let levels = if document.solver.error_bars == ErrorBarsDocument::ThreeLevels {
            let between = scene_of(&variants, between)?;
            let run = results(&variants, &between, depths)?;
            let size = |coarser: &Scene| relative_size(document, &coarser.document);
            vec![Level { size: size(&mesh), run: coarse }, Level { size: size(&between), run }]
        } else {
            vec![Level { size: least_relative_size(document, &mesh.document), run: coarse }]
        };
        Ok(CheaperRuns { levels, small_steps, loose_contact })
    };
    runs().map_or_else(ErrorBars::Unknown, |runs| ErrorBars::From(Box::new(runs)))
}

/// Ratios of the numbers of elements of two scenes that differ in nothing else, those that are the same in both omitted.
fn ratios(fine: &SceneDocument, coarse: &SceneDocument) -> Vec<f64> {
    let counts = |document: &SceneDocument| -> Vec<u32> {
        let meshes = document.bodies.iter().filter_map(|body| body.mesh.clone());
        let of_mesh = |mesh: MeshDocument| match mesh {
            MeshDocument::Generator(mut generator) => {
                generator.counts_mut().into_iter().map(|count| *count).collect()
            }
            MeshDocument::File(file) => vec![1_u32.checked_shl(file.refine).unwrap_or(u32::MAX)],
        };
        meshes.flat_map(of_mesh).collect()
    };
    let pairs = counts(fine).into_iter().zip(counts(coarse));
    pairs
        .filter(|(fine, coarse)| fine != coarse)
        .map(|(fine, coarse)| f64::from(fine) / f64::from(coarse))
        .collect()
}

/// Element size of a coarser scene relative to a finer one [-]: the mean over all directions, since numbers of elements
/// are rounded.
pub(super) fn relative_size(fine: &SceneDocument, coarse: &SceneDocument) -> f64 {
    let ratios = ratios(fine, coarse);
    (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len().max(1) as f64).exp()
}

/// The smallest of these ratios: a safe estimate for two meshes.
fn least_relative_size(fine: &SceneDocument, coarse: &SceneDocument) -> f64 {
    ratios(fine, coarse).into_iter().reduce(f64::min).unwrap_or(REFINEMENT)
}

/// The same scene with at most half the time step, and with a looser contact tolerance.
pub(super) fn step_and_contact(
    variants: &Variants,
    mesh: &Scene,
    steps: u64,
    depths: &[f64],
) -> Result<[Cheaper; 2], String> {
    let (mut small_steps, mut loose) = (mesh.clone(), mesh.clone());
    // Half of the actual steps, whatever limited them: stability, strain, or field times.
    small_steps.document.integrator.limit_step(mesh.document.end_time_s / (REFINEMENT * steps as f64));
    loose.document.contact.tolerance *= LOOSER;
    Ok([results(variants, &small_steps, depths)?, results(variants, &loose, depths)?])
}

/// The scene with its numbers of elements times a factor.
fn scene_of(variants: &Variants, mesh_factor: f64) -> Result<Scene, String> {
    let setting = Setting { mesh_factor, ..Setting::OWN };
    variants
        .scene(&setting, None, None)
        .map_err(|error| format!("no run on the coarser mesh ({}): {error}", setting.name()))
}

/// A run on a coarser mesh; it must finish.
fn results(variants: &Variants, mesh: &Scene, depths: &[f64]) -> Result<Cheaper, String> {
    let mut profile = DepthProfile::new(depths.to_vec());
    let result = variants
        .run_scene(mesh, Some(&mut profile))
        .map_err(|error| format!("no run on the coarser mesh: {error}"))?;
    match &result.outcome.ending {
        Ending::Finished => {
            Ok(Cheaper::new(result.summary.values(), profile.peaks_from_each(), result.outcome.steps))
        }
        ending => Err(match ending_name(ending) {
            stop if is_stop(&stop) => format!(
                "the run was stopped ({stop}) during the cheaper ones that error bars come from; allow more time, or leave them out \
                 (`--no-error-bars`)"
            ),
            name => format!("a run on the coarser mesh ended as {name}"),
        }),
    }
}
