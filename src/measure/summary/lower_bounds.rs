//! Which results of a run are lower bounds, because the model or the run ends before what they measure.

use super::of_interest::QuantityOfInterest;
use super::results::{Impact, Results, SignificantStress, Tissue};
use std::collections::BTreeSet;

/// Relative difference of times below which they are the same [-].
const SAME_TIME: f64 = 1e-6;

/// The results of the headline that are lower bounds.
pub fn lower_bounds(results: &Results) -> BTreeSet<QuantityOfInterest> {
    let mut bounds: BTreeSet<_> =
        results.headline_impact().into_iter().flat_map(Impact::lower_bounds).collect();
    let tissue = results.tissue.as_ref().zip(results.headline.significant_stress);
    let stress = tissue.and_then(|(tissue, index)| Some((tissue, tissue.significant_stress.get(index)?)));
    if stress.is_some_and(|(tissue, stress)| stress.is_deeper(tissue)) {
        bounds.insert(QuantityOfInterest::StressDepthMm);
    }
    bounds
}

impl Results {
    /// Has each impact and each threshold say which of its numbers are lower bounds.
    pub(super) fn mark_lower_bounds(&mut self) {
        for impact in &mut self.impacts {
            impact.peak_force_is_lower_bound =
                impact.lower_bounds().contains(&QuantityOfInterest::PeakForceN);
        }
        let Some(tissue) = &mut self.tissue else { return };
        let bounds: Vec<bool> = tissue.significant_stress.iter().map(|of| of.is_deeper(tissue)).collect();
        for (stress, bound) in tissue.significant_stress.iter_mut().zip(bounds) {
            stress.depth_is_lower_bound = bound;
        }
    }
}

impl Impact {
    /// While contact lasts: the impulse, and the peak force if its window is the last one.
    pub(super) fn lower_bounds(&self) -> Vec<QuantityOfInterest> {
        let Some([_, end]) = self.contact_span_s.filter(|_| !self.contact_ended) else { return Vec::new() };
        let after_peak = 0.5 * self.force_window_s.unwrap_or_default();
        let is_rising = is_at(self.peak_force_time_s.value + after_peak, end);
        let force = is_rising.then_some(QuantityOfInterest::PeakForceN);
        [QuantityOfInterest::ImpulseNS].into_iter().chain(force).collect()
    }
}

impl SignificantStress {
    /// Whether its depth is a lower bound: it ends at an end of the tissue, or was largest when it was last evaluated in contact.
    pub(super) fn is_deeper(&self, tissue: &Tissue) -> bool {
        let goes_on = !tissue.contact_ended && is_at(self.depth_time_s, tissue.looked_at_until_s);
        // No stress above the threshold has no depth that could go on.
        !self.layers.is_empty() && (goes_on || !self.depth_reaches.is_empty())
    }
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
        let mut results: Results = serde_json::from_value(results).unwrap();
        results.mark_lower_bounds();
        let found: Vec<_> = lower_bounds(&results).into_iter().collect();
        // The same on the wire.
        let of_depth = results.tissue.as_ref().unwrap().significant_stress[0].depth_is_lower_bound;
        assert_eq!(of_depth, found.contains(&StressDepthMm));
        assert_eq!(results.impacts[0].peak_force_is_lower_bound, found.contains(&PeakForceN));
        found
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
            (stress("depth_reaches"), json!([])),
            (stress("layers"), json!([{"part": "block", "depth_mm": [0.0, 2.0], "volume_mm3": 9.0}])),
        ];
        let with = |changed: &[(String, Value)]| {
            let all = ended.iter().chain(changed).map(|(pointer, value)| (&pointer[..], value.clone()));
            bounds(&all.collect::<Vec<_>>())
        };
        assert_eq!(with(&[]), []);
        assert_eq!(with(&[(stress("depth_reaches"), json!(["the held nodes “bone”"]))]), [StressDepthMm]);
        let lasts = [(impact("contact_ended"), json!(false)), ("/tissue/contact_ended".into(), json!(false))];
        assert_eq!(with(&lasts), [ImpulseNS, StressDepthMm]);
        // Deepest before the end, and hardest at the end.
        let [a, b] = lasts;
        let late = (impact("peak_force_time_s/value"), json!(0.0035));
        assert_eq!(with(&[a, b, late, (stress("depth_time_s"), json!(0.004))]), [PeakForceN, ImpulseNS]);
    }
}
