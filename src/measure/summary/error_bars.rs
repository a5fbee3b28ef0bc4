//! Error bars: what a number may be off by, from cheaper runs of the same scene.
//!
//! Three runs on a mesh of half the numbers of elements: as the scene says, with half the step, and with a looser contact
//! solver. The first against the run itself gives the error of the mesh, the others against the first those of step and
//! solver. Orders are *assumed*, not observed, and said to be.

use super::{ErrorEstimate, Quantity, Results};
use serde::Serialize;

/// Ratio of element sizes, and of steps, from one run to the next finer one.
pub const REFINEMENT: f64 = 2.0;
/// The order of convergence that is assumed: impacts are of first order.
const ASSUMED_ORDER: f64 = 1.0;
/// Factor of safety on an error whose order is assumed (Roache 1994).
const SAFETY: f64 = 3.0;

/// A number's numerical error, in the number's own unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The sum of all.
    pub total: f64,
    /// Of the mesh.
    pub mesh: f64,
    /// Of the time step.
    pub step: f64,
    /// Of the contact solver's tolerance.
    pub contact: f64,
    /// Whether the number is larger than its error.
    pub resolved: bool,
}

/// Results of the cheaper runs.
#[derive(Clone, Debug, PartialEq)]
pub struct CheaperRuns {
    /// Ratio of the element sizes of the coarser mesh and the run's own [-]; the least where it is not the same everywhere.
    pub refinement: f64,
    /// On the coarser mesh.
    pub coarse: Results,
    /// There, with half the step.
    pub small_steps: Results,
    /// There, with a looser contact solver.
    pub loose_contact: Results,
}

/// Error of the finer of two values at an assumed first order, with a factor of safety of three; `refinement` is the ratio of
/// their element sizes or steps.
pub fn assumed_error(coarse: f64, fine: f64, refinement: f64) -> f64 {
    SAFETY * (fine - coarse).abs() / (refinement.powf(ASSUMED_ORDER) - 1.0)
}

impl Results {
    /// Gives every number its error bar; those that a cheaper run does not have keep theirs.
    pub(super) fn estimate_errors(&mut self, runs: &CheaperRuns) {
        let of = |results: &Results| {
            let mut results = results.clone();
            results.quantities_mut().iter().map(|quantity| quantity.value).collect::<Vec<_>>()
        };
        let [coarse, small_steps, loose] = [&runs.coarse, &runs.small_steps, &runs.loose_contact].map(of);
        let mut quantities = self.quantities_mut();
        let count = quantities.len();
        if [&coarse, &small_steps, &loose].iter().any(|values| values.len() != count) {
            return;
        }
        for (i, quantity) in quantities.iter_mut().enumerate() {
            let mesh = assumed_error(coarse[i], quantity.value, runs.refinement);
            let step = assumed_error(coarse[i], small_steps[i], REFINEMENT);
            // The tolerance is loosened far more than twofold: the difference itself is the bound.
            let contact = (loose[i] - coarse[i]).abs();
            let total = mesh + step + contact;
            if total.is_finite() {
                let resolved = total < quantity.value.abs();
                quantity.error = ErrorEstimate::Estimated(Estimate { total, mesh, step, contact, resolved });
            }
        }
    }

    /// Every number, in a fixed order.
    fn quantities_mut(&mut self) -> Vec<&mut Quantity> {
        let mut all = Vec::new();
        for i in &mut self.impacts {
            all.extend([
                &mut i.peak_force_n,
                &mut i.peak_force_time_s,
                &mut i.impulse_n_s,
                &mut i.contact_duration_s,
                &mut i.patch_area_mm2,
                &mut i.patch_long_axis_mm,
                &mut i.patch_short_axis_mm,
                &mut i.largest_patch_area_mm2,
                &mut i.friction_dissipation_j,
                &mut i.numerical_contact_dissipation_j,
            ]);
        }
        if let Some(t) = &mut self.tissue {
            all.extend([
                &mut t.absorbed_energy_j,
                &mut t.absorbed_energy_by_work_j,
                &mut t.peak_absorbed_energy_j,
                &mut t.peak_absorbed_energy_time_s,
                &mut t.peak_von_mises_pa.quantity,
                &mut t.peak_principal_strain.quantity,
                &mut t.peak_strain_energy_density_j_per_m3.quantity,
                &mut t.deflection_mm.quantity,
            ]);
            all.extend(&mut t.projectile_loss_j);
            for split in [&mut t.absorbed_split, &mut t.peak_absorbed_split] {
                all.extend([
                    &mut split.strain_j,
                    &mut split.kinetic_j,
                    &mut split.recoverable_j,
                    &mut split.dissipated_j,
                ]);
            }
            for stress in &mut t.significant_stress {
                all.extend([&mut stress.volume_mm3, &mut stress.volume_at_end_mm3]);
                all.extend(&mut stress.depth_mm);
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::summary::{GateResult, Impact};

    fn results(value: f64) -> Results {
        let quantity = || Quantity { value, error: ErrorEstimate::NotEstimated, gate: GateResult::Passed };
        let impact = Impact {
            pair: "a–b".into(),
            between: ["a".into(), "b".into()],
            on_tissue: true,
            peak_force_n: quantity(),
            peak_force_time_s: quantity(),
            force_window_s: 5e-6,
            peak_step_force_n: quantity(),
            impulse_n_s: quantity(),
            impulse_on: "b".into(),
            impulse_vector_n_s: [0.0; 3],
            contact_duration_s: quantity(),
            contact_span_s: None,
            contact_ended: true,
            patch_area_mm2: quantity(),
            patch_long_axis_mm: quantity(),
            patch_short_axis_mm: quantity(),
            largest_patch_area_mm2: quantity(),
            nodes_across_patch: [5, 5],
            friction_dissipation_j: quantity(),
            numerical_contact_dissipation_j: quantity(),
        };
        Results { impacts: vec![impact], tissue: None }
    }

    #[test]
    fn errors_come_from_the_differences() {
        let runs = CheaperRuns {
            refinement: 2.0,
            coarse: results(9.0),
            small_steps: results(9.1),
            loose_contact: results(8.99),
        };
        let mut own = results(10.0);
        own.estimate_errors(&runs);
        let ErrorEstimate::Estimated(error) = &own.impacts[0].peak_force_n.error else { panic!() };
        assert!((error.mesh - 3.0).abs() < 1e-12 && (error.step - 0.3).abs() < 1e-12, "{error:?}");
        assert!((error.contact - 0.01).abs() < 1e-12 && (error.total - 3.31).abs() < 1e-12 && error.resolved);
        // What is no converged quantity has no error bar.
        assert_eq!(own.impacts[0].peak_step_force_n.error, ErrorEstimate::NotEstimated);
    }

    #[test]
    fn a_number_below_its_error_is_not_resolved() {
        let mut own = results(1.0);
        let run = || results(2.0);
        own.estimate_errors(&CheaperRuns {
            refinement: 2.0,
            coarse: run(),
            small_steps: run(),
            loose_contact: run(),
        });
        let ErrorEstimate::Estimated(error) = &own.impacts[0].impulse_n_s.error else { panic!() };
        assert!(!error.resolved);
    }
}
