//! The numbers of the summary, made from the measures.

use super::super::absorbed_energy::Absorbed;
use super::super::measures::{Measures, PairMeasures};
use super::super::stress_depth::{Dose, Exceedance, Peak, StressDepth};
use super::{ErrorEstimate, GateResult, Quantity};
use crate::plan::Plan;
use serde::Serialize;

/// The numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Results {
    /// One for each contact pair.
    pub impacts: Vec<Impact>,
    /// The tissue; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tissue: Option<Tissue>,
}

/// What one contact pair did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Impact {
    /// Name of the pair.
    pub pair: String,
    /// Slave and master.
    pub between: [String; 2],
    /// Whether one of them is the tissue.
    pub on_tissue: bool,
    /// Largest mean force over the window: max |ΔI|/τ [N].
    pub peak_force_n: Quantity,
    /// Middle of that window [s].
    pub peak_force_time_s: Quantity,
    /// The window τ [s].
    pub force_window_s: f64,
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
    /// Area of the patch at the peak force [mm²].
    pub patch_area_mm2: Quantity,
    /// Its long axis [mm].
    pub patch_long_axis_mm: Quantity,
    /// Its short axis [mm].
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

/// What happened to the tissue.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tissue {
    /// Energy absorbed at the end: strain + kinetic + dissipated [J].
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
    /// Depth and volume of significant stress, one for each threshold.
    pub significant_stress: Vec<SignificantStress>,
    /// Volumes in which the measures of the scene exceed its thresholds.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dose_volumes: Vec<DoseVolume>,
    /// Largest von Mises stress at a quadrature point at a field time [Pa].
    pub peak_von_mises_pa: Located,
    /// Largest principal Green–Lagrange strain [-].
    pub peak_principal_strain: Located,
    /// Largest strain energy density [J/m³].
    pub peak_strain_energy_density_j_per_m3: Located,
    /// Largest displacement of a node of the skin [mm].
    pub deflection_mm: Located,
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
    /// Dissipated by bulk viscosity [J].
    pub dissipated_j: Quantity,
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
    /// When [s].
    pub depth_time_s: f64,
    /// Largest reference volume above the threshold at any field time [mm³].
    pub volume_mm3: Quantity,
    /// That volume at the end [mm³].
    pub volume_at_end_mm3: Quantity,
    /// The parts of the tissue that exceed it.
    pub layers: Vec<StressedLayer>,
}

/// What of one part exceeds a threshold of von Mises stress.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StressedLayer {
    /// Name of the part.
    pub part: String,
    /// Least and largest depth below the skin at which it does, at any field time [mm]; absent when the tissue has no skin.
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
}

/// Makes quantities that share one verdict.
#[derive(Clone, Copy)]
pub(super) struct Mint(pub GateResult);

impl Mint {
    fn quantity(self, value: f64) -> Quantity {
        // −0 would be printed as such.
        Quantity { value: value + 0.0, error: ErrorEstimate::NotEstimated, gate: self.0 }
    }
    fn located(self, scale: f64, peak: &Peak) -> Located {
        let position_m = peak.position.into();
        Located { quantity: self.quantity(scale * peak.value), position_m, time_s: peak.time }
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
            [t.absorbed_energy_j.value, t.absorbed_energy_by_work_j.value, t.peak_von_mises_pa.quantity.value]
        });
        impacts.chain(tissue).all(f64::is_finite)
    }
}

/// The numbers.
pub(super) fn results(measures: &Measures, plan: &Plan, mint: Mint) -> Results {
    let impacts =
        measures.pairs.iter().enumerate().map(|(index, pair)| impact(measures, plan, index, pair, mint));
    Results { impacts: impacts.collect(), tissue: tissue(measures, mint) }
}

fn impact(measures: &Measures, plan: &Plan, index: usize, pair: &PairMeasures, mint: Mint) -> Impact {
    let (force, now) = (&pair.force, pair.force.now());
    let patch = &force.peak.patch;
    let ledger = measures.energy.pairs.get(index).copied().unwrap_or_default();
    Impact {
        pair: pair.name.clone(),
        between: pair.between.clone(),
        on_tissue: pair.on_tissue,
        peak_force_n: mint.quantity(force.peak.force),
        peak_force_time_s: mint.quantity(force.peak.time),
        force_window_s: plan.measures.force_window,
        peak_step_force_n: mint.quantity(force.peak_step.0),
        impulse_n_s: mint.quantity(now.impulse.norm()),
        impulse_on: pair.between[pair.told_for].clone(),
        impulse_vector_n_s: if pair.told_for == 0 { now.impulse } else { -now.impulse }.into(),
        contact_duration_s: mint.quantity(force.contact_time),
        contact_span_s: force.contact_span,
        contact_ended: !force.is_touching(),
        patch_area_mm2: mint.quantity(1e6 * patch.area),
        patch_long_axis_mm: mint.quantity(1e3 * patch.axes[0]),
        patch_short_axis_mm: mint.quantity(1e3 * patch.axes[1]),
        largest_patch_area_mm2: mint.quantity(1e6 * force.largest_patch.area),
        nodes_across_patch: [patch.nodes_across, force.largest_patch.nodes_across],
        friction_dissipation_j: mint.quantity(ledger.friction_j),
        numerical_contact_dissipation_j: mint.quantity(ledger.numerical_j),
    }
}

/// The parts that exceed a threshold, from the skin inwards.
fn stressed_layers(stress: &StressDepth, exceedance: &Exceedance) -> Vec<StressedLayer> {
    let mut found: Vec<_> =
        stress.parts.iter().zip(&exceedance.layers).filter(|(_, layer)| layer.largest_volume > 0.0).collect();
    found.sort_by(|a, b| a.1.depth[0].total_cmp(&b.1.depth[0]));
    let of = |(part, layer): (&String, &crate::measure::stress_depth::Layer)| StressedLayer {
        part: part.clone(),
        depth_mm: stress.has_skin().then(|| layer.depth.map(|depth| 1e3 * depth)),
        volume_mm3: 1e9 * layer.largest_volume,
    };
    found.into_iter().map(of).collect()
}

fn tissue(measures: &Measures, mint: Mint) -> Option<Tissue> {
    let (absorbed, stress) = (measures.absorbed.as_ref()?, measures.stress.as_ref()?);
    let split = |a: &Absorbed| Split {
        strain_j: mint.quantity(a.strain),
        kinetic_j: mint.quantity(a.kinetic),
        recoverable_j: mint.quantity(a.recoverable()),
        dissipated_j: mint.quantity(a.dissipated),
    };
    let significant = stress.exceedances.iter().map(|e| SignificantStress {
        threshold_pa: e.threshold,
        depth_mm: stress.has_skin().then(|| mint.quantity(1e3 * e.depth)),
        depth_time_s: e.depth_time,
        volume_mm3: mint.quantity(1e9 * e.largest_volume),
        volume_at_end_mm3: mint.quantity(1e9 * e.volume),
        layers: stressed_layers(stress, e),
    });
    let doses = |measure: &'static str, doses: &[Dose]| {
        let of = |dose: &Dose| DoseVolume {
            measure,
            threshold: dose.threshold,
            volume_mm3: mint.quantity(1e9 * dose.largest_volume),
        };
        doses.iter().map(of).collect::<Vec<_>>()
    };
    let mut dose_volumes = doses("strain_energy_density_j_per_m3", &stress.energy_doses);
    dose_volumes.extend(doses("principal_strain", &stress.strain_doses));
    let d = &measures.deflection;
    let deflection = Peak { value: d.largest, position: d.position, time: d.time };
    Some(Tissue {
        absorbed_energy_j: mint.quantity(absorbed.now.by_state()),
        absorbed_energy_by_work_j: mint.quantity(absorbed.now.work),
        absorbed_split: split(&absorbed.now),
        peak_absorbed_energy_j: mint.quantity(absorbed.peak.by_state()),
        peak_absorbed_energy_time_s: mint.quantity(absorbed.peak.time),
        peak_absorbed_split: split(&absorbed.peak),
        contact_ended: !measures.pairs.iter().any(|p| p.on_tissue && p.force.is_touching()),
        projectile_loss_j: absorbed.has_projectile().then(|| mint.quantity(absorbed.projectile_loss)),
        significant_stress: significant.collect(),
        dose_volumes,
        peak_von_mises_pa: mint.located(1.0, &stress.von_mises),
        peak_principal_strain: mint.located(1.0, &stress.principal_strain),
        peak_strain_energy_density_j_per_m3: mint.located(1.0, &stress.energy_density),
        deflection_mm: mint.located(1e3, &deflection),
    })
}
