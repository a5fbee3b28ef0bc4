//! All numbers of a summary that can have an error bar, with the known limits of their resolution.

use super::super::exceeded::sampling_error;
use super::quantity::{ErrorEstimate, Quantity};
use super::results::{Exceeded, Impact, Results};

/// Fewest nodes along the short axis of a contact patch that resolve it.
pub(super) const NODES_ACROSS: u32 = 5;
/// The same in words, for a patch that has fewer.
pub(super) const FEW_NODES: &str = "fewer than five nodes across it";

/// A number with the limits of its resolution.
pub(super) struct Listed<'a> {
    pub quantity: &'a mut Quantity,
    /// Number of steps by which a time is uncertain: one for an instant, two for a duration.
    pub steps_known: u8,
    /// Additional resolution, in the unit of the number: for a value exceeded in a volume that of the measure, for a volume half the
    /// spacing of its points all around it, for a peak force the effect of the position of its window relative to the steps.
    pub spacing: f64,
    /// The mesh error is at least this large, in the unit of the number: for an absorbed energy its deficit, the numerical contact
    /// dissipation, for a depth its resolution.
    pub least_mesh_error: f64,
    /// Whether it is a maximum of a field at one or a few points, which may grow with every mesh.
    pub is_peak: bool,
    /// Whether the mesh is too coarse for it, whatever its error bar: a patch of a few nodes.
    pub is_too_coarse: bool,
}

impl<'a> Listed<'a> {
    fn sum(quantity: &'a mut Quantity) -> Self {
        Self {
            quantity,
            steps_known: 0,
            spacing: 0.0,
            least_mesh_error: 0.0,
            is_peak: false,
            is_too_coarse: false,
        }
    }
    fn time(quantity: &'a mut Quantity, steps_known: u8) -> Self {
        Self { steps_known, ..Self::sum(quantity) }
    }
    fn known_to(quantity: &'a mut Quantity, spacing: f64) -> Self {
        Self { spacing, ..Self::sum(quantity) }
    }
    /// Volume of points above a threshold, spaced this far apart [mm].
    fn volume(quantity: &'a mut Quantity, point_spacing_mm: f64) -> Self {
        Self { spacing: sampling_error(quantity.value, point_spacing_mm), ..Self::sum(quantity) }
    }
    fn exceeded(exceeded: &'a mut Exceeded) -> Self {
        let Exceeded { quantity, resolution, is_peak, .. } = exceeded;
        Self { spacing: *resolution, is_peak: *is_peak, ..Self::sum(quantity) }
    }
    /// Number of a contact patch with `nodes_across` nodes along its short axis.
    fn patch(quantity: &'a mut Quantity, nodes_across: u32) -> Self {
        Self { is_too_coarse: nodes_across < NODES_ACROSS, ..Self::sum(quantity) }
    }
    fn peak(quantity: &'a mut Quantity) -> Self {
        Self { is_peak: true, ..Self::sum(quantity) }
    }
}

impl Impact {
    /// Its numbers that can have an error bar, in a fixed order.
    fn list_mut(&mut self) -> [Listed<'_>; 10] {
        let touched = u8::from(self.contact_span_s.is_some());
        let [at_peak, largest] = if self.has_patch() { self.nodes_across_patch } else { [NODES_ACROSS; 2] };
        [
            Listed::known_to(&mut self.peak_force_n, self.peak_force_placing_n),
            Listed::time(&mut self.peak_force_time_s, touched),
            Listed::time(&mut self.contact_duration_s, 2 * touched),
            Listed::sum(&mut self.impulse_n_s),
            Listed::patch(&mut self.patch_area_mm2, at_peak),
            Listed::patch(&mut self.patch_long_axis_mm, at_peak),
            Listed::patch(&mut self.patch_short_axis_mm, at_peak),
            Listed::patch(&mut self.largest_patch_area_mm2, largest),
            Listed::sum(&mut self.friction_dissipation_j),
            Listed::sum(&mut self.numerical_contact_dissipation_j),
        ]
    }

    /// Whether it has a patch to resolve: points have none, and that of what never touched is known.
    pub(super) fn has_patch(&self) -> bool {
        self.contact_span_s.is_some() && !self.touches_in_points
    }

    /// Marks all its numbers as without an error: nothing touched.
    pub(super) fn mark_miss(&mut self) {
        self.peak_step_force_n.error = ErrorEstimate::NothingTouched;
        self.list_mut().into_iter().for_each(|listed| listed.quantity.error = ErrorEstimate::NothingTouched);
    }
}

impl Results {
    /// All numbers, in a fixed order, with a gap for each that this run lacks.
    pub(super) fn list_mut(&mut self) -> Vec<Option<Listed<'_>>> {
        let mut all = Vec::new();
        let on_tissue = self.impacts.iter().filter(|i| i.on_tissue);
        let lost: f64 = on_tissue.map(|i| i.numerical_contact_dissipation_j.value.abs()).sum();
        // Forces and patches of each contact.
        all.extend(self.impacts.iter_mut().flat_map(Impact::list_mut).map(Some));
        let Some(t) = &mut self.tissue else { return all };
        // Energies and peaks of the tissue.
        all.push(Some(Listed::time(&mut t.peak_absorbed_energy_time_s, 1)));
        let absorbed =
            [&mut t.absorbed_energy_j, &mut t.absorbed_energy_by_work_j, &mut t.peak_absorbed_energy_j];
        all.extend(absorbed.map(|energy| Some(Listed { least_mesh_error: lost, ..Listed::sum(energy) })));
        let sums = [&mut t.energy_given_j, &mut t.deflection_mm.quantity, &mut t.viscous_response_m2_per_s];
        all.extend(sums.map(|sum| Some(Listed::sum(sum))));
        all.push(t.projectile_loss_j.as_mut().map(Listed::sum));
        all.extend(t.peaks.list_mut().map(|peak| peak.as_mut().map(|peak| Listed::peak(&mut peak.quantity))));
        let exceeded = t.exceeded_in_volume.as_mut();
        let [strain, stress] =
            exceeded.map_or([None, None], |e| [Some(&mut e.principal_strain), Some(&mut e.von_mises_pa)]);
        let percentiles = t.percentiles.iter_mut().map(|of| of.mps95.as_mut());
        all.extend([strain, stress].into_iter().chain(percentiles).map(|of| of.map(Listed::exceeded)));
        for split in [&mut t.absorbed_split, &mut t.peak_absorbed_split] {
            let parts = [
                &mut split.strain_j,
                &mut split.kinetic_j,
                &mut split.recoverable_j,
                &mut split.dissipated_j,
                &mut split.not_from_contact_j,
            ];
            all.extend(parts.map(|part| Some(Listed::sum(part))));
        }
        // Depths and volumes above thresholds.
        for stress in &mut t.significant_stress {
            let (resolution, spacing) = (stress.depth_resolution_mm, stress.point_spacing_mm);
            let volumes = [&mut stress.volume_mm3, &mut stress.volume_at_end_mm3];
            all.extend(volumes.map(|volume| Some(Listed::volume(volume, spacing))));
            let depth = stress.depth_mm.as_mut();
            all.push(
                depth
                    .zip(resolution)
                    .map(|(depth, least_mesh_error)| Listed { least_mesh_error, ..Listed::sum(depth) }),
            );
        }
        let doses = t.dose_volumes.iter_mut();
        all.extend(doses.map(|dose| Some(Listed::volume(&mut dose.volume_mm3, dose.point_spacing_mm))));
        all
    }
}
