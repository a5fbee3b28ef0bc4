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
use crate::plan::PlanReport;
use crate::scene::Scene;
use crate::scene::document::{AccuracyDocument, Formulation, RequestedNumber};

/// Factors that are tried, in this order [-].
const FACTORS: [f64; 4] = [1.0 / 256.0, 1.0 / 64.0, 1.0 / 16.0, 0.25];
/// Least bulk modulus in units of the shear modulus [-]: below it the volume of tissue is soft, and validation warns of it.
const LEAST_RATIO: f64 = 10.0;
/// What is compared with water, in words.
const OF_SCENE: &str = "the bulk modulus of the scene in place of that of water";
/// Largest change of each required result, in units of the accuracy [-]: the mesh needs the rest.
const FRACTION: f64 = 1.0 / 3.0;

/// The scene with the bulk modulus of water in every part that is meant to keep its volume, on the same meshes; `None` where none has
/// less. `resources` has whatever a run needs but the scene.
///
/// # Errors
/// Why the scene with that modulus is refused.
pub(super) fn with_that_of_water(scene: &Scene, resources: &Variants) -> Result<Option<Scene>, String> {
    if !has_less_than_water(scene) {
        return Ok(None);
    }
    let factor = |material: &Material| {
        material.capped_bulk_modulus().map_or(1.0, |capped| BULK_MODULUS_OF_WATER / capped)
    };
    scaled(scene, resources, factor).map(Some)
}

/// Laws of all bodies.
fn materials(scene: &Scene) -> impl Iterator<Item = &Material> {
    scene.bodies.iter().flat_map(|body| &body.materials)
}

/// Whether a part that is meant to keep its volume has a lower bulk modulus than water.
fn has_less_than_water(scene: &Scene) -> bool {
    materials(scene).any(|material| material.capped_bulk_modulus().is_some())
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
    let reference = with_water
        .and_then(|scene| scene.map(|scene| run(&scene, resources).map(|(run, _)| run)).transpose());
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
    let changes = changes(own, &reference, &reported(requested));
    let words = format!(
        "{OF_SCENE} changes on the coarsest mesh {}, which is not in the error bars",
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
             `--lower-bulk-modulus` adds its effect to the error bars, and lowers it no further than the accuracy allows.",
            each_in_words(&large)
        )
    });
    BulkModulusEffect { change: Some(BulkModulusChange { in_bars: None, words }), warning }
}

/// Says that the effect of the bulk moduli of a scene in place of that of water is unknown, where a part has less than water.
pub(super) fn untried_cap(scene: &Scene) -> BulkModulusEffect {
    let words = format!(
        "what {OF_SCENE} changes was not tried, since there is no much coarser mesh: `contuse study bulk-modulus` tries it on the scene's own"
    );
    BulkModulusEffect {
        change: has_less_than_water(scene).then_some(BulkModulusChange { in_bars: None, words }),
        ..BulkModulusEffect::default()
    }
}

/// Results whose change is reported: those that a coarse mesh resolves, and those that were requested.
fn reported(requested: &AccuracyDocument) -> Vec<RequestedNumber> {
    let is_resolved = |number: &RequestedNumber| {
        !matches!(number, RequestedNumber::ContactPatch | RequestedNumber::StressDepth)
    };
    let is_reported = |number: &RequestedNumber| is_resolved(number) || requested.of.contains(number);
    RequestedNumber::ALL.into_iter().filter(is_reported).collect()
}

/// Runs a scene on its coarsest mesh with the bulk moduli of water, where it has less, then with lower ones, the lowest first, until one
/// changes the required results little enough; else those of the scene stand. Returns what they change, with the scene that has them.
/// `resources` has whatever the runs need but the scene.
///
/// # Errors
/// Why there is no choice: a run with the moduli of water or of the scene did not finish.
pub(super) fn lower(
    (own, coarsest): (&Scene, &Scene),
    requested: &AccuracyDocument,
    resources: &Variants,
    clock: &mut Clock,
) -> Result<(BulkModulusChange, Scene), String> {
    if !materials(own).any(Material::keeps_its_volume) {
        let words = "bulk moduli not lowered: no part is meant to keep its volume".into();
        return Ok((BulkModulusChange { in_bars: None, words }, own.clone()));
    }
    let mut run =
        |scene: &Scene| run(scene, resources).inspect(|(run, report)| clock.count(report, run.steps));
    let stiff = |scene: &Scene| {
        with_that_of_water(scene, resources).map(|stiff| stiff.unwrap_or_else(|| scene.clone()))
    };
    let stiff_coarsest = stiff(coarsest)?;
    let (reference, _) = run(&stiff_coarsest)?;
    let mut nearest = None;
    for factor in FACTORS {
        // Moduli below what the laws admit are refused, and runs with them may fail: the next ones may not.
        let Ok(scene) = lowered(&stiff_coarsest, resources, factor) else { continue };
        let Ok((with_lower, _)) = run(&scene) else { continue };
        let changes = changes(&with_lower, &reference, &requested.of);
        let is_small = |(_, change): &(RequestedNumber, Option<f64>)| {
            change.is_some_and(|change| change <= FRACTION * requested.relative)
        };
        let words = format!("× {factor:.3} on the coarsest mesh change {}", each_in_words(&changes));
        if changes.iter().all(is_small) {
            let words = format!("bulk moduli {words}, which is in the error bars");
            let change = BulkModulusChange { in_bars: Some([reference, with_lower]), words };
            return Ok((change, lowered(&stiff(own)?, resources, factor)?));
        }
        nearest = Some(words);
    }
    // None is admissible: those of the scene stand, with what they change.
    let why = nearest.map_or_else(|| "no lower ones can be run".into(), |words| format!("those {words}"));
    let (as_given, _) = run(coarsest)?;
    let each = each_in_words(&changes(&as_given, &reference, &requested.of));
    let words =
        format!("bulk moduli not lowered: {why}; {OF_SCENE} changes {each}, which is in the error bars");
    Ok((BulkModulusChange { in_bars: Some([reference, as_given]), words }, own.clone()))
}

/// A run of a scene, which must finish, and the report of its plan.
fn run(scene: &Scene, resources: &Variants) -> Result<(Compared, PlanReport), String> {
    compared(&Variants { document: &scene.document, ..*resources }, scene, &[])
}

/// The scene with its bulk moduli times a factor, but in parts that are not meant to keep their volume. An error where a modulus became too
/// low.
fn lowered(scene: &Scene, resources: &Variants, factor: f64) -> Result<Scene, String> {
    let of = |material: &Material| if material.keeps_its_volume() { factor } else { 1.0 };
    let lowered = scaled(scene, resources, of)?;
    let is_soft = |(before, after): (&Material, &Material)| {
        let (shear, bulk) = after.moduli_at_rest();
        before.keeps_its_volume() && bulk < LEAST_RATIO * shear
    };
    if materials(scene).zip(materials(&lowered)).any(is_soft) {
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
