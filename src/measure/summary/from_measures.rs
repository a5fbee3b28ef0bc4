//! Composes the numbers of the summary from the measures.

use super::super::absorbed_energy::Absorbed;
use super::super::exceeded::{Dose, ExceededIn};
use super::super::law_range::LawRanges;
use super::super::measures::Measures;
use super::super::pair::PairMeasures;
use super::super::stress_depth::{Exceedance, Layer, Peak, StressDepth};
use super::quantity::{GateResult, Quantity};
use super::results::{
    DoseMeasure, DoseVolume, Exceeded, ExceededInVolume, Headline, Impact, Located, Peaks, Percentiles,
    Results, SignificantStress, Split, StressedLayer, Tissue,
};
use super::written::short_time;
use crate::plan::{ForceAverage, Plan};
use crate::step::Ending;
use std::sync::Arc;

/// Creates quantities that share one gate verdict.
#[derive(Clone, Copy)]
pub(super) struct Mint(pub GateResult);

impl Mint {
    fn quantity(self, value: f64) -> Quantity {
        // Adding zero turns −0 into 0, so that no minus sign is printed.
        Quantity::new(value + 0.0, self.0)
    }
    /// A number that cannot be negative.
    fn size(self, value: f64) -> Quantity {
        self.quantity(value).within_zero_and(None)
    }
    fn located(self, scale: f64, peak: &Peak) -> Located {
        let position_m = peak.position.into();
        Located { quantity: self.size(scale * peak.value), position_m, time_s: peak.time }
    }
    fn exceeded(self, of: &ExceededIn) -> Exceeded {
        Exceeded {
            quantity: self.size(of.value),
            time_s: of.time,
            resolution: of.resolution(),
            is_peak: of.is_peak(),
        }
    }
}

/// All numbers of the summary.
pub(super) fn results(measures: &Measures, plan: &Plan, ending: Option<&Ending>, mint: Mint) -> Results {
    let strikes: Vec<&str> = measures.strikes().map(|pair| pair.name.as_str()).collect();
    let mut impacts: Vec<Impact> = measures
        .listed_pairs()
        .map(|(index, pair)| impact(measures, index, pair, (mint, ending.is_some())))
        .collect();
    // Self-contact pairs come last.
    impacts.sort_by_key(Impact::is_of_itself);
    let tissue = tissue(measures, ending, mint);
    let headline = Headline {
        impact: headline_impact(&impacts, &strikes),
        significant_stress: tissue.as_ref().and_then(|t| (!t.significant_stress.is_empty()).then_some(0)),
    };
    let nothing_touched = ending.is_some() && has_missed(measures, plan);
    let mut results = Results { nothing_touched, impacts, tissue, headline };
    results.mark_lower_bounds(measures.time);
    results
}

/// Whether nothing touched the tissue, or, without tissue, nothing touched at all; false if loads act on the tissue as
/// well.
fn has_missed(measures: &Measures, plan: &Plan) -> bool {
    let has_tissue = measures.stress.is_some();
    let of_two = || measures.pairs.values().filter(|pair| !pair.is_of_itself());
    let mut counted = of_two().filter(|pair| pair.on_tissue || !has_tissue);
    let any = if has_tissue {
        plan.measures.moved_by_contact_alone
    } else {
        of_two().next().is_some() || plan.distant_pairs.iter().any(|pair| !pair.of_itself)
    };
    any && counted.all(|pair| pair.force.contact_span.is_none())
}

/// The contact with the largest peak force, among the pairs that strike the tissue if there are any.
fn headline_impact(impacts: &[Impact], strikes: &[&str]) -> Option<usize> {
    let is_candidate = |(_, impact): &(usize, &Impact)| {
        if strikes.is_empty() { !impact.is_of_itself() } else { strikes.contains(&impact.pair.as_str()) }
    };
    let candidates = impacts.iter().enumerate().filter(is_candidate);
    let force = |impact: &Impact| impact.peak_force_n.value;
    candidates.max_by(|(_, a), (_, b)| force(a).total_cmp(&force(b))).map(|(index, _)| index)
}

fn impact(measures: &Measures, index: usize, pair: &PairMeasures, (mint, has_ended): (Mint, bool)) -> Impact {
    let (force, now) = (&pair.force, pair.force.now());
    let peak = force.peak();
    let patch = &peak.patch;
    let ledger = measures.energy.pairs.get(index).copied().unwrap_or_default();
    Impact {
        pair: pair.name.clone(),
        between: pair.between.clone(),
        on_tissue: pair.on_tissue,
        peak_force_n: mint.size(peak.force),
        peak_force_time_s: mint.quantity(peak.time),
        force_average: force.words(short_time),
        force_window_s: force.window(),
        force_filter: match force.average() {
            ForceAverage::Filter(filter) => Some(filter.name().into()),
            ForceAverage::OfContact | ForceAverage::Window(_) => None,
        },
        history: force.history().filter(|_| has_ended).map(|history| Arc::new(history.clone())),
        peak_force_placing_n: peak.placing,
        peak_step_force_n: mint.size(force.peak_step.0),
        impulse_n_s: mint.size(now.impulse.norm()),
        impulse_on: pair.between[pair.reported_on].clone(),
        impulse_vector_n_s: if pair.reported_on == 0 { now.impulse } else { -now.impulse }.into(),
        contact_duration_s: mint.size(force.contact_time()),
        contact_span_s: force.contact_span,
        contact_ended: !force.is_in_contact(),
        touches_in_points: pair.is_of_points,
        patch_area_mm2: mint.size(1e6 * patch.area),
        patch_long_axis_mm: mint.size(1e3 * patch.axes[0]),
        patch_short_axis_mm: mint.size(1e3 * patch.axes[1]),
        largest_patch_area_mm2: mint.size(1e6 * force.largest_patch.area),
        largest_patch_time_s: force.largest_patch_time,
        nodes_across_patch: [patch.nodes_across, force.largest_patch.nodes_across],
        friction_dissipation_j: mint.size(ledger.friction_j),
        numerical_contact_dissipation_j: mint.quantity(ledger.numerical_j),
    }
}

/// The parts above a threshold, from the surface inwards.
fn stressed_layers(stress: &StressDepth, exceedance: &Exceedance) -> Vec<StressedLayer> {
    let mut found: Vec<_> =
        stress.parts.names.iter().zip(&exceedance.layers).filter(|(_, layer)| layer.is_reached()).collect();
    found.sort_by(|a, b| a.1.depth[0].total_cmp(&b.1.depth[0]));
    let of = |(part, layer): (&String, &Layer)| StressedLayer {
        part: part.clone(),
        depth_mm: layer.has_depth().then(|| layer.depth.map(|depth| 1e3 * depth)),
        volume_mm3: 1e9 * layer.largest_volume,
    };
    found.into_iter().map(of).collect()
}

fn tissue(measures: &Measures, ending: Option<&Ending>, mint: Mint) -> Option<Tissue> {
    let (absorbed, stress) = (measures.absorbed.as_ref()?, measures.stress.as_ref()?);
    // Changes of energies since the start: no energy is negative.
    let [strain, kinetic] = absorbed.at_start();
    let change = |value: f64, start: f64| mint.quantity(value).no_less_than(0.0 - start);
    let split = |a: &Absorbed| Split {
        strain_j: change(a.strain, strain),
        kinetic_j: change(a.kinetic, kinetic),
        recoverable_j: change(a.recoverable(), strain + kinetic),
        dissipated_j: mint.size(a.dissipated),
        not_from_contact_j: mint.quantity(a.not_from_contact),
    };
    // What the tissue absorbs ends at what the impact supplies.
    let supplied = absorbed.supplied();
    let energy = |value: f64| match supplied {
        Some(most) => mint.size(value).within_zero_and(Some(most)),
        None => mint.quantity(value),
    };
    // The zeros of the start would suggest that nothing happened.
    let is_looked_at = ending == Some(&Ending::Finished) || stress.time > 0.0;
    let peak = |peak: &Peak| is_looked_at.then(|| mint.located(1.0, peak));
    let d = &measures.deflection;
    let deflection = Peak { value: d.largest, position: d.position, time: d.time };
    Some(Tissue {
        frame_velocity_m_per_s: absorbed.velocity().into(),
        energy_given_j: energy(absorbed.now.given()),
        absorbed_energy_j: energy(absorbed.now.by_state()),
        absorbed_energy_by_work_j: energy(absorbed.now.work),
        absorbed_split: split(&absorbed.now),
        peak_absorbed_energy_j: energy(absorbed.peak.by_state()),
        peak_absorbed_energy_time_s: mint.quantity(absorbed.peak.time),
        peak_absorbed_split: split(&absorbed.peak),
        contact_ended: !measures.strikes().any(|pair| pair.force.is_in_contact()),
        projectile_loss_j: absorbed.has_free_projectile().then(|| mint.quantity(absorbed.projectile_loss)),
        looked_at_until_s: stress.time,
        significant_stress: if is_looked_at { significant_stress(stress, mint) } else { Vec::new() },
        dose_volumes: if is_looked_at { dose_volumes(stress, mint) } else { Vec::new() },
        exceeded_in_volume: exceeded_in_volume(stress, &measures.laws, mint).filter(|_| is_looked_at),
        percentiles: if is_looked_at { percentiles(stress, &measures.laws, mint) } else { Vec::new() },
        peaks: Peaks {
            peak_von_mises_pa: peak(&stress.von_mises),
            peak_principal_strain: peak(&stress.principal_strain),
            peak_strain_energy_density_j_per_m3: peak(&stress.energy_density),
        },
        deflection_mm: mint.located(1e3, &deflection),
        viscous_response_m2_per_s: mint.size(d.largest_rate),
    })
}

/// Reference volume of the tissue [mm³].
fn whole_mm3(stress: &StressDepth) -> f64 {
    1e9 * stress.parts.volumes.iter().sum::<f64>()
}

fn significant_stress(stress: &StressDepth, mint: Mint) -> Vec<SignificantStress> {
    let deepest = stress.deepest().map(|depth| 1e3 * depth);
    let volume = |value: f64| mint.size(1e9 * value).within_zero_and(Some(whole_mm3(stress)));
    let of = |e: &Exceedance| SignificantStress {
        threshold_pa: e.threshold,
        depth_mm: stress.has_skin().then(|| mint.size(1e3 * e.depth).within_zero_and(deepest)),
        depth_resolution_mm: stress.has_skin().then_some(1e3 * e.depth_resolution()),
        depth_time_s: e.depth_time,
        volume_mm3: volume(e.largest_volume),
        volume_at_end_mm3: volume(e.volume),
        point_spacing_mm: 1e3 * e.largest_point.cbrt(),
        numerical_volume_mm3: 1e9 * e.largest_numerical,
        reaches: stress.ends_of(e),
        depth_reaches: stress.ends_of_depth(e),
        layers: stressed_layers(stress, e),
    };
    stress.exceedances.iter().map(of).collect()
}

/// Strain and stress exceeded in a volume of the tissue, unless more than that is beyond the limits of the laws.
fn exceeded_in_volume(stress: &StressDepth, laws: &LawRanges, mint: Mint) -> Option<ExceededInVolume> {
    let (parts, volume) = (&stress.parts, stress.strain_in_volume.volume);
    let is_large_enough = parts.volumes.iter().sum::<f64>() >= volume;
    let is_valid = laws.volume_beyond(&parts.bodies, None) < volume;
    (is_large_enough && is_valid).then(|| ExceededInVolume {
        volume_mm3: 1e9 * volume,
        principal_strain: mint.exceeded(&stress.strain_in_volume),
        von_mises_pa: mint.exceeded(&stress.stress_in_volume),
    })
}

/// Percentiles of each part, unless more than the tail is beyond the limit of its law.
fn percentiles(stress: &StressDepth, laws: &LawRanges, mint: Mint) -> Vec<Percentiles> {
    let parts = &stress.parts;
    let of = |((part, volume), tail): ((&String, &f64), &ExceededIn)| {
        let is_valid = laws.volume_beyond(&parts.bodies, Some(part)) < tail.volume;
        Percentiles {
            part: part.clone(),
            volume_mm3: 1e9 * volume,
            mps95: is_valid.then(|| mint.exceeded(tail)),
        }
    };
    parts.names.iter().zip(&parts.volumes).zip(&stress.strain_percentiles).map(of).collect()
}

fn dose_volumes(stress: &StressDepth, mint: Mint) -> Vec<DoseVolume> {
    let doses = [
        (DoseMeasure::StrainEnergyDensity, &stress.energy_doses),
        (DoseMeasure::PrincipalStrain, &stress.strain_doses),
    ];
    let of = |(measure, doses): (DoseMeasure, &Vec<Dose>)| {
        let of = |dose: &Dose| DoseVolume {
            measure,
            threshold: dose.threshold,
            volume_mm3: mint.size(1e9 * dose.largest_volume).within_zero_and(Some(whole_mm3(stress))),
            volume_at_end_mm3: 1e9 * dose.volume,
            point_spacing_mm: 1e3 * dose.largest_point.cbrt(),
        };
        doses.iter().map(of).collect::<Vec<_>>()
    };
    doses.into_iter().flat_map(of).collect()
}
