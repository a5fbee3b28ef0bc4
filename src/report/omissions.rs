//! What the model of a run omits, in sentences for a reader of its report.

use super::RecordedRun;
use crate::measure::summary::number;

/// Bulk modulus of water, and about that of soft tissue [Pa].
const BULK_MODULUS_OF_WATER_PA: f64 = 2.2e9;

/// Sentences on what the scene of a run does not model.
pub(super) fn omissions(run: &RecordedRun) -> Vec<String> {
    let bodies = run.scene["bodies"].as_array().map_or(&[][..], Vec::as_slice);
    let Some(tissue) = bodies.iter().find(|body| body["role"] == "tissue") else { return Vec::new() };
    let parts = tissue["parts"].as_array().map_or(&[][..], Vec::as_slice);
    let names: Vec<&str> = parts.iter().filter_map(|part| part["part"].as_str()).collect();
    let mut all = vec![format!(
        "Tissue is layers of one material each ({}): no vessels, nerves or fasciae, no blood, no tension of active muscle.",
        names.join(", ")
    )];
    if !names.contains(&"bone") {
        all.push("Bone is rigid and held in place, or absent: it neither moves nor breaks.".into());
    }
    let has = |name: &str| parts.iter().any(|part| !part[name].is_null());
    if !has("softening") && !has("erosion") {
        all.push(
            "Nothing tears: beyond its strength real tissue yields, and this model goes on bearing load."
                .into(),
        );
    }
    if !has("shear_viscosity_pa_s") && !has("prony_series") {
        all.push("The tissue is elastic: it does not stiffen with the rate of the impact, and dissipates nothing itself.".into());
    }
    let bulk = parts.iter().filter_map(|part| part["material"]["bulk_modulus_pa"].as_f64());
    let largest = bulk.fold(0.0, f64::max);
    if largest > 0.0 && largest < 0.5 * BULK_MODULUS_OF_WATER_PA {
        all.push(format!(
            "Its resistance to compression ({} MPa) is below that of tissue ({} MPa): pressures and waves of pressure are those of the model.",
            number(1e-6 * largest),
            number(1e-6 * BULK_MODULUS_OF_WATER_PA)
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn run(part: &Value) -> RecordedRun {
        let scene = json!({"bodies": [{"role": "tissue", "parts": [part]}]});
        RecordedRun { scene, ..RecordedRun::default() }
    }

    #[test]
    fn what_a_scene_models_is_not_listed() {
        let plain = omissions(&run(&json!({"part": "fat", "material": {"bulk_modulus_pa": 5e7}}))).join(" ");
        assert!(
            plain.contains("Nothing tears") && plain.contains("is elastic") && plain.contains("50.00 MPa"),
            "{plain}"
        );
        let viscous = json!({"part": "bone", "material": {"bulk_modulus_pa": 2.2e9}, "shear_viscosity_pa_s": 5, "softening": {}});
        let fewer = omissions(&run(&viscous)).join(" ");
        for absent in ["Nothing tears", "is elastic", "resistance", "Bone is rigid"] {
            assert!(!fewer.contains(absent), "{fewer}");
        }
        assert!(omissions(&RecordedRun::default()).is_empty());
    }
}
