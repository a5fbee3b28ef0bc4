//! Bulk moduli below that of water: what they change, and the lowest that a requested accuracy allows.
//!
//! Tissue is as incompressible as water, 2.2 GPa; the time step grows as the square root of the bulk modulus falls. How far lower moduli
//! change a result depends on the scene, so that it is found by runs on the coarsest mesh.

use super::clock::Clock;
use super::error_bars::compared;
use super::setting::Setting;
use super::variant::Variants;
use crate::measure::{BulkModulusChange, Compared, QuantityOfInterest};
use crate::mechanics::material::{BULK_MODULUS_OF_WATER, Material};
use crate::scene::Scene;
use crate::scene::document::{AccuracyDocument, Formulation, RequestedNumber};

/// Factors that are tried, in this order [-].
const FACTORS: [f64; 4] = [1.0 / 256.0, 1.0 / 64.0, 1.0 / 16.0, 0.25];
/// Least bulk modulus in units of the shear modulus [-]: below it the volume of tissue is soft, and validation warns of it.
const LEAST_RATIO: f64 = 10.0;
/// Largest change of each required result, in units of the accuracy [-]: the mesh needs the rest.
const FRACTION: f64 = 1.0 / 3.0;

/// The scene with the bulk modulus of water in every part that is meant to keep its volume, on the same meshes; `None` where none has
/// less. `resources` has whatever a run needs but the scene.
///
/// # Errors
/// Why the scene with that modulus is refused.
pub(super) fn with_that_of_water(scene: &Scene, resources: &Variants) -> Result<Option<Scene>, String> {
    let materials = || scene.bodies.iter().flat_map(|body| &body.materials);
    if materials().all(|material| material.capped_bulk_modulus().is_none()) {
        return Ok(None);
    }
    let factor = |material: &Material| {
        material.capped_bulk_modulus().map_or(1.0, |capped| BULK_MODULUS_OF_WATER / capped)
    };
    scaled(scene, resources, factor).map(Some)
}

/// What the bulk moduli of a run change.
#[derive(Default)]
pub(super) struct BulkModulusEffect {
    /// The runs that show it; `None` if it is not known, or nothing.
    pub change: Option<BulkModulusChange>,
    /// Warning that it is not small, or unknown.
    pub warning: Option<String>,
}

/// What the bulk moduli of a scene in place of that of water change, on a mesh whose `own` run is known; nothing where no part has less than
/// water. It is not in the error bars, and where a required result changes by more than the accuracy, a warning says so.
pub(super) fn effect_of_cap(
    (mesh, own): (&Scene, &Compared),
    requested: &AccuracyDocument,
    resources: &Variants,
) -> BulkModulusEffect {
    let with_water = with_that_of_water(mesh, resources);
    let reference = with_water.and_then(|scene| {
        let run = |scene: Scene| {
            compared(&Variants { document: &scene.document, ..*resources }, &scene, &[]).map(|(run, _)| run)
        };
        scene.map(run).transpose()
    });
    let reference = match reference {
        Ok(Some(reference)) => reference,
        Ok(None) => return BulkModulusEffect::default(),
        Err(why) => {
            let warning = format!(
                "What the bulk modulus of the scene in place of that of water changes is unknown: {why}"
            );
            return BulkModulusEffect { warning: Some(warning), ..BulkModulusEffect::default() };
        }
    };
    let changes = changes(own, &reference, &RequestedNumber::ALL);
    let words = format!(
        "the bulk modulus of the scene in place of that of water changes on the coarsest mesh {}, which is not in the error bars",
        each_in_words(&changes)
    );
    // Only the required results have an accuracy to compare with.
    let is_large = |(number, change): &(RequestedNumber, Option<f64>)| {
        requested.of.contains(number) && change.is_some_and(|change| change > requested.relative)
    };
    let large: Vec<_> = changes.into_iter().filter(is_large).collect();
    let warning = (!large.is_empty()).then(|| {
        format!(
            "The bulk modulus of the scene in place of that of water changes on the coarsest mesh {}, more than the accuracy allows: \
             `--lower-bulk-modulus` chooses one that does not, and adds its effect to the error bars.",
            each_in_words(&large)
        )
    });
    let change = BulkModulusChange { reference, own: own.clone(), is_in_bars: false, words };
    BulkModulusEffect { change: Some(change), warning }
}

/// Runs a scene on its coarsest mesh with the bulk moduli of water, where it has less, and with lower ones, the lowest first. Returns what
/// this changes with the scene with the lowest admissible ones: the first of all where no change is small enough. `resources` has whatever
/// the runs need but the scene.
///
/// # Errors
/// Why there is no choice: the run with the first ones did not finish.
pub(super) fn lower(
    (own, coarsest): (&Scene, &Scene),
    requested: &AccuracyDocument,
    resources: &Variants,
    clock: &mut Clock,
) -> Result<(BulkModulusChange, Scene), String> {
    let stiff = |scene: &Scene| {
        with_that_of_water(scene, resources).map(|stiff| stiff.unwrap_or_else(|| scene.clone()))
    };
    let (own, coarsest) = (stiff(own)?, stiff(coarsest)?);
    let (factor, change) = choose(&coarsest, requested, resources, clock)?;
    let scene = if factor < 1.0 { lowered(&own, resources, factor)? } else { own };
    Ok((change, scene))
}

/// The first factor whose change is small enough, with the runs that show it; without one the factor is 1.
fn choose(
    coarsest: &Scene,
    requested: &AccuracyDocument,
    resources: &Variants,
    clock: &mut Clock,
) -> Result<(f64, BulkModulusChange), String> {
    let variants = Variants { document: &coarsest.document, ..*resources };
    let mut run = |scene: &Scene| {
        compared(&variants, scene, &[]).inspect(|(run, report)| clock.count(report, run.steps))
    };
    let (reference, _) = run(coarsest)?;
    let mut nearest = None;
    for factor in FACTORS {
        // Moduli below what the laws admit are refused, and runs with them may fail: the next ones may not.
        let Ok(scene) = lowered(coarsest, resources, factor) else { continue };
        let Ok((own, _)) = run(&scene) else { continue };
        let changes = changes(&own, &reference, &requested.of);
        let is_small = |(_, change): &(RequestedNumber, Option<f64>)| {
            change.is_some_and(|change| change <= FRACTION * requested.relative)
        };
        let words = format!("× {factor:.3} on the coarsest mesh change {}", each_in_words(&changes));
        if changes.iter().all(is_small) {
            let words = format!("bulk moduli {words}, which is in the error bars");
            return Ok((factor, BulkModulusChange { reference, own, is_in_bars: true, words }));
        }
        nearest = Some(words);
    }
    let why = nearest.map_or_else(|| "no lower ones can be run".into(), |words| format!("those {words}"));
    let words = format!("bulk moduli not lowered: {why}");
    let own = reference.clone();
    Ok((1.0, BulkModulusChange { reference, own, is_in_bars: true, words }))
}

/// The scene with its bulk moduli times a factor. An error where a modulus became too low.
fn lowered(scene: &Scene, resources: &Variants, factor: f64) -> Result<Scene, String> {
    let lowered = scaled(scene, resources, |_| factor)?;
    let is_soft = |material: &Material| {
        let (shear, bulk) = material.moduli_at_rest();
        bulk < LEAST_RATIO * shear
    };
    if lowered.bodies.iter().flat_map(|body| &body.materials).any(is_soft) {
        return Err(format!("a bulk modulus is below {LEAST_RATIO} shear moduli"));
    }
    Ok(lowered)
}

/// The scene with the bulk modulus of each part times a factor, on the same meshes; nothing else changes, but what is in single precision
/// is in double precision where that of the new moduli would not do.
fn scaled(scene: &Scene, resources: &Variants, factor: impl Fn(&Material) -> f64) -> Result<Scene, String> {
    let mut document = scene.document.clone();
    for (body, of) in document.bodies.iter_mut().zip(&scene.bodies) {
        for (part, material) in body.parts.iter_mut().zip(&of.materials) {
            let factor = factor(material);
            part.material.scale_bulk_modulus(factor);
            if factor > 1.0 && part.formulation == Some(Formulation::MeanDilatationSingle) {
                part.formulation = None;
            }
        }
    }
    let variants = Variants { document: &document, ..*resources };
    let mut scaled = variants.scene(&Setting::OWN, None, Some(scene)).map_err(|error| error.to_string())?;
    scaled.document.solver.error_bars = scene.document.solver.error_bars;
    scaled.document.accuracy.clone_from(&scene.document.accuracy);
    Ok(scaled)
}

/// Changes of some results [-], `None` where one of them is unknown; results that the scene lacks are omitted.
fn changes(
    own: &Compared,
    reference: &Compared,
    of: &[RequestedNumber],
) -> Vec<(RequestedNumber, Option<f64>)> {
    let has = |number: &&RequestedNumber| reference.has(**number);
    of.iter().filter(has).map(|number| (*number, own.change(reference, *number))).collect()
}

/// "peak force by 0.3 %, impulse by 0.1 %".
fn each_in_words(changes: &[(RequestedNumber, Option<f64>)]) -> String {
    let each = changes.iter().map(|(number, change)| {
        let change = change.map_or_else(|| "an unknown amount".into(), |c| format!("{:.1} %", 100.0 * c));
        format!("{} by {change}", QuantityOfInterest::from(*number).title())
    });
    each.collect::<Vec<_>>().join(", ")
}
