//! Which results of a run are lower bounds, because the model or the run ends before what they measure.
//!
//! One rule for all numbers that are a largest value over time: such a number is a lower bound if contact lasts, and the value was as large
//! as ever when it was last known. For a force averaged over a window that is the last window. A node of a patch counts as in contact until
//! it was last pressed the length of a window ago, so a patch is known to shrink only a window after its largest area. Impulse and duration
//! grow as long as contact lasts. A number that is as large as is possible in the tissue does not grow. A depth or a volume is a lower bound,
//! too, if the region reaches an artificial end of the model: held nodes (of a bone, too, which is no tissue of the model), a cut, a back or a
//! side that is no surface; the depth, if it is read there, to within an edge of an element. A free surface is a real
//! end of the tissue, and so is the greatest depth between free surfaces: there neither is one. The energy given to the tissue is a lower
//! bound if it was largest at the end: of the largest energy during the impact, since some may return to the projectile.

use super::of_interest::QuantityOfInterest;
use super::quantity::Quantity;
use super::results::{Impact, Results, SignificantStress, Tissue};
use std::collections::BTreeSet;

/// Relative difference of times and values below which they are the same [-].
const SAME: f64 = 1e-6;

/// Where no tissue is deeper though the model does not end there: halfway between free surfaces, or where it is held along some axes.
pub(super) const GREATEST_DEPTH: &str = "the greatest depth of the tissue";

/// The quantities of interest that are lower bounds.
pub fn lower_bounds(results: &Results) -> BTreeSet<QuantityOfInterest> {
    let is_bound = |of: &QuantityOfInterest| of.number(results).is_some_and(|number| number.is_lower_bound);
    QuantityOfInterest::ALL.into_iter().filter(is_bound).collect()
}

impl Results {
    /// Marks the numbers that are lower bounds; the latest step was at `end_s` [s].
    pub(super) fn mark_lower_bounds(&mut self, end_s: f64) {
        self.impacts.iter_mut().for_each(Impact::mark_lower_bounds);
        self.tissue.iter_mut().for_each(|tissue| tissue.mark_lower_bounds(end_s));
    }
}

impl Impact {
    fn mark_lower_bounds(&mut self) {
        let span = self.contact_span_s.filter(|_| !self.contact_ended);
        let window = self.force_window_s.unwrap_or_default();
        let is_latest = |time: f64| span.is_some_and(|[_, end]| is_at(time, end));
        let is_rising = is_latest(self.peak_force_time_s.value + 0.5 * window);
        let spreads = self.largest_patch_time_s.is_some_and(|time| is_latest(time + window));
        for (quantity, is_bound) in [
            (&mut self.peak_force_n, is_rising),
            (&mut self.impulse_n_s, span.is_some()),
            (&mut self.contact_duration_s, span.is_some()),
            (&mut self.largest_patch_area_mm2, spreads),
            // The patch at a peak force that is still to come.
            (&mut self.patch_area_mm2, is_rising && spreads),
            (&mut self.patch_long_axis_mm, is_rising && spreads),
            (&mut self.patch_short_axis_mm, is_rising && spreads),
        ] {
            quantity.is_lower_bound = is_bound;
        }
    }
}

impl Tissue {
    fn mark_lower_bounds(&mut self, end_s: f64) {
        let (lasts, looked_at) = (!self.contact_ended, self.looked_at_until_s);
        let mark = |quantity: &mut Quantity, time: f64, end: f64| {
            quantity.is_lower_bound = lasts && quantity.value > 0.0 && is_at(time, end) && !is_most(quantity);
        };
        // Known at every step.
        let time = self.peak_absorbed_energy_time_s.value;
        for energy in
            [&mut self.energy_given_j, &mut self.absorbed_energy_j, &mut self.peak_absorbed_energy_j]
        {
            mark(energy, time, end_s);
        }
        mark(&mut self.deflection_mm.quantity, self.deflection_mm.time_s, end_s);
        // Known at the field times.
        let exceeded = self
            .exceeded_in_volume
            .iter_mut()
            .flat_map(|of| [&mut of.principal_strain, &mut of.von_mises_pa]);
        for of in exceeded.chain(self.percentiles.iter_mut().filter_map(|of| of.mps95.as_mut())) {
            mark(&mut of.quantity, of.time_s, looked_at);
        }
        for peak in self.peaks.list_mut().into_iter().flatten() {
            mark(&mut peak.quantity, peak.time_s, looked_at);
        }
        for dose in &mut self.dose_volumes {
            let largest = dose.volume_mm3.value;
            mark(&mut dose.volume_mm3, dose.volume_at_end_mm3, largest);
        }
        self.significant_stress.iter_mut().for_each(|stress| stress.mark_lower_bounds((lasts, looked_at)));
    }
}

impl SignificantStress {
    /// Given whether contact lasts, and when stresses were last evaluated [s].
    fn mark_lower_bounds(&mut self, (lasts, looked_at): (bool, f64)) {
        // No stress above the threshold has no depth and no volume that could grow.
        let is_reached = !self.layers.is_empty();
        let goes_deeper = lasts && is_at(self.depth_time_s, looked_at);
        let grows = lasts && is_at(self.volume_at_end_mm3.value, self.volume_mm3.value);
        let mark = |quantity: &mut Quantity, grows: bool, ends: &[String]| {
            quantity.is_lower_bound = is_reached && (grows && !is_most(quantity) || !ends.is_empty());
        };
        self.depth_mm.iter_mut().for_each(|depth| mark(depth, goes_deeper, &self.depth_reaches));
        mark(&mut self.volume_mm3, grows, &self.reaches);
    }

    /// Whether it is as deep as the tissue, and at no artificial end of the model there.
    pub(super) fn reaches_greatest_depth(&self) -> bool {
        self.depth_reaches.is_empty() && self.depth_mm.as_ref().is_some_and(is_most)
    }
}

/// Whether a number is as large as is possible.
fn is_most(quantity: &Quantity) -> bool {
    quantity.value > 0.0 && quantity.possible[1].is_some_and(|most| is_at(quantity.value, most))
}

/// Whether a time or a value is not below the last or the largest one.
fn is_at(this: f64, end: f64) -> bool {
    this >= end * (1.0 - SAME)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use QuantityOfInterest::{
        AbsorbedEnergyJ, DeflectionMm, EnergyGivenJ, ImpulseNS, LargestPatchAreaMm2, PatchAreaMm2,
        PeakForceN, StressDepthMm,
    };
    use serde_json::{Value, json};

    /// End of the run, and of contact with it where it lasts [s].
    const END: f64 = 0.004;

    /// The numbers of the example in the documentation, after changes at JSON pointers.
    fn marked(changes: &[(String, Value)]) -> Results {
        let summary = include_str!("../../../api/examples/summary.response.json");
        let mut results = serde_json::from_str::<Value>(summary).unwrap()["results"].take();
        for (pointer, value) in changes {
            let (parent, name) = pointer.rsplit_once('/').unwrap();
            results.pointer_mut(parent).unwrap()[name] = value.clone();
        }
        let mut results: Results = serde_json::from_value(results).unwrap();
        results.mark_lower_bounds(END);
        results
    }

    /// A run whose numbers were all largest halfway, and whose contact has ended, after changes.
    fn with(changes: &[(String, Value)]) -> Results {
        let middle = json!(0.5 * END);
        let layer = json!({"part": "block", "depth_mm": [0.0, 2.0], "volume_mm3": 9.0});
        let ended = [
            (impact("contact_ended"), json!(true)),
            (impact("contact_span_s"), json!([0.0, END])),
            (impact("peak_force_time_s/value"), middle.clone()),
            (impact("largest_patch_time_s"), middle.clone()),
            (impact("force_window_s"), json!(0.001)),
            (tissue("contact_ended"), json!(true)),
            (tissue("looked_at_until_s"), json!(END)),
            (tissue("peak_absorbed_energy_time_s/value"), middle.clone()),
            (tissue("deflection_mm/time_s"), middle.clone()),
            (tissue("exceeded_in_volume"), Value::Null),
            (tissue("peak_principal_strain/time_s"), middle.clone()),
            (stress("depth_time_s"), middle),
            (stress("depth_reaches"), json!([])),
            (stress("reaches"), json!([])),
            (stress("volume_mm3/value"), json!(9.0)),
            (stress("volume_at_end_mm3/value"), json!(4.0)),
            (stress("layers"), json!([layer])),
        ];
        marked(&ended.iter().chain(changes).cloned().collect::<Vec<_>>())
    }

    fn impact(name: &str) -> String {
        format!("/impacts/0/{name}")
    }
    fn tissue(name: &str) -> String {
        format!("/tissue/{name}")
    }
    fn stress(name: &str) -> String {
        tissue(&format!("significant_stress/0/{name}"))
    }
    fn found(results: &Results) -> Vec<QuantityOfInterest> {
        lower_bounds(results).into_iter().collect()
    }

    #[test]
    fn what_the_end_of_the_tissue_cuts_off_is_a_lower_bound() {
        assert_eq!(found(&with(&[])), []);
        let bone = json!(["the held nodes “bone”"]);
        assert_eq!(found(&with(&[(stress("depth_reaches"), bone.clone())])), [StressDepthMm]);
        let volume = with(&[(stress("reaches"), bone)]);
        assert!(volume.tissue.as_ref().unwrap().significant_stress[0].volume_mm3.is_lower_bound);
        assert_eq!(found(&volume), []);
    }

    #[test]
    fn a_depth_and_a_volume_that_are_as_large_as_is_possible_are_lower_bounds_at_an_artificial_end_alone() {
        let all = [
            (tissue("contact_ended"), json!(false)),
            (impact("contact_ended"), json!(false)),
            (stress("depth_time_s"), json!(END)),
            (stress("depth_mm/possible"), json!([0.0, 20.0])),
            (stress("volume_mm3/possible"), json!([0.0, 9.0])),
            (stress("volume_at_end_mm3/value"), json!(9.0)),
        ];
        let bounds = |depth: f64, ends: &Value| {
            let here = [
                (stress("depth_mm/value"), json!(depth)),
                (stress("depth_reaches"), ends.clone()),
                (stress("reaches"), ends.clone()),
            ];
            let results = with(&all.iter().chain(&here).cloned().collect::<Vec<_>>());
            let stress = &results.tissue.as_ref().unwrap().significant_stress[0];
            let depth = stress.depth_mm.as_ref().unwrap().is_lower_bound;
            (depth, stress.volume_mm3.is_lower_bound, stress.reaches_greatest_depth())
        };
        assert_eq!(bounds(20.0, &json!([])), (false, false, true));
        assert_eq!(bounds(20.0, &json!(["the held nodes “bone”"])), (true, true, false));
        // It may still become deeper.
        assert_eq!(bounds(19.0, &json!([])), (true, false, false));
    }

    #[test]
    fn what_still_grows_when_the_run_ends_is_a_lower_bound() {
        let lasts = [(impact("contact_ended"), json!(false)), (tissue("contact_ended"), json!(false))];
        // All were larger before; the duration grows with contact.
        let past = with(&lasts);
        assert_eq!(found(&past), [ImpulseNS]);
        assert!(past.impacts[0].contact_duration_s.is_lower_bound);
        // The window of the force, and that after the patch, reach the end.
        let late = |name: &str, time: f64| (impact(name), json!(time));
        let of_contact = [late("peak_force_time_s/value", 0.0035), late("largest_patch_time_s", 0.003)];
        let both: Vec<_> = lasts.iter().chain(&of_contact).cloned().collect();
        assert_eq!(found(&with(&both)), [PeakForceN, ImpulseNS, LargestPatchAreaMm2, PatchAreaMm2]);
        let [_, patch] = of_contact;
        let patch: Vec<_> = lasts.iter().cloned().chain([patch]).collect();
        assert_eq!(found(&with(&patch)), [ImpulseNS, LargestPatchAreaMm2]);
        // Of the tissue.
        let of_tissue = [
            (tissue("peak_absorbed_energy_time_s/value"), json!(END)),
            (tissue("deflection_mm/time_s"), json!(END)),
            (stress("depth_time_s"), json!(END)),
            (stress("volume_at_end_mm3/value"), json!(9.0)),
        ];
        let grown = with(&lasts.iter().chain(&of_tissue).cloned().collect::<Vec<_>>());
        assert_eq!(found(&grown), [ImpulseNS, EnergyGivenJ, AbsorbedEnergyJ, StressDepthMm, DeflectionMm]);
        let grown = grown.tissue.unwrap();
        assert!(
            grown.significant_stress[0].volume_mm3.is_lower_bound
                && grown.peak_absorbed_energy_j.is_lower_bound
        );
        // The same at the end of a contact that is over are no bounds.
        assert_eq!(found(&with(&of_tissue)), []);
    }
}
