//! What the model of a run omits, in sentences for a reader of its report.

use super::RecordedRun;
use super::parameters::title_of_law;
use crate::measure::summary::number;
use crate::mechanics::material::BULK_MODULUS_OF_WATER;
use crate::scene::part_document::PartDocument;
use serde::Deserialize;
use serde_json::Value;

/// Sentences on what the scene of a run does not model.
pub(super) fn omissions(run: &RecordedRun) -> Vec<String> {
    let bodies = run.scene["bodies"].as_array().map_or(&[][..], Vec::as_slice);
    let Some(tissue) = bodies.iter().find(|body| body["role"] == "tissue") else { return Vec::new() };
    let parts = tissue["parts"].as_array().map_or(&[][..], Vec::as_slice);
    let names: Vec<&str> = parts.iter().filter_map(|part| part["part"].as_str()).collect();
    let described: Vec<String> = parts.iter().filter_map(described).collect();
    let mut all = vec![format!(
        "Tissue is layers of one material each ({}): no vessels, nerves or fasciae, no blood, no tension of active muscle.",
        described.join(", ")
    )];
    if !names.contains(&"bone") {
        all.push("Bone is rigid and held in place, or absent: it neither moves nor breaks.".into());
    }
    // Of a part of another version nothing is claimed.
    let any = |has: fn(&PartDocument) -> bool| {
        parts.iter().any(|part| PartDocument::deserialize(part).map_or(true, |part| has(&part)))
    };
    if !any(PartDocument::can_tear) {
        all.push(
            "Nothing tears: beyond its strength real tissue yields, and this model goes on bearing load."
                .into(),
        );
    }
    if !any(PartDocument::depends_on_rate) {
        all.push("The tissue is elastic: it does not stiffen with the rate of the impact; what is dissipated in it is of the numerical bulk viscosity.".into());
    }
    let bulk = parts.iter().filter_map(|part| part["material"]["bulk_modulus_pa"].as_f64());
    let largest = bulk.fold(0.0, f64::max);
    if largest > 0.0 && largest < 0.5 * BULK_MODULUS_OF_WATER {
        all.push(format!(
            "Its resistance to compression ({} MPa) is below that of tissue ({} MPa): pressures and waves of pressure are those of the model.",
            number(1e-6 * largest),
            number(1e-6 * BULK_MODULUS_OF_WATER)
        ));
    }
    if tissue["mesh"]["generator"]["kind"] == "limb_segment" {
        all.push("The limb is a straight segment with free ends: waves come back from there that would run on in a person.".into());
    }
    all.push(
        "The material parameters are those of the scene, not of a person. The uncertainties are those of the computation; people differ by more."
            .into(),
    );
    all
}

/// Name of a part; of "*", which stands for all others, the material: its set of the library, or its law.
fn described(part: &Value) -> Option<String> {
    let name = part["part"].as_str()?;
    if name != "*" {
        return Some(name.to_owned());
    }
    let material = &part["material"];
    let law = material["law"].as_str().map(title_of_law);
    material["library"].as_str().map(str::to_owned).or(law)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn run(part: &Value) -> RecordedRun {
        let scene = json!({"bodies": [{"role": "tissue", "parts": [part]}]});
        RecordedRun { scene, ..RecordedRun::default() }
    }

    #[test]
    fn parts_that_the_scene_does_not_name_are_those_of_their_material() {
        let said = |material: Value| omissions(&run(&json!({"part": "*", "material": material}))).remove(0);
        assert!(said(json!({"law": "neo_hookean", "c10_pa": 3e4})).contains("each (neo-Hookean):"));
        assert!(said(json!({"library": "gel/ballistic_10"})).contains("each (gel/ballistic_10):"));
        assert!(!said(json!({})).contains('*'));
    }

    #[test]
    fn what_a_scene_models_is_not_listed() {
        let part = |name: &str, bulk: f64| {
            let law = json!({"law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": bulk});
            json!({"part": name, "density_kg_per_m3": 1000, "material": law})
        };
        let plain = omissions(&run(&part("fat", 5e7))).join(" ");
        assert!(
            plain.contains("Nothing tears") && plain.contains("is elastic") && plain.contains("50.00 MPa"),
            "{plain}"
        );
        let mut viscous = part("bone", 2.2e9);
        viscous["prony_series"] = json!({"branches": [{"relative_modulus": 1, "relaxation_time_s": 1e-3}]});
        viscous["softening"] = json!({"onset_j_per_m3": 1e6, "fracture_energy_j_per_m2": 1e4});
        let fewer = omissions(&run(&viscous)).join(" ");
        for absent in ["Nothing tears", "is elastic", "resistance", "Bone is rigid"] {
            assert!(!fewer.contains(absent), "{fewer}");
        }
        assert!(omissions(&RecordedRun::default()).is_empty());
    }
}
