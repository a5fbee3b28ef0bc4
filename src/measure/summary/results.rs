//! The numbers of the summary.

use super::quantity::Quantity;
use crate::measure::impulse_history::{ImpulseHistory, PeakForce};
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// The numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Results {
    /// Whether the run has ended, and nothing touched: then no number here is of an impact, and none has an error.
    pub nothing_touched: bool,
    /// One for each contact pair; bodies that meet themselves come last. Of those that did not, none is told.
    #[serde(serialize_with = "told")]
    pub impacts: Vec<Impact>,
    /// The tissue; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tissue: Option<Tissue>,
    /// Which of them stand for all.
    pub headline: Headline,
}

#[allow(clippy::ptr_arg)] // serde's signature
fn told<S: Serializer>(impacts: &Vec<Impact>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(impacts.iter().filter(|impact| impact.is_told()))
}

/// Which numbers stand for all where only some are shown: the same everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Headline {
    /// Index of the contact in `impacts`: with the largest peak force of those on the tissue, of all where none is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impact: Option<usize>,
    /// Index in the tissue's `significant_stress`: the first threshold of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub significant_stress: Option<usize>,
}

/// Numbers, plain or withheld.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// The gates were passed.
    Results(Results),
    /// A gate was failed.
    Withheld {
        /// Which, and by how much.
        reason: String,
        /// What to do about it.
        remedy: &'static str,
        /// What was computed; not to be used as results.
        values: Results,
    },
}

/// What one contact pair did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Impact {
    /// Name of the pair.
    pub pair: String,
    /// Slave and master.
    pub between: [String; 2],
    /// Whether one of them is the tissue, and the other is not.
    pub on_tissue: bool,
    /// Largest mean force over the window: max |ΔI|/τ; or the largest filtered force [N].
    pub peak_force_n: Quantity,
    /// Middle of that window, or when the filtered force is largest [s].
    pub peak_force_time_s: Quantity,
    /// How the force was averaged, in words.
    pub force_average: String,
    /// The window τ [s]; absent where the force is filtered instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_window_s: Option<f64>,
    /// The channel frequency class that it is filtered by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_filter: Option<&'static str>,
    /// What the force over another window would come from, where the window depends on the run.
    #[serde(skip)]
    pub history: Option<Arc<ImpulseHistory>>,
    /// What the place of the window among the steps does to the peak force, part of its error [N].
    pub peak_force_placing_n: f64,
    /// Largest force of a single step [N]: not a converged quantity.
    pub peak_step_force_n: Quantity,
    /// Norm of the impulse so far [N s].
    pub impulse_n_s: Quantity,
    /// The body that the impulse vector acts on: the tissue, or else the first of `between`.
    pub impulse_on: String,
    /// The impulse on that body [N s].
    pub impulse_vector_n_s: [f64; 3],
    /// Time with contact [s].
    pub contact_duration_s: Quantity,
    /// First and last time with contact [s]; absent when they never touched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_span_s: Option<[f64; 2]>,
    /// Whether contact has ended.
    pub contact_ended: bool,
    /// Whether the sides are rigid and touch in points: then there is no patch.
    pub touches_in_points: bool,
    /// Area of the patch, its mean over the window of the peak force [mm²].
    pub patch_area_mm2: Quantity,
    /// Its long axis, the mean as well [mm].
    pub patch_long_axis_mm: Quantity,
    /// Its short axis, the mean as well [mm].
    pub patch_short_axis_mm: Quantity,
    /// Largest area at any time [mm²].
    pub largest_patch_area_mm2: Quantity,
    /// Nodes across the short axis, at the peak force and when the patch was largest.
    pub nodes_across_patch: [u32; 2],
    /// Dissipated by friction [J].
    pub friction_dissipation_j: Quantity,
    /// Numerical contact dissipation [J].
    pub numerical_contact_dissipation_j: Quantity,
}

impl Impact {
    /// Whether it is of a body with itself.
    pub fn is_of_itself(&self) -> bool {
        self.between[0] == self.between[1]
    }

    /// Whether it is worth telling: a body that does not fold is no news.
    pub fn is_told(&self) -> bool {
        self.contact_span_s.is_some() || !self.is_of_itself()
    }

    /// Tells the peak force, and the patch, over another window τ > 0 [s]; only where the window depends on the run.
    pub(super) fn average_over(&mut self, window: f64) {
        let Some(history) = &self.history else { return };
        let PeakForce { force, time, patch, placing } = history.peak_over(window);
        self.force_window_s = Some(window);
        self.peak_force_placing_n = placing;
        self.nodes_across_patch[0] = patch.nodes_across;
        for (quantity, value) in [
            (&mut self.peak_force_n, force),
            (&mut self.peak_force_time_s, time),
            (&mut self.patch_area_mm2, 1e6 * patch.area),
            (&mut self.patch_long_axis_mm, 1e3 * patch.axes[0]),
            (&mut self.patch_short_axis_mm, 1e3 * patch.axes[1]),
        ] {
            quantity.value = value;
        }
    }
}

/// What happened to the tissue.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tissue {
    /// Velocity of the frame that energies are told in: of whoever holds the tissue, or of the tissue when it was first touched.
    pub frame_velocity_m_per_s: [f64; 3],
    /// Energy that the impact has given the tissue at the end: what it has absorbed, and the numerical contact dissipation, which a finer
    /// mesh would have passed on to it [J]. It converges faster than the absorbed energy alone.
    pub energy_given_j: Quantity,
    /// Energy absorbed at the end: strain + kinetic + dissipated − what did not come through contact [J].
    pub absorbed_energy_j: Quantity,
    /// The same from the work of the contact reactions [J].
    pub absorbed_energy_by_work_j: Quantity,
    /// Its parts at the end.
    pub absorbed_split: Split,
    /// Largest energy absorbed at any time [J].
    pub peak_absorbed_energy_j: Quantity,
    /// When [s].
    pub peak_absorbed_energy_time_s: Quantity,
    /// Its parts at that time.
    pub peak_absorbed_split: Split,
    /// Whether contact with the tissue has ended: if not, the absorbed energy is not final.
    pub contact_ended: bool,
    /// Strain + kinetic energy lost by the projectile [J]; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub projectile_loss_j: Option<Quantity>,
    /// The latest time at which stresses and strains were looked at [s]. What follows is of the times until then, and absent
    /// where a run that did not come to its end was looked at at its start only.
    pub looked_at_until_s: f64,
    /// Depth and volume of significant stress, one for each threshold.
    pub significant_stress: Vec<SignificantStress>,
    /// Volumes in which the measures of the scene exceed its thresholds.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dose_volumes: Vec<DoseVolume>,
    /// Largest values of the fields.
    #[serde(flatten)]
    pub peaks: Peaks,
    /// Largest displacement of a node of the skin, of all steps [mm].
    pub deflection_mm: Located,
    /// Largest product of the skin's largest deflection and its rate, of all steps [m²/s]: over the depth of the chest it is the
    /// viscous criterion.
    pub viscous_response_m2_per_s: Quantity,
}

impl Tissue {
    /// Whether energies are told in a frame that moves.
    pub fn has_moving_frame(&self) -> bool {
        self.frame_velocity_m_per_s.iter().any(|v| *v != 0.0)
    }
}

/// Parts of the absorbed energy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Split {
    /// Strain energy [J].
    pub strain_j: Quantity,
    /// Kinetic energy [J].
    pub kinetic_j: Quantity,
    /// Strain + kinetic: what the tissue could give back [J].
    pub recoverable_j: Quantity,
    /// Dissipated by bulk viscosity and by the time integrator [J].
    pub dissipated_j: Quantity,
    /// Work of loads and of the position projection: in the parts above, but not absorbed from the impact, and so taken off their
    /// sum [J].
    pub not_from_contact_j: Quantity,
}

/// A peak, where and when.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Located {
    /// The number.
    #[serde(flatten)]
    pub quantity: Quantity,
    /// Reference position [m].
    pub position_m: [f64; 3],
    /// Time [s].
    pub time_s: f64,
}

/// What exceeds a threshold of von Mises stress, evaluated at the field times.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignificantStress {
    /// The threshold [Pa].
    pub threshold_pa: f64,
    /// Largest depth below the skin, in the reference configuration [mm]; absent when the tissue has no skin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<Quantity>,
    /// From there to the next deeper quadrature point, which is not above the threshold [mm]: part of the depth's error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_gap_mm: Option<f64>,
    /// When [s].
    pub depth_time_s: f64,
    /// Largest reference volume above the threshold at any field time [mm³].
    pub volume_mm3: Quantity,
    /// That volume at the end [mm³].
    pub volume_at_end_mm3: Quantity,
    /// Edge of the cube that stands for a quadrature point above the threshold, the largest [mm]: half of it times the surface of a
    /// ball of the volume is part of the volumes' errors.
    pub point_spacing_mm: f64,
    /// Volume above the threshold where no wave from the contact can have been [mm³]: of the mesh, in no other number here. The largest at
    /// any field time.
    pub numerical_volume_mm3: f64,
    /// Which ends of the tissue it reaches, in words: depth and volume end there because the model does.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reaches: Vec<String>,
    /// The parts of the tissue that exceed it.
    pub layers: Vec<StressedLayer>,
}

/// What of one part exceeds a threshold of von Mises stress.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StressedLayer {
    /// Name of the part.
    pub part: String,
    /// From which to which depth below the skin its elements reach that do in some point, at any field time [mm]; absent when the
    /// tissue has no skin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<[f64; 2]>,
    /// Its largest volume above the threshold at any field time [mm³].
    pub volume_mm3: f64,
}

/// The volume in which a measure exceeds a threshold that the scene sets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DoseVolume {
    /// `strain_energy_density_j_per_m3` or `principal_strain`.
    pub measure: &'static str,
    /// The threshold, in the unit of the measure.
    pub threshold: f64,
    /// Largest reference volume above it at any field time [mm³].
    pub volume_mm3: Quantity,
    /// As of [`SignificantStress`] [mm].
    pub point_spacing_mm: f64,
}

/// Largest values of the fields at quadrature points, at the field times.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Peaks {
    /// Largest von Mises stress [Pa].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_von_mises_pa: Option<Located>,
    /// Largest principal Green–Lagrange strain [-].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_principal_strain: Option<Located>,
    /// Largest strain energy density [J/m³].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_strain_energy_density_j_per_m3: Option<Located>,
}

impl Peaks {
    /// All of them.
    pub(super) fn list_mut(&mut self) -> [&mut Option<Located>; 3] {
        [
            &mut self.peak_von_mises_pa,
            &mut self.peak_principal_strain,
            &mut self.peak_strain_energy_density_j_per_m3,
        ]
    }
}

impl Results {
    /// Whether the headline numbers are finite (NaN poisons sums, so they stand for the others).
    pub(super) fn is_finite(&self) -> bool {
        let impacts = self
            .impacts
            .iter()
            .flat_map(|i| [i.peak_force_n.value, i.impulse_n_s.value, i.patch_area_mm2.value]);
        let tissue = self.tissue.iter().flat_map(|t| {
            let von_mises = t.peaks.peak_von_mises_pa.as_ref().map_or(0.0, |peak| peak.quantity.value);
            [t.absorbed_energy_j.value, t.absorbed_energy_by_work_j.value, von_mises]
        });
        impacts.chain(tissue).all(f64::is_finite)
    }
}
