//! All numbers of a summary that can have an error bar, and what is known of each besides its value.

use super::{Quantity, Results};

/// A number.
pub(super) struct Listed<'a> {
    pub quantity: &'a mut Quantity,
    /// Steps that a time is only known to: it begins or ends within one, a duration does both.
    pub steps_known: u8,
    /// What it is only known to besides, in the unit of the number: a place to the distance of the points that were looked at, a
    /// peak of the force to where its window lies among the steps.
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
    fn peak(quantity: &'a mut Quantity) -> Self {
        Self { is_peak: true, ..Self::sum(quantity) }
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
        let sums = [&mut t.deflection_mm.quantity, &mut t.viscous_response_m2_per_s];
        all.extend(sums.into_iter().chain(&mut t.projectile_loss_j).map(Listed::sum));
        let peaks = [
            &mut t.peak_von_mises_pa,
            &mut t.peak_principal_strain,
            &mut t.peak_strain_energy_density_j_per_m3,
        ];
        all.extend(peaks.into_iter().flatten().map(|peak| Listed::peak(&mut peak.quantity)));
        for split in [&mut t.absorbed_split, &mut t.peak_absorbed_split] {
            let parts = [
                &mut split.strain_j,
                &mut split.kinetic_j,
                &mut split.recoverable_j,
                &mut split.dissipated_j,
            ];
            all.extend(parts.map(Listed::sum));
        }
        for stress in &mut t.significant_stress {
            all.extend([&mut stress.volume_mm3, &mut stress.volume_at_end_mm3].map(Listed::sum));
            let gap = stress.depth_gap_mm;
            all.extend(stress.depth_mm.iter_mut().map(|depth| Listed::place(depth, gap)));
        }
        all.extend(t.dose_volumes.iter_mut().map(|dose| Listed::sum(&mut dose.volume_mm3)));
        all
    }
}
