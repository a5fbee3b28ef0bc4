//! Which results of a run are lower bounds, because the model or the run ends before what they measure.

use crate::measure::QuantityOfInterest;
use crate::measure::summary::{Impact, Results};
use std::collections::BTreeSet;

/// Relative difference of times below which they are the same [-].
const SAME_TIME: f64 = 1e-6;

/// The results that are lower bounds. The model ends: the depth, where the significant stress reaches an end of the tissue. The
/// run ends while contact lasts: the impulse; the depth, if it was largest when it was last evaluated; the peak force, if its
/// window is the last one.
pub(super) fn lower_bounds(results: &Results) -> BTreeSet<QuantityOfInterest> {
    let mut bounds = BTreeSet::new();
    let tissue = results.tissue.as_ref();
    let significant = tissue.zip(results.headline.significant_stress);
    if let Some((tissue, stress)) = significant.and_then(|(t, i)| Some((t, t.significant_stress.get(i)?))) {
        let goes_on = !tissue.contact_ended && is_at(stress.depth_time_s, tissue.looked_at_until_s);
        // No stress above the threshold has no depth that could go on.
        if !stress.layers.is_empty() && (goes_on || !stress.reaches.is_empty()) {
            bounds.insert(QuantityOfInterest::StressDepthMm);
        }
    }
    if let Some((impact, end)) = results.headline_impact().and_then(lasts_until) {
        bounds.insert(QuantityOfInterest::ImpulseNS);
        let after_peak = 0.5 * impact.force_window_s.unwrap_or_default();
        if is_at(impact.peak_force_time_s.value + after_peak, end) {
            bounds.insert(QuantityOfInterest::PeakForceN);
        }
    }
    bounds
}

/// A contact with its last time, if it had not ended.
fn lasts_until(impact: &Impact) -> Option<(&Impact, f64)> {
    let [_, last] = impact.contact_span_s.filter(|_| !impact.contact_ended)?;
    Some((impact, last))
}

/// Whether a time is not before the end.
fn is_at(time: f64, end: f64) -> bool {
    time >= end * (1.0 - SAME_TIME)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use QuantityOfInterest::{ImpulseNS, PeakForceN, StressDepthMm};
    use serde_json::{Value, json};

    /// The bounds among the numbers of the example in the documentation, after changes at JSON pointers.
    fn bounds(changes: &[(&str, Value)]) -> Vec<QuantityOfInterest> {
        let summary = include_str!("../../../api/examples/summary.response.json");
        let mut results = serde_json::from_str::<Value>(summary).unwrap()["results"].take();
        for (pointer, value) in changes {
            let (parent, name) = pointer.rsplit_once('/').unwrap();
            results.pointer_mut(parent).unwrap()[name] = value.clone();
        }
        lower_bounds(&serde_json::from_value(results).unwrap()).into_iter().collect()
    }

    #[test]
    fn what_the_end_of_the_run_or_of_the_tissue_cuts_off_is_a_lower_bound() {
        let impact = |name: &str| format!("/impacts/0/{name}");
        let stress = |name: &str| format!("/tissue/significant_stress/0/{name}");
        let ended = [
            (impact("contact_ended"), json!(true)),
            (impact("contact_span_s"), json!([0.0, 0.004])),
            (impact("peak_force_time_s/value"), json!(0.002)),
            (impact("force_window_s"), json!(0.001)),
            ("/tissue/contact_ended".into(), json!(true)),
            ("/tissue/looked_at_until_s".into(), json!(0.005)),
            (stress("depth_time_s"), json!(0.005)),
            (stress("reaches"), json!([])),
            (stress("layers"), json!([{"part": "block", "depth_mm": [0.0, 2.0], "volume_mm3": 9.0}])),
        ];
        let with = |changed: &[(String, Value)]| {
            let all = ended.iter().chain(changed).map(|(pointer, value)| (&pointer[..], value.clone()));
            bounds(&all.collect::<Vec<_>>())
        };
        assert_eq!(with(&[]), []);
        assert_eq!(with(&[(stress("reaches"), json!(["the held nodes “bone”"]))]), [StressDepthMm]);
        let lasts = [(impact("contact_ended"), json!(false)), ("/tissue/contact_ended".into(), json!(false))];
        assert_eq!(with(&lasts), [ImpulseNS, StressDepthMm]);
        // Deepest before the end, and hardest at the end.
        let [a, b] = lasts;
        let late = (impact("peak_force_time_s/value"), json!(0.0035));
        assert_eq!(with(&[a, b, late, (stress("depth_time_s"), json!(0.004))]), [PeakForceN, ImpulseNS]);
    }
}
