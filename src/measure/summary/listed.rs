//! All numbers of a summary that can have an error bar, and what is known of each besides its value.

use super::quantity::Quantity;
use super::results::{Impact, Results};
use std::f64::consts::PI;

/// A number.
pub(super) struct Listed<'a> {
    pub quantity: &'a mut Quantity,
    /// Steps that a time is only known to: it begins or ends within one, a duration does both.
    pub steps_known: u8,
    /// What it is only known to besides, in the unit of the number: a place to the distance of the points that were looked at, a
    /// volume to half of that all around it, a peak of the force to where its window lies among the steps.
    pub spacing: f64,
    /// What is known to be missing, in the unit of the number: of an absorbed energy what contact lost numerically. The mesh's error
    /// should say as much, and is no less.
    pub missing: f64,
    /// Whether it is the largest value of a field at a point: such a one may grow with every mesh.
    pub is_peak: bool,
}

impl<'a> Listed<'a> {
    fn sum(quantity: &'a mut Quantity) -> Self {
        Self { quantity, steps_known: 0, spacing: 0.0, missing: 0.0, is_peak: false }
    }
    fn time(quantity: &'a mut Quantity, steps_known: u8) -> Self {
        Self { steps_known, ..Self::sum(quantity) }
    }
    fn place(quantity: &'a mut Quantity, spacing: Option<f64>) -> Self {
        Self { spacing: spacing.unwrap_or(0.0), ..Self::sum(quantity) }
    }
    /// Of points above a threshold, so far apart [mm]: the surface around them lies anywhere up to half of that further in or out. It
    /// is taken as large as that of a ball, the least there is.
    fn volume(quantity: &'a mut Quantity, point_spacing_mm: f64) -> Self {
        let surface = (36.0 * PI * quantity.value.powi(2)).cbrt();
        Self { spacing: 0.5 * point_spacing_mm * surface, ..Self::sum(quantity) }
    }
    fn peak(quantity: &'a mut Quantity) -> Self {
        Self { is_peak: true, ..Self::sum(quantity) }
    }
}

impl Impact {
    /// Every number of it.
    pub(super) fn quantities_mut(&mut self) -> [&mut Quantity; 11] {
        [
            &mut self.peak_force_n,
            &mut self.peak_force_time_s,
            &mut self.peak_step_force_n,
            &mut self.impulse_n_s,
            &mut self.contact_duration_s,
            &mut self.patch_area_mm2,
            &mut self.patch_long_axis_mm,
            &mut self.patch_short_axis_mm,
            &mut self.largest_patch_area_mm2,
            &mut self.friction_dissipation_j,
            &mut self.numerical_contact_dissipation_j,
        ]
    }
}

impl Results {
    /// Every number, in a fixed order.
    pub(super) fn list_mut(&mut self) -> Vec<Listed<'_>> {
        let mut all = Vec::new();
        let on_tissue = self.impacts.iter().filter(|i| i.on_tissue);
        let lost: f64 = on_tissue.map(|i| i.numerical_contact_dissipation_j.value.abs()).sum();
        for i in &mut self.impacts {
            all.push(Listed::place(&mut i.peak_force_n, Some(i.peak_force_placing_n)));
            let touched = u8::from(i.contact_span_s.is_some());
            all.extend([
                Listed::time(&mut i.peak_force_time_s, touched),
                Listed::time(&mut i.contact_duration_s, 2 * touched),
            ]);
            let sums = [
                &mut i.impulse_n_s,
                &mut i.patch_area_mm2,
                &mut i.patch_long_axis_mm,
                &mut i.patch_short_axis_mm,
                &mut i.largest_patch_area_mm2,
                &mut i.friction_dissipation_j,
                &mut i.numerical_contact_dissipation_j,
            ];
            all.extend(sums.map(Listed::sum));
        }
        let Some(t) = &mut self.tissue else { return all };
        all.push(Listed::time(&mut t.peak_absorbed_energy_time_s, 1));
        let absorbed =
            [&mut t.absorbed_energy_j, &mut t.absorbed_energy_by_work_j, &mut t.peak_absorbed_energy_j];
        all.extend(absorbed.map(|energy| Listed { missing: lost, ..Listed::sum(energy) }));
        let sums = [&mut t.energy_given_j, &mut t.deflection_mm.quantity, &mut t.viscous_response_m2_per_s];
        all.extend(sums.into_iter().chain(&mut t.projectile_loss_j).map(Listed::sum));
        all.extend(t.peaks.list_mut().into_iter().flatten().map(|peak| Listed::peak(&mut peak.quantity)));
        for split in [&mut t.absorbed_split, &mut t.peak_absorbed_split] {
            let parts = [
                &mut split.strain_j,
                &mut split.kinetic_j,
                &mut split.recoverable_j,
                &mut split.dissipated_j,
                &mut split.not_from_contact_j,
            ];
            all.extend(parts.map(Listed::sum));
        }
        for stress in &mut t.significant_stress {
            let (gap, spacing) = (stress.depth_gap_mm, stress.point_spacing_mm);
            let volumes = [&mut stress.volume_mm3, &mut stress.volume_at_end_mm3];
            all.extend(volumes.map(|volume| Listed::volume(volume, spacing)));
            all.extend(stress.depth_mm.iter_mut().map(|depth| Listed::place(depth, gap)));
        }
        let doses = t.dose_volumes.iter_mut();
        all.extend(doses.map(|dose| Listed::volume(&mut dose.volume_mm3, dose.point_spacing_mm)));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ErrorEstimate, GateResult};
    use super::*;

    /// A ball of radius 10 among points of a grid of spacing 1: however it lies, the sum of their volumes is off by less than half a
    /// spacing times its surface.
    #[test]
    fn a_sampled_volume_is_known_to_half_a_spacing_all_around() {
        let exact = 4.0 / 3.0 * PI * 1000.0;
        for shift in [0.0, 0.1, 0.25, 0.4, 0.5] {
            let line = || (-12..=12).map(|i| f64::from(i) + shift);
            let inside = |x: f64, y: f64| line().filter(|z| x * x + y * y + z * z < 100.0).count();
            let sampled: usize =
                line().flat_map(|x| line().map(move |y| (x, y))).map(|(x, y)| inside(x, y)).sum();
            let mut quantity = Quantity {
                value: sampled as f64,
                error: ErrorEstimate::NotEstimated,
                gate: GateResult::Passed,
            };
            let resolution = Listed::volume(&mut quantity, 1.0).spacing;
            assert!((sampled as f64 - exact).abs() < resolution, "{sampled} ± {resolution} of {exact}");
            assert!((resolution / (0.5 * 4.0 * PI * 100.0) - 1.0).abs() < 0.02, "{resolution}");
        }
    }

    #[test]
    fn a_volume_of_nothing_has_no_surface() {
        let mut nothing =
            Quantity { value: 0.0, error: ErrorEstimate::NotEstimated, gate: GateResult::Passed };
        assert!(Listed::volume(&mut nothing, 1.0).spacing <= 0.0);
    }
}
