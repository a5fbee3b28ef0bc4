//! Numbers of the summary.

use super::quantity::Quantity;
use super::written::short;
use crate::measure::impulse_history::{ImpulseHistory, PeakForce};
use serde::{Deserialize, Serialize, Serializer};
use std::borrow::Cow;
use std::sync::Arc;

/// All numbers of the summary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Whether the run has ended without contact: then no number describes an impact, and none has an error.
    pub nothing_touched: bool,
    /// One entry for each contact pair, of more than 64 only for those that touched; self-contact pairs come last, and are omitted if they
    /// never touched.
    #[serde(serialize_with = "serialize_reported")]
    pub impacts: Vec<Impact>,
    /// Response of the tissue; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tissue: Option<Tissue>,
    /// Indices of the headline numbers.
    pub headline: Headline,
}

#[allow(clippy::ptr_arg)] // serde's signature
fn serialize_reported<S: Serializer>(impacts: &Vec<Impact>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(impacts.iter().filter(|impact| impact.is_reported()))
}

/// Selects the numbers shown where only some are: the same everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Headline {
    /// Index in `impacts` of the contact with the largest peak force, among those on the tissue, or among all if there
    /// are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impact: Option<usize>,
    /// Index in the tissue's `significant_stress`: the first threshold of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub significant_stress: Option<usize>,
}

/// Numbers, shown or withheld.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// Results of a run that passed its acceptance checks.
    Results(Results),
    /// Results withheld because an acceptance check failed.
    Withheld {
        /// The failed check, with its value and limit.
        reason: String,
        /// Suggested change of the scene.
        remedy: &'static str,
        /// Computed values; not to be used as results.
        values: Results,
    },
}

/// Results of one contact pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::struct_excessive_bools)] // facts, each by itself
pub struct Impact {
    /// Name of the pair: those of its two bodies, joined by a dash.
    pub pair: String,
    /// Names of slave and master.
    pub between: [String; 2],
    /// Whether exactly one of them is the tissue.
    pub on_tissue: bool,
    /// Peak force: largest mean force over the window, max |ΔI|/τ, or largest filtered force [N].
    pub peak_force_n: Quantity,
    /// Middle of that window, or time of the largest filtered force [s].
    pub peak_force_time_s: Quantity,
    /// How the force was averaged, as text.
    pub force_average: String,
    /// The window τ [s]; absent where the force is filtered instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_window_s: Option<f64>,
    /// Channel frequency class of the force filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_filter: Option<Cow<'static, str>>,
    /// Impulse history, if the window depends on the run, to evaluate the force over another window.
    #[serde(skip)]
    pub history: Option<Arc<ImpulseHistory>>,
    /// Effect of the position of the window relative to the steps on the peak force, part of its error [N].
    pub peak_force_placing_n: f64,
    /// Largest force of a single step [N]: not a converged quantity.
    pub peak_step_force_n: Quantity,
    /// Norm of the impulse so far [N s].
    pub impulse_n_s: Quantity,
    /// Body on which the impulse vector acts: the tissue, or else the first of `between`.
    pub impulse_on: String,
    /// The impulse on that body [N s].
    pub impulse_vector_n_s: [f64; 3],
    /// Time with contact [s].
    pub contact_duration_s: Quantity,
    /// First and last time with contact [s]; absent if they never touched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_span_s: Option<[f64; 2]>,
    /// Whether contact has ended.
    pub contact_ended: bool,
    /// Whether both sides are rigid and touch in points: then there is no patch.
    pub touches_in_points: bool,
    /// Patch area, averaged over the window of the peak force; a node counts as in contact until it was last pressed the length of
    /// a window ago, and gaps of up to two nodes between nodes in contact are closed [mm²].
    pub patch_area_mm2: Quantity,
    /// Long axis of the patch, averaged likewise [mm].
    pub patch_long_axis_mm: Quantity,
    /// Short axis of the patch, averaged likewise [mm].
    pub patch_short_axis_mm: Quantity,
    /// Largest patch area at any time [mm²].
    pub largest_patch_area_mm2: Quantity,
    /// Latest time at which the patch was as large as that [s]; absent without a patch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_patch_time_s: Option<f64>,
    /// Nodes across the patch where it is narrowest, at the peak force and at the largest patch.
    pub nodes_across_patch: [u32; 2],
    /// Energy dissipated by friction [J].
    pub friction_dissipation_j: Quantity,
    /// Numerical contact dissipation [J].
    pub numerical_contact_dissipation_j: Quantity,
}

impl Impact {
    /// Whether this is self-contact.
    pub fn is_of_itself(&self) -> bool {
        self.between[0] == self.between[1]
    }

    /// Whether to list it: self-contact that never touched is omitted.
    pub fn is_reported(&self) -> bool {
        self.contact_span_s.is_some() || !self.is_of_itself()
    }

    /// Re-evaluates the peak force and the patch over another window τ > 0 [s]; only if the window depends on the run.
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

/// Response of the tissue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tissue {
    /// Velocity of the reference frame of the energies: that of the tissue's support, or of the tissue when it was
    /// first touched.
    pub frame_velocity_m_per_s: [f64; 3],
    /// Energy given to the tissue by the impact at the end: the absorbed energy plus the numerical contact dissipation,
    /// which a finer mesh would have passed on to it [J]. It converges faster than the absorbed energy alone.
    pub energy_given_j: Quantity,
    /// Energy absorbed at the end: strain + kinetic + dissipated − work not from contact [J].
    pub absorbed_energy_j: Quantity,
    /// Energy absorbed at the end, from the work of the contact reactions [J].
    pub absorbed_energy_by_work_j: Quantity,
    /// Components of the absorbed energy at the end.
    pub absorbed_split: Split,
    /// Largest energy absorbed at any time [J].
    pub peak_absorbed_energy_j: Quantity,
    /// Time of that maximum [s].
    pub peak_absorbed_energy_time_s: Quantity,
    /// Components of the absorbed energy at that time.
    pub peak_absorbed_split: Split,
    /// Whether contact with the tissue has ended: if not, the absorbed energy is not final.
    pub contact_ended: bool,
    /// Strain + kinetic energy lost by the projectile [J]; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub projectile_loss_j: Option<Quantity>,
    /// Latest time at which stresses and strains were evaluated [s]. What follows covers the times until then, and is
    /// absent if an incomplete run was evaluated at its start only.
    pub looked_at_until_s: f64,
    /// Depth and volume of significant stress, one entry for each threshold.
    pub significant_stress: Vec<SignificantStress>,
    /// Volumes in which the measures of the scene exceed its thresholds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dose_volumes: Vec<DoseVolume>,
    /// Strain and stress exceeded in a volume; absent if the tissue is smaller, or if they would be those of points beyond
    /// the limits of their laws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exceeded_in_volume: Option<ExceededInVolume>,
    /// Percentiles of the strain in each part.
    pub percentiles: Vec<Percentiles>,
    /// Peak values of the fields.
    #[serde(flatten)]
    pub peaks: Peaks,
    /// Largest displacement of a node of the surface over all steps [mm].
    pub deflection_mm: Located,
    /// Largest product of the surface's largest deflection and its rate over all steps [m²/s]: divided by the depth of the
    /// chest it is the viscous criterion.
    pub viscous_response_m2_per_s: Quantity,
}

impl Tissue {
    /// Whether energies refer to a moving frame.
    pub fn has_moving_frame(&self) -> bool {
        self.frame_velocity_m_per_s.iter().any(|v| *v != 0.0)
    }
}

/// Components of the absorbed energy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// Strain energy of the tissue [J].
    pub strain_j: Quantity,
    /// Kinetic energy of the tissue [J].
    pub kinetic_j: Quantity,
    /// Recoverable energy, strain + kinetic [J].
    pub recoverable_j: Quantity,
    /// Energy dissipated by bulk viscosity and by the time integrator [J].
    pub dissipated_j: Quantity,
    /// Work of loads and of the position projection: contained in the components above, but not absorbed from the
    /// impact, and therefore subtracted from their sum [J].
    pub not_from_contact_j: Quantity,
}

/// A peak with its place and time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Located {
    /// Largest value over time and place, in the unit of the field that holds it, with its numerical error.
    #[serde(flatten)]
    pub quantity: Quantity,
    /// Reference position of the peak [m].
    pub position_m: [f64; 3],
    /// Time of the peak [s].
    pub time_s: f64,
}

/// Region above a threshold of von Mises stress, evaluated at the field times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignificantStress {
    /// Threshold of the von Mises stress [Pa].
    pub threshold_pa: f64,
    /// Largest depth below the surface, in the reference configuration, at which the stress exceeds the threshold: that of the
    /// points around each node, linear between nodes [mm]; absent if no surface is given or found to measure it from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<Quantity>,
    /// Largest change of the depth if the stress that it is read from is shifted by the bound of its error, which follows
    /// from the scatter of the quadrature points [mm]: part of the depth's error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_resolution_mm: Option<f64>,
    /// Time at which that depth was reached [s].
    pub depth_time_s: f64,
    /// Largest reference volume above the threshold at any field time [mm³].
    pub volume_mm3: Quantity,
    /// Reference volume above the threshold at the end of the run [mm³].
    pub volume_at_end_mm3: Quantity,
    /// Edge of the largest cube represented by a quadrature point above the threshold [mm]: half of it times the
    /// surface of a sphere of that volume is part of the volumes' errors.
    pub point_spacing_mm: f64,
    /// Volume above the threshold that no wave from the contact can have reached, maximum over the field times [mm³]: a
    /// mesh artefact, excluded from all other numbers.
    pub numerical_volume_mm3: f64,
    /// Ends of the tissue that the region reaches, as text: the model truncates its volume there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reaches: Vec<String>,
    /// Those of them at which it is as deep as anywhere: the model truncates its depth, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub depth_reaches: Vec<String>,
    /// Parts of the tissue above the threshold.
    pub layers: Vec<StressedLayer>,
}

/// Region of one part above a threshold of von Mises stress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StressedLayer {
    /// Name of the part, as in the scene.
    pub part: String,
    /// Least and largest depth below the surface at which its stress exceeds the threshold, over all field times [mm]; absent
    /// if no surface is given or found to measure it from, and if only single points exceed the threshold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<[f64; 2]>,
    /// Largest reference volume of the part above the threshold at any field time, which need not be that at which all parts together have
    /// most of it: they add up to more [mm³].
    pub volume_mm3: f64,
}

/// Field to which a threshold of the scene applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DoseMeasure {
    /// Strain energy density [J/m³].
    #[serde(rename = "strain_energy_density_j_per_m3")]
    StrainEnergyDensity,
    /// Principal Green–Lagrange strain [-].
    #[serde(rename = "principal_strain")]
    PrincipalStrain,
}

impl DoseMeasure {
    /// "energy density above 5 kJ/m³", for a threshold in the unit of the measure.
    pub(super) fn above(self, threshold: f64) -> String {
        match self {
            Self::StrainEnergyDensity => format!("energy density above {} kJ/m³", short(1e-3 * threshold)),
            Self::PrincipalStrain => format!("principal strain above {}", short(threshold)),
        }
    }
}

/// The volume in which a measure exceeds a threshold that the scene sets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DoseVolume {
    /// Field that the threshold applies to.
    pub measure: DoseMeasure,
    /// The threshold, in the unit of the measure.
    pub threshold: f64,
    /// Largest reference volume above it at any field time [mm³].
    pub volume_mm3: Quantity,
    /// Reference volume above it when it was last evaluated [mm³].
    #[serde(skip)]
    pub volume_at_end_mm3: f64,
    /// Edge of the largest cube represented by a quadrature point, as in [`SignificantStress`] [mm].
    pub point_spacing_mm: f64,
}

/// Strain and stress that are exceeded in a volume, maxima over the field times. Unlike peaks at points they converge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExceededInVolume {
    /// The reference volume [mm³].
    pub volume_mm3: f64,
    /// Largest principal Green–Lagrange strain exceeded in that volume [-].
    pub principal_strain: Exceeded,
    /// Von Mises stress exceeded in that volume [Pa].
    pub von_mises_pa: Exceeded,
}

/// A value exceeded in a volume, with its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exceeded {
    /// Largest value that is exceeded in the volume at any field time, with its numerical error.
    #[serde(flatten)]
    pub quantity: Quantity,
    /// Field time at which the value is largest [s].
    pub time_s: f64,
    /// Difference from the value exceeded in a volume enlarged by half a point spacing all around; part of the error.
    #[serde(skip)]
    pub resolution: f64,
    /// Whether fewer than 64 points, or eight hexahedra, represent the volume: then it is treated as a peak at a point.
    #[serde(skip)]
    pub is_peak: bool,
}

/// Percentiles by reference volume in a part of the tissue, maxima over the field times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// Name of the part, as in the scene.
    pub part: String,
    /// Reference volume of the part [mm³].
    pub volume_mm3: f64,
    /// Largest principal Green–Lagrange strain below which 95 % of that volume lie (MPS95) [-]; absent if it would be that
    /// of points beyond the limit of the law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mps95: Option<Exceeded>,
}

/// Largest values of the fields at quadrature points, at the field times. They need not converge.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// All three peaks, present or absent.
    pub(super) fn list_mut(&mut self) -> [&mut Option<Located>; 3] {
        [
            &mut self.peak_von_mises_pa,
            &mut self.peak_principal_strain,
            &mut self.peak_strain_energy_density_j_per_m3,
        ]
    }
}

impl Results {
    /// The contact of the headline.
    pub fn headline_impact(&self) -> Option<&Impact> {
        self.impacts.get(self.headline.impact?)
    }

    /// Whether all numbers are finite.
    pub(super) fn is_finite(&mut self) -> bool {
        self.list_mut().into_iter().flatten().all(|listed| listed.quantity.value.is_finite())
    }
}
