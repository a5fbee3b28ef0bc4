//! What a list says of a run beside its name: the projectile, its speed and the main numbers.

use crate::measure::QuantityOfInterest;
use crate::measure::summary::Results;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// Projectile of a job and main numbers of its run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Headline {
    /// Name of the projectile; null without one.
    pub projectile: Option<String>,
    /// Speed of the projectile at the start [m/s].
    pub speed_m_per_s: Option<f64>,
    /// Stress that the depth is above [Pa].
    pub threshold_pa: Option<f64>,
    /// `peak_force_n`, `largest_patch_area_mm2`, `stress_depth_mm`, `energy_given_j`: those that the summary has; none if they
    /// are withheld, or nothing touched.
    #[schema(value_type = BTreeMap<String, HeadlineNumber>)]
    pub numbers: BTreeMap<QuantityOfInterest, HeadlineNumber>,
}

/// A main number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HeadlineNumber {
    /// Value in the unit of its name.
    pub value: f64,
    /// Numerical error in the same unit; null if it is not known.
    pub error: Option<f64>,
    /// Whether the error is known, and the mesh resolves the number.
    pub resolved: bool,
    /// Whether the number is at least the value.
    pub lower_bound: bool,
}

/// What of a document says what flies. A question has its scene inside, of which it changes speeds and bodies.
#[derive(Deserialize)]
struct Flying {
    #[serde(default)]
    bodies: Vec<FlyingBody>,
}

/// A body of a document.
#[derive(Deserialize)]
struct FlyingBody {
    #[serde(default)]
    name: String,
    #[serde(default)]
    role: String,
    velocity_m_per_s: Option<[f64; 3]>,
}

/// What of a summary has the numbers.
#[derive(Deserialize)]
struct Summarised<'a> {
    #[serde(borrow)]
    results: Option<&'a RawValue>,
}

impl Headline {
    /// Of a document and the summary of its run; `None` if neither says anything.
    pub fn of(document: &[u8], summary: &str) -> Option<Self> {
        let projectile = serde_json::from_slice(document).ok().and_then(projectile_of);
        let raw = serde_json::from_str::<Summarised>(summary).ok().and_then(|summary| summary.results);
        let results = raw.and_then(|raw| serde_json::from_str::<Results>(raw.get()).ok());
        let results = results.filter(|results| !results.nothing_touched);
        if projectile.is_none() && results.is_none() {
            return None;
        }
        let speed_m_per_s = projectile.as_ref().and_then(|body| body.velocity_m_per_s).map(length);
        let threshold = |results: &Results| {
            let tissue = results.tissue.as_ref()?;
            Some(tissue.significant_stress.get(results.headline.significant_stress?)?.threshold_pa)
        };
        Some(Self {
            projectile: projectile.map(|body| body.name),
            speed_m_per_s,
            threshold_pa: results.as_ref().and_then(threshold),
            numbers: results.as_ref().map(numbers_of).unwrap_or_default(),
        })
    }
}

/// The first projectile of a document.
fn projectile_of(document: Flying) -> Option<FlyingBody> {
    document.bodies.into_iter().find(|body| body.role == "projectile")
}

/// The main numbers of results.
fn numbers_of(results: &Results) -> BTreeMap<QuantityOfInterest, HeadlineNumber> {
    let number = |quantity: QuantityOfInterest| {
        let number = quantity.number(results)?;
        let (value, error) = (number.value, number.error.half_width());
        let resolved = number.error.is_resolved();
        Some((quantity, HeadlineNumber { value, error, resolved, lower_bound: number.is_lower_bound }))
    };
    QuantityOfInterest::HEADLINE.into_iter().filter_map(number).collect()
}

/// Length of a vector.
fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|component| component * component).sum::<f64>().sqrt()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    const SUMMARY: &str = include_str!("../../../../api/examples/summary.response.json");
    const SCENE: &str = include_str!("../../../../api/examples/job.request.json");

    #[test]
    fn a_run_has_its_projectile_and_four_numbers() {
        let found = Headline::of(SCENE.as_bytes(), SUMMARY).unwrap();
        let summary: serde_json::Value = serde_json::from_str(SUMMARY).unwrap();
        let force = &summary["results"]["impacts"][0]["peak_force_n"];
        let stress = &summary["results"]["tissue"]["significant_stress"][0];
        assert_eq!(found.numbers.len(), 4);
        let number = found.numbers[&QuantityOfInterest::PeakForceN];
        assert_eq!(Some(number.value), force["value"].as_f64());
        assert_eq!((number.error, number.resolved), (force["error"]["total"].as_f64(), false));
        assert!(found.numbers[&QuantityOfInterest::StressDepthMm].lower_bound);
        assert_eq!(found.threshold_pa, stress["threshold_pa"].as_f64());
        let scene: serde_json::Value = serde_json::from_str(SCENE).unwrap();
        let ball =
            scene["bodies"].as_array().unwrap().iter().find(|body| body["role"] == "projectile").unwrap();
        assert_eq!(found.projectile.as_deref(), ball["name"].as_str());
        assert!(found.speed_m_per_s.is_some_and(|speed| speed > 0.0));
    }

    #[test]
    fn a_withheld_run_has_no_numbers_and_a_question_nothing() {
        let scene: serde_json::Value = serde_json::from_str(SCENE).unwrap();
        let found = Headline::of(SCENE.as_bytes(), r#"{"withheld": {"reason": "a gate failed"}}"#).unwrap();
        assert!(found.projectile.is_some() && found.numbers.is_empty());
        let question = serde_json::json!({"scene": scene, "parameters": []}).to_string();
        assert_eq!(Headline::of(question.as_bytes(), r#"{"cases": []}"#), None);
        assert_eq!(Headline::of(br#"{"job": "01"}"#, r#"{"cases": []}"#), None);
    }
}
