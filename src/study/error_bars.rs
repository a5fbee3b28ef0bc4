//! The runs that the error bars of a run are estimated from: on coarser meshes, or on a split one where the mesh cannot be
//! coarsened.

use super::setting::Setting;
use super::single::{ending_name, is_stop};
use super::variant::{NotRun, Variants, split};
use crate::measure::depth_profile::DepthProfile;
use crate::measure::{Compared, ComparedRuns, ErrorBars, Level, REFINEMENT};
use crate::mechanics::force::Threads;
use crate::plan::{PlanReport, compile};
use crate::scene::document::{ErrorBarsDocument, MeshDocument, SceneDocument};
use crate::scene::{Budget, Scene};
use crate::step::{Ending, Interrupt};
use std::f64::consts::FRAC_1_SQRT_2;

/// Numbers of elements of the coarsest mesh, and of that between it and the run's own, in units of the run's own [-]. The second
/// pair is for graded meshes whose elements would be too distorted with half of them, and for impacts that so few elements do not bear.
const COARSER: [[f64; 2]; 2] = [[0.5, FRAC_1_SQRT_2], [FRAC_1_SQRT_2, 0.840_896_415_253_714_6]];
/// How much looser the contact solver is.
const LOOSER: f64 = 1e3;
/// Longest time of the runs with a split mesh [s], by the table of costs, so that the same scenes have error bars on every
/// machine: the time that an accuracy takes by default.
const MOST_S: f64 = 60.0;
/// Time of a run with every element split, in units of that of the run itself [-]: eight times the elements at least.
const FEWEST_TIMES: f64 = 8.0;
/// Time of the other runs in the same unit [-]: the run itself, with half its steps, and with a looser contact tolerance.
const OWN_RUNS: f64 = 4.0;

/// Makes the runs that error bars come from, or explains why there are no error bars. Includes the stresses below each of
/// `depths` [m].
pub(super) fn error_bars(
    scene: &Scene,
    depths: &[f64],
    threads: usize,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> ErrorBars {
    let document = &scene.document;
    if document.solver.error_bars == ErrorBarsDocument::None {
        return ErrorBars::NotRequested;
    }
    if !document.has_mesh() {
        return ErrorBars::Unknown(NotRun::NoMesh.to_string());
    }
    let source = &scene.kept_files;
    let variants = Variants { document, source, budget: &Budget::COMMAND_LINE, threads, interrupt };
    let runs = if document.has_mesh_file() {
        with_split_mesh(&variants, scene, depths)
    } else {
        with_coarser_meshes(&variants, depths)
    };
    runs.map_or_else(ErrorBars::Unknown, |runs| ErrorBars::From(Box::new(runs)))
}

/// Runs on one or two coarser meshes.
fn with_coarser_meshes(variants: &Variants, depths: &[f64]) -> Result<ComparedRuns, String> {
    let document = variants.document;
    let coarser = |[coarse, between]: [f64; 2]| {
        let mesh = scene_of(variants, coarse)?;
        let base = results(variants, &mesh, depths)?;
        Ok((mesh, base, between))
    };
    let (mesh, base, between) =
        coarser(COARSER[0]).or_else(|why| coarser(COARSER[1]).map_err(|_: String| why))?;
    let levels = if document.solver.error_bars == ErrorBarsDocument::ThreeLevels {
        let between = scene_of(variants, between)?;
        let run = results(variants, &between, depths)?;
        let size = |coarser: &Scene| relative_size(document, &coarser.document);
        vec![Level { size: size(&mesh), run: base.clone() }, Level { size: size(&between), run }]
    } else {
        vec![Level { size: least_relative_size(document, &mesh.document), run: base.clone() }]
    };
    let others = steps_and_contact(variants, (&mesh, base.steps), depths)?;
    Ok(compared_runs(document, base, others, levels))
}

/// A run with every element split into eight, for meshes that cannot be coarsened. The scene itself is run once more in
/// advance, for a twentieth of the time: step and contact tolerance are compared with it.
fn with_split_mesh(variants: &Variants, scene: &Scene, depths: &[f64]) -> Result<ComparedRuns, String> {
    let split = affordable_split(scene)?;
    let base = results(variants, scene, depths)?;
    let level = Level { size: 1.0 / REFINEMENT, run: results(variants, &split, depths)? };
    let others = steps_and_contact(variants, (scene, base.steps), depths)?;
    Ok(compared_runs(variants.document, base, others, vec![level]))
}

/// The scene with every element split into eight, if the runs for its error bars are expected to take no longer than
/// [`MOST_S`].
fn affordable_split(scene: &Scene) -> Result<Scene, String> {
    let expected_s = |scene: &Scene| match compile(scene) {
        Ok(plan) => Ok(plan.report.expected_run_time_s),
        Err(error) => Err(format!("no run with every element split: {error}")),
    };
    let check = |how: &str, seconds: f64| {
        let why = format!(
            "a mesh from a file cannot be coarsened, and the runs with every element split into eight would take {how} {seconds:.0} s \
             on one core; more than {MOST_S:.0} s are only spent on request: `--accuracy 10% --within TIME`"
        );
        (seconds <= MOST_S).then_some(()).ok_or(why)
    };
    let own_s = expected_s(scene)?;
    // A mesh that is far too large is not even split.
    check("more than", FEWEST_TIMES * own_s)?;
    let split = split(scene, 1)?;
    check("about", expected_s(&split)? + OWN_RUNS * own_s)?;
    Ok(split)
}

/// Numbers of elements of two scenes that differ in nothing else.
fn counts(fine: &SceneDocument, coarse: &SceneDocument) -> impl Iterator<Item = (u32, u32)> {
    let counts = |document: &SceneDocument| -> Vec<u32> {
        document.bodies.iter().filter_map(|body| body.mesh.as_ref()).flat_map(MeshDocument::counts).collect()
    };
    counts(fine).into_iter().zip(counts(coarse))
}

/// Whether a direction has the same number of elements in both.
pub(super) fn keeps_a_direction(fine: &SceneDocument, coarse: &SceneDocument) -> bool {
    counts(fine, coarse).any(|(fine, coarse)| fine == coarse)
}

/// Ratios of these numbers, those that are the same in both omitted.
fn ratios(fine: &SceneDocument, coarse: &SceneDocument) -> Vec<f64> {
    let pairs = counts(fine, coarse).filter(|(fine, coarse)| fine != coarse);
    pairs.map(|(fine, coarse)| f64::from(fine) / f64::from(coarse)).collect()
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

/// Two more runs on a mesh whose own run took so many steps: with at most half the time step, and with a looser contact tolerance.
pub(super) fn steps_and_contact(
    variants: &Variants,
    (mesh, steps): (&Scene, u64),
    depths: &[f64],
) -> Result<[Compared; 2], String> {
    let (mut small_steps, mut loose) = (mesh.clone(), mesh.clone());
    // Half of the actual steps, whatever limited them: stability, strain, or field times.
    small_steps.document.integrator.limit_step(mesh.document.end_time_s / (REFINEMENT * steps as f64));
    loose.document.contact.tolerance *= LOOSER;
    // Side by side: the threads of one run wait for each other at every step.
    let side_by_side = Threads::new(variants.threads.min(2)).unwrap_or(Threads::ONE);
    let variants = Variants { threads: variants.threads.div_ceil(2), ..*variants };
    let run = |mesh: &Scene| results(&variants, mesh, depths);
    let (small_steps, loose) = side_by_side.join(|| run(&small_steps), || run(&loose));
    Ok([small_steps?, loose?])
}

/// The runs on other meshes, with the two `others` on the coarsest of them, whose run is `base`.
pub(super) fn compared_runs(
    document: &SceneDocument,
    base: Compared,
    [small_steps, loose_contact]: [Compared; 2],
    levels: Vec<Level>,
) -> ComparedRuns {
    ComparedRuns {
        levels,
        on_facets: document.has_mesh_file(),
        keeps_a_direction: false,
        base,
        small_steps,
        loose_contact,
        bulk_modulus: None,
    }
}

/// The scene with its numbers of elements times a factor.
fn scene_of(variants: &Variants, mesh_factor: f64) -> Result<Scene, String> {
    let setting = Setting { mesh_factor, ..Setting::OWN };
    variants
        .scene(&setting, None, None)
        .map_err(|error| format!("no run on the coarser mesh ({}): {error}", setting.name()))
}

/// A run that the run itself is compared with.
fn results(variants: &Variants, mesh: &Scene, depths: &[f64]) -> Result<Compared, String> {
    compared(variants, mesh, depths).map(|(run, _)| run)
}

/// The same, with the report of its plan; the run must finish.
pub(super) fn compared(
    variants: &Variants,
    mesh: &Scene,
    depths: &[f64],
) -> Result<(Compared, PlanReport), String> {
    let mut profile = DepthProfile::new(depths.to_vec());
    let result = variants
        .run_scene(mesh, Some(&mut profile))
        .map_err(|error| format!("no run to compare with: {error}"))?;
    match &result.outcome.ending {
        Ending::Finished => {
            let run = Compared::new(result.summary.values(), profile.peaks_from_each(), result.outcome.steps);
            Ok((run, result.plan_report))
        }
        ending => Err(match ending_name(ending) {
            stop if is_stop(&stop) => format!(
                "the run was stopped ({stop}) during those before it that error bars come from; allow more time, or omit them \
                 (`--no-error-bars`)"
            ),
            name => format!("a run to compare with ended as {name}"),
        }),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::scene::{FolderSource, load_parsed};
    use serde_json::json;

    /// A plate of 594 elements from a file, for a time [s].
    fn plate(end_time_s: f64) -> Scene {
        let part = |name: &str| {
            json!({"part": name, "density_kg_per_m3": 1000,
                   "material": {"law": "neo_hookean", "c10_pa": 1e4, "bulk_modulus_pa": 1e6}})
        };
        let document = json!({
            "name": "plate", "end_time_s": end_time_s,
            "bodies": [{"name": "plate", "mesh": {"file": {"name": "layered_plate.msh"}},
                        "parts": [part("skin"), part("fat"), part("muscle")]}],
            "record": {"fields": [], "field_times_s": []}
        });
        let folder = FolderSource::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/meshes"));
        load_parsed(&document.into(), &folder, &Budget::COMMAND_LINE).unwrap().scene
    }

    #[test]
    fn splits_that_would_take_too_long_are_omitted_with_the_time_and_how_to_get_them() {
        let elements =
            |end_time_s: f64| affordable_split(&plate(end_time_s)).map(|split| split.element_count());
        assert_eq!(elements(1e-3), Ok(8 * 594));
        let own_s = compile(&plate(1.0)).unwrap().report.expected_run_time_s;
        // Between the two limits the split mesh is made and its cost queried, beyond the second it is not.
        for (times, words) in [(12.0, "would take about"), (4.0, "would take more than")] {
            let why = elements(MOST_S / (times * own_s)).unwrap_err();
            for words in [words, " s on one core", "`--accuracy 10% --within TIME`"] {
                assert!(why.contains(words), "{why}");
            }
        }
    }

    #[test]
    fn a_coarser_mesh_that_does_not_bear_the_impact_is_replaced_by_a_finer_one() {
        // Half the elements leave the gate of energy, 0.7 times as many and the scene's own do not.
        let bars = |energy_gate: f64| {
            let law = json!({"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7, "volumetric": "quadratic_ln"});
            let document = json!({
                "name": "ball", "end_time_s": 1e-3, "solver": {"error_bars": "two_levels"},
                "integrator": {"kind": "explicit", "energy_gate": energy_gate}, "contact": {"friction": 0.3},
                "bodies": [
                    {"name": "ball", "velocity_m_per_s": [0, 0, -30], "placement": {"translation_m": [0, 0, 0.0222]},
                     "mesh": {"generator": {"kind": "hollow_ball", "outer_radius_m": 0.022, "inner_radius_m": 0.01567,
                                            "elements_around": 6, "elements_through": 2}},
                     "parts": [{"part": "ball", "density_kg_per_m3": 1000, "shear_viscosity_pa_s": 5, "material": law}]},
                    {"name": "block", "fixed": [{"set": "z_min"}],
                     "mesh": {"generator": {"kind": "block", "min_m": [-0.04, -0.04, -0.03], "max_m": [0.04, 0.04, 0],
                                            "elements": [8, 8, 4]}},
                     "parts": [{"part": "block", "density_kg_per_m3": 1000,
                                "material": {"law": "neo_hookean", "c10_pa": 5e5, "bulk_modulus_pa": 5e7}}]}
                ],
                "record": {"fields": [], "field_times_s": []}
            });
            let scene =
                load_parsed(&document.into(), &FolderSource::new("."), &Budget::COMMAND_LINE).unwrap().scene;
            error_bars(&scene, &[], 1, &|| None)
        };
        let size = |bars: ErrorBars| match bars {
            ErrorBars::From(runs) => runs.levels[0].size,
            other => panic!("{other:?}"),
        };
        let (half, between) = (size(bars(5e-4)), size(bars(3e-4)));
        assert!((half - 2.0).abs() < 1e-12 && (1.2..1.6).contains(&between), "{half}, {between}");
        // One that neither bears: the reason of the coarsest.
        let ErrorBars::Unknown(why) = bars(1.5e-4) else { panic!("none bears it") };
        assert!(why.contains("energy_gate"), "{why}");
    }
}
