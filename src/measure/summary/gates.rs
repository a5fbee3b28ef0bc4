//! Gates and warnings: whether the numbers may be shown, and the caveats that accompany them.

use super::super::hourglass_energy::HOURGLASS_WARNING;
use super::super::measures::Measures;
use super::super::pair::PairMeasures;
use super::super::penetration::{DEPTH_LIMIT, Depth, OVERLAP_LIMIT, TOO_DEEP};
use super::erosion::{ErosionOfPart, erosion};
use super::laws::{LawRange, beyond_limit, left_laws, numerical_stress};
use super::listed::NODES_ACROSS;
use super::numerics::Numerics;
use super::quantity::GateResult;
use super::run_state::RunState;
use super::softening::{SofteningOfPart, softening};
use super::written::{number, seconds};
use crate::plan::Plan;
use crate::step::{Ending, Energy, FailureCause, Outcome};
use serde::Serialize;

/// Fraction of the energy scale above which numerical contact dissipation raises a warning [-].
const CONTACT_DISSIPATION_WARNING: f64 = 0.02;
/// Largest admissible energy created by contact, as a fraction of the energy scale [-].
const CONTACT_CREATION_LIMIT: f64 = 0.001;
/// Numerical contact dissipation over the energy scale above which the numbers are withheld [-].
const CONTACT_DISSIPATION_LIMIT: f64 = 0.5;
/// Work of the position projection over the energy scale above which the numbers are withheld [-].
const PROJECTION_LIMIT: f64 = 0.05;
/// Fraction of the energy scale above which the work of the position projection raises a warning [-].
const PROJECTION_WARNING: f64 = 0.01;
/// Fraction of a body's inertia above which redistributed mass raises a warning [-].
const INERTIA_WARNING: f64 = 0.01;
/// Energy that rigid bodies lose to each other, over the energy scale [-], above which a warning is issued.
const RIGID_IMPACT_WARNING: f64 = 0.01;
/// Fraction of a body's strain energy beyond the declared limits of its laws above which all numbers are withheld [-]; below,
/// only peaks.
const LAW_LIMIT: f64 = 0.05;
/// Gate for laws used beyond their limits, and its remedy.
const LAW_GATE: &str = "laws_within_limits";
const BEYOND_LAW: &str = "Lower the speed, or give that part a law or parameters that were fitted at such deformation; an earlier end helps with the same mesh only, since finer ones exceed the limit sooner; where you know \
                          how far a law holds, say so in the scene (`valid_to` of the material).";
/// Where no limit is declared, and the usual one is exceeded by as much.
const NOT_OF_TISSUE: &str = " The other numbers are those of the law, not of an intact tissue: no limit is declared for it, and the \
                             one usual for soft tissue and rubber does not hold. Choose a law that stiffens, or declare how far this one \
                             holds (`valid_to` of the material).";
/// Gate for the dissipation of contact on a coarse mesh, and its remedy.
const DISSIPATION_GATE: &str = "contact_dissipation_within_limit";
const PROJECTION_GATE: &str = "projection_within_limit";
const COARSE_CONTACT: &str = "Refine both surfaces where they meet: impact activation dissipates the energy of the contact nodes, and fewer, heavier nodes lose more.";
/// Gates for interpenetration of bodies.
const PENETRATION_GATE: &str = "penetration_within_limit";
const OVERLAP_GATE: &str = "overlap_within_limit";
/// Penetration depth over face size above which a warning is raised [-].
const PENETRATION_WARNING: f64 = 0.02;
/// Number of field times below which a warning is raised.
const FEW_SAMPLES: u32 = 20;
/// Steps in a force window below which a warning is raised.
const FEWEST_STEPS_OF_WINDOW: f64 = 2.0;

/// A check that decides whether the numbers may be shown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gate {
    /// Name of the gate for programs.
    pub name: &'static str,
    /// Meaning of the measured value.
    pub meaning: &'static str,
    /// Measured value, to be compared with the limit [-].
    pub value: f64,
    /// Limit of the value [-].
    pub limit: f64,
    /// Whether the value is within its limit.
    pub result: GateResult,
}

/// The gates of a run, from its ledger; the scene sets the limit of those of energy. They are the same checks that end
/// a run, so a run ended by a gate never reports it as passed.
pub(super) fn gates(energy: &Energy, numerics: &Numerics, limit: f64, is_static: bool) -> Vec<Gate> {
    let gate = |name, meaning, value: f64, limit: f64| {
        // Written so that NaN fails.
        let result = if value <= limit { GateResult::Passed } else { GateResult::Failed };
        Gate { name, meaning, value, limit, result }
    };
    // NaN propagates; dissipation counts as nothing created.
    let created =
        |lost: f64| if lost > 0.0 || energy.scale_j == 0.0 { 0.0 } else { -lost / energy.scale_j + 0.0 };
    // A quasi-static step has no integrator that could create energy.
    let algorithmic = if is_static { 0.0 } else { energy.algorithmic_j() };
    vec![
        gate("energy_balance", "largest error of the energy balance", numerics.balance_error, limit),
        gate(
            "contact_creates_no_energy",
            "energy created by contact over the energy scale",
            created(energy.least_contact_loss_j(is_static)),
            CONTACT_CREATION_LIMIT,
        ),
        gate(
            "integrator_creates_no_energy",
            "energy created by the time integrator over the energy scale",
            created(algorithmic),
            limit,
        ),
        gate(
            "absorbed_energy_agreement",
            "difference of the absorbed energy from the tissue's state and from the work of the reactions",
            numerics.absorbed_energy_disagreement,
            limit,
        ),
        gate(
            PENETRATION_GATE,
            "deepest penetration over the size of a face",
            numerics.deepest_penetration_fraction,
            DEPTH_LIMIT,
        ),
        gate(
            OVERLAP_GATE,
            "overlapping volume of two bodies over that of the smaller one",
            numerics.overlapped_volume_fraction,
            OVERLAP_LIMIT,
        ),
        gate(
            DISSIPATION_GATE,
            "numerical contact dissipation over the energy scale",
            numerics.numerical_contact_dissipation_fraction,
            CONTACT_DISSIPATION_LIMIT,
        ),
        gate(
            PROJECTION_GATE,
            "work of the position projection over the energy scale",
            if energy.turnover_j > 0.0 { projection_work(energy) / energy.turnover_j } else { 0.0 },
            PROJECTION_LIMIT,
        ),
        gate(
            LAW_GATE,
            "fraction of a body's strain energy beyond the declared limits of its laws; 1 if elements inverted",
            numerics.energy_fraction_beyond_declared_limits,
            LAW_LIMIT,
        ),
    ]
}

/// Why the numbers of a run are withheld, and the remedy.
pub(super) struct Withholding {
    pub reason: String,
    pub remedy: &'static str,
}

/// Checks whether the numbers must be withheld.
pub(super) fn withholding(
    gates: &[Gate],
    state: &RunState,
    measures: &Measures,
    numerics: &Numerics,
) -> Option<Withholding> {
    if let RunState::Failed { failure } = state
        && matches!(failure.cause, FailureCause::EnergyGate | FailureCause::NotFinite)
    {
        let reason = failure.message.trim_end_matches('.').to_owned();
        return Some(Withholding { reason, remedy: failure.cause.remedy() });
    }
    let failed = gates.iter().find(|g| g.result == GateResult::Failed)?;
    let beyond = || beyond_limit(&measures.laws).map(|excess| fraction_in_words(excess, numerics));
    Some(match (failed.name, measures.penetration.excess(), beyond()) {
        (LAW_GATE, _, Some(reason)) => Withholding { reason, remedy: BEYOND_LAW },
        (PENETRATION_GATE | OVERLAP_GATE, Some(reason), _) => Withholding { reason, remedy: TOO_DEEP },
        (name, ..) => Withholding {
            reason: format!(
                "the gate {} failed: {} is {:.3e}, at most {:.3e} is allowed",
                failed.name, failed.meaning, failed.value, failed.limit
            ),
            remedy: match name {
                DISSIPATION_GATE | PROJECTION_GATE => COARSE_CONTACT,
                _ => FailureCause::EnergyGate.remedy(),
            },
        },
    })
}

/// Appends the fraction of the strain energy, unless elements have inverted, which leaves it undefined.
fn fraction_in_words(excess: String, numerics: &Numerics) -> String {
    let fraction = numerics.energy_fraction_beyond_law;
    if fraction < 1.0 {
        format!("{excess}; {:.1} % of the strain energy was there", 100.0 * fraction)
    } else {
        excess
    }
}

/// Whether the pairs of every two bodies are too many to be listed.
fn every_two_meet(plan: &Plan) -> bool {
    plan.contact.as_ref().is_some_and(|contact| !contact.pairs.every_two().is_empty())
}

/// Where some of the tissue, but not enough to withhold all results, is beyond the limit of its law.
fn beyond_limit_warning(measures: &Measures, numerics: &Numerics) -> Option<String> {
    if numerics.energy_fraction_beyond_declared_limits > LAW_LIMIT {
        return None;
    }
    let excess = beyond_limit(&measures.laws)?;
    let is_much = numerics.energy_fraction_beyond_law > LAW_LIMIT;
    Some(format!(
        "{}: the peak stress, strain and energy density, which would be those of such points, are omitted.{}",
        fraction_in_words(excess, numerics),
        if is_much { NOT_OF_TISSUE } else { "" }
    ))
}

/// Warnings that follow from the measures.
pub(super) fn own_warnings(
    measures: &Measures,
    plan: &Plan,
    numerics: &Numerics,
    outcome: Option<&Outcome>,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let has_ended = outcome.is_some();
    // Force windows.
    let touched = measures.pairs.values().filter(|pair| has_ended && pair.force.contact_span.is_some());
    warnings.extend(touched.filter_map(|pair| window_warning(pair, measures.time)));
    let fraction = numerics.numerical_contact_dissipation_fraction;
    // At the end the stepper itself issues this warning.
    if fraction > CONTACT_DISSIPATION_WARNING && !has_ended {
        warnings.push(format!(
            "Numerical contact dissipation is {:.1} % of the energy scale (above {:.0} %): refine the contact surfaces.",
            100.0 * fraction,
            100.0 * CONTACT_DISSIPATION_WARNING
        ));
    }
    // Softening, erosion and laws beyond their range.
    warnings.extend(softening(&measures.laws).iter().map(SofteningOfPart::in_words));
    warnings.extend(erosion(&measures.eroded, plan).iter().map(ErosionOfPart::in_words));
    warnings.extend(left_laws(&measures.laws).iter().filter(|law| law.is_notable()).map(LawRange::in_words));
    warnings.extend(beyond_limit_warning(measures, numerics));
    // Artefacts, penetration and projection.
    warnings.extend(measures.stress.iter().flat_map(numerical_stress));
    warnings.extend(penetration_warning(&measures.penetration.deepest));
    warnings.extend(rigid_impact_warning(numerics));
    warnings.extend(projection_warning(&measures.energy));
    warnings.extend(body_warnings(measures, plan));
    // Sampling in time.
    if let Some(samples) = measures.stress.as_ref().map(|s| s.samples)
        && has_ended
        && samples < FEW_SAMPLES
    {
        warnings.push(format!(
            "Stress, strain, energy density and depth are from {samples} field times only, and peaks in between are \
             missed: a smaller `record.field_interval_s` samples more often."
        ));
    }
    warnings.extend(contact_warnings(measures, plan, outcome));
    warnings.extend(resolution_warnings(measures));
    warnings
}

/// Warns of energy that rigid bodies lost to each other, where it is a notable part of the energy scale.
fn rigid_impact_warning(numerics: &Numerics) -> Option<String> {
    let (lost, scale) = (numerics.rigid_impact_dissipation_j, numerics.energy_scale_j);
    (lost > RIGID_IMPACT_WARNING * scale).then(|| {
        format!(
            "Rigid bodies lost {} J, {:.1} % of the energy scale, when planes or other rigid bodies stopped them: they do not \
             rebound, as if all of their impact were plastic. Give one of the two a mesh where their rebound matters.",
            number(lost),
            100.0 * lost / scale
        )
    })
}

/// Warns of bodies with too little inertia of rotation, and of those whose mesh does not resolve their deformation.
fn body_warnings(measures: &Measures, plan: &Plan) -> Vec<String> {
    let mut warnings = Vec::new();
    for body in plan.bodies.iter().filter(|body| body.inertia_lost > INERTIA_WARNING) {
        warnings.push(format!(
            "Redistributed mass takes {:.1} % of the inertia of {}: its spin is wrong by as much. Refine its mesh, \
             or lower `contact.mass_redistribution`.",
            100.0 * body.inertia_lost,
            body.name
        ));
    }
    for (body, fraction) in plan.bodies.iter().zip(measures.hourglass.fractions()) {
        if fraction > HOURGLASS_WARNING {
            warnings.push(format!(
                "The stabilisation of {} (hourglass modes of one-point elements, crushed corners of others) held {:.1} % of its strain \
                 energy (above {:.0} %): its mesh does not resolve the deformation. Refine it.",
                body.name,
                100.0 * fraction,
                100.0 * HOURGLASS_WARNING
            ));
        }
    }
    warnings
}

/// Warns of contact that is missed or has not ended.
fn contact_warnings(measures: &Measures, plan: &Plan, outcome: Option<&Outcome>) -> Vec<String> {
    let mut warnings = Vec::new();
    let has_ended = outcome.is_some();
    // What a run had no time for is no fault of the scene.
    let is_finished = outcome.is_some_and(|outcome| outcome.ending == Ending::Finished);
    let missed = || plan.distant_pairs.iter().filter(|pair| pair.on_tissue);
    let is_joined =
        measures.pairs.values().any(|p| p.on_tissue) || missed().next().is_some() || every_two_meet(plan);
    if has_ended && measures.absorbed.is_some() && !is_joined {
        warnings.push("No contact pair involves the tissue: nothing can hit it.".to_owned());
    }
    if has_ended {
        warnings.extend(missed().map(|pair| {
            format!(
                "Nothing can touch in {} ({}): look at the direction of the velocity, the gap and the end time.",
                pair.name, pair.why
            )
        }));
    }
    // A body that strikes something need not touch the tissue itself.
    let has_struck = |body: &str| {
        let touched = measures.pairs.values().filter(|pair| pair.force.contact_span.is_some());
        touched.filter(|pair| !pair.is_of_itself()).any(|pair| pair.between.iter().any(|name| name == body))
    };
    for pair in measures.strikes().filter(|_| has_ended) {
        if is_finished
            && pair.force.contact_span.is_none()
            && !has_struck(&pair.between[1 - pair.reported_on])
        {
            warnings.push(format!(
                "Nothing touched in {}: look at the direction of the velocity, the gap and the end time.",
                pair.name
            ));
        }
        if pair.force.is_in_contact() {
            warnings
                .push(format!("Contact of {} has not ended: the absorbed energy is not final.", pair.name));
        }
    }
    warnings
}

/// Warns of contact patches that are not resolved, and of waves reflected from artificial ends of the model.
fn resolution_warnings(measures: &Measures) -> Vec<String> {
    let mut warnings = Vec::new();
    for pair in measures.pairs.values() {
        let patch = pair.force.peak().patch;
        if pair.force.contact_span.is_some() && !pair.is_of_points && patch.nodes_across < NODES_ACROSS {
            let nodes = match patch.nodes_across {
                1 => "Only one node lies".to_owned(),
                count => format!("Only {count} nodes lie"),
            };
            warnings.push(format!(
                "{nodes} across the contact patch of {} at the peak force (fewer than {NODES_ACROSS}): its area and the peak \
                 pressure are not resolved.",
                pair.name
            ));
        }
        if let Some(time) = wave_return(measures, pair)
            && time < measures.time
        {
            warnings.push(format!(
                "A wave from the contact of {} may have returned from an artificial end of the model from {:.1} µs on: make \
                 the model longer, or end the run earlier.",
                pair.name,
                1e6 * time
            ));
        }
    }
    warnings
}

/// Warns of a force window that is longer than the run, or shorter than two of its steps.
fn window_warning(pair: &PairMeasures, end: f64) -> Option<String> {
    let (window, step) = (pair.force.window()?, pair.force.mean_step());
    if end < window {
        return Some(format!(
            "The run ended after {}, less than the {} over which the force of {} is averaged: it has no peak force.",
            seconds(end),
            seconds(window),
            pair.name
        ));
    }
    (window < FEWEST_STEPS_OF_WINDOW * step).then(|| {
        format!(
            "The force of {} is averaged over {}, less than two steps of {}: its peak is one of single steps, which does not converge. \
             Omit `measures.force_window_s` (the window is then 1/10 of the contact, ten steps at least), or take shorter steps.",
            pair.name,
            seconds(window),
            seconds(step)
        )
    })
}

/// Total work of the position projection, summed over the bodies [J].
fn projection_work(energy: &Energy) -> f64 {
    energy.bodies.iter().map(|body| body.projection_j.abs()).sum()
}

fn projection_warning(energy: &Energy) -> Option<String> {
    let work = projection_work(energy);
    (work > PROJECTION_WARNING * energy.turnover_j).then(|| {
        format!(
            "The position projection did {} J of work, {:.1} % of the energy scale (above {:.0} %): energies are uncertain by as much.",
            number(work),
            100.0 * work / energy.turnover_j,
            100.0 * PROJECTION_WARNING
        )
    })
}

/// Warns of penetration deeper than contact normally leaves.
fn penetration_warning(deepest: &Depth) -> Option<String> {
    let Depth { depth, fraction, between, time } = deepest;
    (*fraction > PENETRATION_WARNING).then(|| {
        format!(
            "{between}: a point lay {} mm inside the other side at {}, {:.1} % of a face (above {:.0} %). {TOO_DEEP}",
            number(1e3 * depth),
            seconds(*time),
            100.0 * fraction,
            100.0 * PENETRATION_WARNING
        )
    })
}

/// Earliest time at which a wave from a pair's first contact can return from an artificial end [s].
fn wave_return(measures: &Measures, pair: &PairMeasures) -> Option<f64> {
    let (ends, [first, _]) = (measures.artificial_ends.as_ref()?, pair.force.contact_span?);
    let place = pair.force.first_contact.filter(|_| pair.on_tissue)?;
    Some(ends.earliest_return(place, first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::BodyEnergy;

    #[test]
    fn work_of_the_position_projection_is_warned_of_where_it_is_not_small() {
        let warned = |works: [f64; 2]| {
            let bodies = works.map(|projection_j| BodyEnergy { projection_j, ..BodyEnergy::default() });
            projection_warning(&Energy { turnover_j: 2.0, bodies: bodies.into(), ..Energy::default() })
        };
        // Contributions of opposite sign to two bodies do not cancel.
        assert!(warned([0.03, -0.01]).is_some_and(|w| w.contains("2.0 %")));
        assert_eq!(warned([0.01, 0.0]), None);
        assert_eq!(projection_warning(&Energy::default()), None);
    }

    #[test]
    fn energy_that_the_integrator_creates_fails_a_gate() {
        let failed = |algorithmic_j: f64, is_static: bool| {
            let body = BodyEnergy { algorithmic_j, ..BodyEnergy::default() };
            let energy = Energy { scale_j: 1.0, bodies: vec![body], ..Energy::default() };
            let gates = gates(&energy, &Numerics::default(), 0.01, is_static);
            let failed = gates.iter().filter(|gate| gate.result == GateResult::Failed);
            failed.map(|gate| gate.name).collect::<Vec<_>>()
        };
        assert_eq!(failed(-0.5154, false), ["integrator_creates_no_energy"]);
        assert_eq!(failed(f64::NAN, false), ["integrator_creates_no_energy"]);
        assert!(failed(0.5, false).is_empty() && failed(-0.5, true).is_empty());
    }
}
