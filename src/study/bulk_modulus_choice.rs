//! The lowest bulk moduli that a requested accuracy allows: the time step grows as their square root falls.
//!
//! Tissue is as incompressible as water, 2.2 GPa. How far lower moduli change a result depends on the scene, so that they are chosen
//! by runs on the coarsest mesh: first with those of the scene, then with lower ones, the lowest first, until the change is small.

use super::clock::Clock;
use super::error_bars::compared;
use super::setting::Setting;
use super::variant::Variants;
use crate::measure::{Compared, LoweredBulkModulus, QuantityOfInterest};
use crate::mechanics::material::Material;
use crate::scene::Scene;
use crate::scene::document::{AccuracyDocument, RequestedNumber};

/// Factors that are tried, in this order [-].
const FACTORS: [f64; 4] = [1.0 / 256.0, 1.0 / 64.0, 1.0 / 16.0, 0.25];
/// Least bulk modulus in units of the shear modulus [-]: below it the volume of tissue is soft, and validation warns of it.
const LEAST_RATIO: f64 = 10.0;
/// Largest change of each required result, in units of the accuracy [-]: the mesh needs the rest.
const FRACTION: f64 = 1.0 / 3.0;

/// Runs a scene on its coarsest mesh with its own and with lower bulk moduli, and returns what it found with the scene with the lowest
/// admissible ones: its own where no change is small enough. `resources` has whatever the runs need but the scene.
///
/// # Errors
/// Why there is no choice: the run with the scene's own moduli did not finish.
pub(super) fn lower(
    (own, coarsest): (&Scene, &Scene),
    requested: &AccuracyDocument,
    resources: &Variants,
    clock: &mut Clock,
) -> Result<(LoweredBulkModulus, Scene), String> {
    let lowered = choose(coarsest, requested, resources, clock)?;
    let scene = match lowered.factor {
        1.0 => own.clone(),
        factor => scaled(&Variants { document: &own.document, ..*resources }, own, factor)?,
    };
    Ok((lowered, scene))
}

/// The first factor whose change is small enough, with the runs that show it; without one the factor is 1.
fn choose(
    coarsest: &Scene,
    requested: &AccuracyDocument,
    resources: &Variants,
    clock: &mut Clock,
) -> Result<LoweredBulkModulus, String> {
    let variants = Variants { document: &coarsest.document, ..*resources };
    let mut run = |scene: &Scene| {
        compared(&variants, scene, &[]).inspect(|(run, report)| clock.count(report, run.steps))
    };
    let (as_given, _) = run(coarsest)?;
    let mut nearest = None;
    for factor in FACTORS {
        // Moduli below what the laws admit are refused, and runs with them may fail: the next ones may not.
        let Ok(scene) = scaled(&variants, coarsest, factor) else { continue };
        let Ok((lowered, _)) = run(&scene) else { continue };
        let changes = changes(&lowered, &as_given, &requested.of);
        let is_small = |(_, change): &(RequestedNumber, Option<f64>)| {
            change.is_some_and(|change| change <= FRACTION * requested.relative)
        };
        let words = words(factor, &changes);
        if changes.iter().all(is_small) {
            let words = format!("bulk moduli {words}, which is in the error bars");
            return Ok(LoweredBulkModulus { factor, as_given, lowered, words });
        }
        nearest = Some(words);
    }
    let why = nearest.map_or_else(|| "no lower ones can be run".into(), |words| format!("those {words}"));
    let words = format!("bulk moduli not lowered: {why}");
    Ok(LoweredBulkModulus { factor: 1.0, lowered: as_given.clone(), as_given, words })
}

/// The scene with its bulk moduli times a factor, on the same meshes; nothing else changes. An error where a modulus became too low.
fn scaled(variants: &Variants, scene: &Scene, factor: f64) -> Result<Scene, String> {
    let setting = Setting { bulk_factor: factor, ..Setting::OWN };
    let mut scaled = variants.scene(&setting, None, Some(scene)).map_err(|error| error.to_string())?;
    let is_soft = |material: &Material| {
        let (shear, bulk) = material.moduli_at_rest();
        bulk < LEAST_RATIO * shear
    };
    if scaled.bodies.iter().flat_map(|body| &body.materials).any(is_soft) {
        return Err(format!("a bulk modulus is below {LEAST_RATIO} shear moduli"));
    }
    scaled.document.solver.error_bars = scene.document.solver.error_bars;
    scaled.document.accuracy.clone_from(&scene.document.accuracy);
    Ok(scaled)
}

/// Changes of the required results [-], `None` where one of them is unknown; results that the scene lacks are omitted.
fn changes(
    lowered: &Compared,
    as_given: &Compared,
    of: &[RequestedNumber],
) -> Vec<(RequestedNumber, Option<f64>)> {
    let has = |number: &&RequestedNumber| as_given.has(**number);
    of.iter().filter(has).map(|number| (*number, lowered.change(as_given, *number))).collect()
}

/// "× 0.0625 on the coarsest mesh change peak force by 0.3 %, impulse by 0.1 %".
fn words(factor: f64, changes: &[(RequestedNumber, Option<f64>)]) -> String {
    let each = changes.iter().map(|(number, change)| {
        let change = change.map_or_else(|| "an unknown amount".into(), |c| format!("{:.1} %", 100.0 * c));
        format!("{} by {change}", QuantityOfInterest::from(*number).title())
    });
    format!("× {factor:.3} on the coarsest mesh change {}", each.collect::<Vec<_>>().join(", "))
}
