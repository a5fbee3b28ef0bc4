//! Warnings: the caveats that accompany the numbers, each with how much it limits their use.

use super::super::hourglass_energy::HOURGLASS_WARNING;
use super::super::law_range::PartRange;
use super::super::measures::Measures;
use super::super::pair::PairMeasures;
use super::super::penetration::{Depth, TOO_DEEP};
use super::erosion::{ErosionOfPart, erosion};
use super::gates::{LAW_LIMIT, projection_work};
use super::laws::{
    beyond_limit, law_rates, left_laws, numerical_stress, ranges_in_words, rates_in_words,
    unstated_ranges_in_words,
};
use super::listed::NODES_ACROSS;
use super::numerics::Numerics;
use super::of_interest::QuantityOfInterest;
use super::quantity::ErrorEstimate;
use super::results::Results;
use super::softening::{SofteningOfPart, softening};
use super::squeezed::squeezed_in_words;
use super::warning_list::{Gravity, Warnings};
use super::words::in_a_row;
use super::written::{number, seconds};
use crate::plan::Plan;
use crate::step::{Ending, Energy, Outcome};

/// Fraction of the energy scale above which numerical contact dissipation raises a warning [-].
const CONTACT_DISSIPATION_WARNING: f64 = 0.02;
/// Fraction of the energy scale above which the work of the position projection raises a warning [-].
const PROJECTION_WARNING: f64 = 0.01;
/// Fraction of a body's inertia above which redistributed mass raises a warning [-].
const INERTIA_WARNING: f64 = 0.01;
/// Energy that rigid bodies lose to each other, over the energy scale [-], above which a warning is issued.
const RIGID_IMPACT_WARNING: f64 = 0.01;
/// Where no limit is declared, and the usual one is exceeded by as much.
const NOT_OF_TISSUE: &str = " The other numbers are those of the law, not of an intact tissue: no limit is declared for it, and the \
                             usual one for soft tissue and rubber is exceeded. Choose a law that stiffens, or declare how far this one \
                             holds (`valid_to` of the material).";
/// Penetration depth over face size above which a warning is raised [-].
const PENETRATION_WARNING: f64 = 0.02;
/// The same in units of what contact leaves to nodes [-].
const MARGIN: f64 = 1.1;
/// Number of field times below which a warning is raised.
const FEW_SAMPLES: u32 = 20;
/// Steps in a force window below which a warning is raised.
const FEWEST_STEPS_OF_WINDOW: f64 = 2.0;

/// Whether the pairs of every two bodies are too many to be listed.
fn every_two_meet(plan: &Plan) -> bool {
    plan.contact.as_ref().is_some_and(|contact| !contact.pairs.every_two().is_empty())
}

/// Where some of the tissue, but not enough to withhold all results, is beyond the limit of its law.
fn beyond_limit_warning(measures: &Measures, numerics: &Numerics) -> Option<String> {
    if numerics.energy_fraction_beyond_declared_limits > LAW_LIMIT {
        return None;
    }
    let laws = &measures.laws;
    let worst = laws.worst()?;
    let is_much = |part: &&PartRange| part.has_turned_over || laws.fraction_of(part) > LAW_LIMIT;
    let undeclared = laws.worst_undeclared().filter(is_much);
    let other = undeclared.filter(|part| !std::ptr::eq(*part, worst));
    let found: Vec<String> =
        [Some(worst), other].into_iter().flatten().map(|part| beyond_limit(laws, part)).collect();
    Some(format!(
        "The largest stress, strain and energy density at a point are omitted, since a material was deformed beyond its limit: {}.{}",
        found.join("; "),
        if undeclared.is_some() { NOT_OF_TISSUE } else { "" }
    ))
}

/// Warnings of validation, of the stepper and of the measures, without repetition.
pub(super) fn warnings(
    measures: &Measures,
    plan: &Plan,
    numerics: &Numerics,
    outcome: Option<&Outcome>,
) -> Warnings {
    let mut all = Warnings::default();
    all.add(Gravity::Remark, measures.scene_warnings.iter().cloned());
    // What makes numbers wrong.
    all.add(Gravity::Wrong, measures.squeeze.worst.as_ref().and_then(squeezed_in_words));
    all.add(Gravity::Wrong, beyond_limit_warning(measures, numerics));
    // Accuracy, with what the stepper says of its steps and solvers.
    all.add(Gravity::Coarse, measures.stress.as_ref().and_then(numerical_stress));
    resolution_warnings(&mut all, measures);
    body_warnings(&mut all, measures, plan);
    all.add(Gravity::Inaccurate, outcome.iter().flat_map(|outcome| outcome.warnings.iter().cloned()));
    force_warnings(&mut all, measures, numerics, outcome.is_some());
    all.add(Gravity::Inaccurate, penetration_warning(&measures.penetration.deepest));
    all.add(Gravity::Inaccurate, rigid_impact_warning(&measures.energy));
    all.add(Gravity::Inaccurate, projection_warning(&measures.energy));
    all.add(Gravity::Inaccurate, sampling_warning(measures).filter(|_| outcome.is_some()));
    // Softening, erosion and laws beyond their range.
    all.add(Gravity::Remark, softening(&measures.laws).iter().map(SofteningOfPart::in_words));
    all.add(Gravity::Remark, erosion(&measures.eroded, plan).iter().map(ErosionOfPart::in_words));
    all.add(Gravity::BeyondRange, ranges_in_words(&left_laws(&measures.laws)));
    all.add(Gravity::Untested, unstated_ranges_in_words(&measures.laws));
    all.add(Gravity::Untested, rates_in_words(&law_rates(&measures.laws)));
    contact_warnings(&mut all, measures, plan, outcome);
    all
}

/// Warns of main numbers of a run that went to its end and that the mesh does not resolve, or whose error is unknown.
pub(super) fn doubtful_numbers(all: &mut Warnings, results: &Results) {
    let titles = |is_meant: fn(&ErrorEstimate) -> bool| {
        let is_meant =
            |of: &QuantityOfInterest| of.number(results).is_some_and(|number| is_meant(&number.error));
        let headline = QuantityOfInterest::HEADLINE.into_iter().filter(is_meant);
        headline.map(QuantityOfInterest::title).collect::<Vec<&str>>()
    };
    let coarse = match &titles(ErrorEstimate::is_unresolved)[..] {
        [] => None,
        [one] => Some(format!("one of the main numbers, the {one}")),
        several => Some(format!("some of the main numbers ({})", in_a_row(several))),
    };
    let coarse =
        coarse.map(|titles| format!("The mesh is too coarse for {titles}: an order of magnitude, no more."));
    all.add(Gravity::NotResolved, coarse);
    let unknown = titles(|error| *error == ErrorEstimate::NotEstimated);
    let unknown = (!unknown.is_empty()).then(|| {
        format!("The numerical error of the main numbers was not estimated: {}.", in_a_row(&unknown))
    });
    all.add(Gravity::NotResolved, unknown);
}

/// Warns of windows of the force, and of energy lost in contact so far.
fn force_warnings(all: &mut Warnings, measures: &Measures, numerics: &Numerics, has_ended: bool) {
    let touched = measures.pairs.values().filter(|pair| has_ended && pair.force.contact_span.is_some());
    let windows: Vec<Window> = touched.filter_map(Window::of).collect();
    all.add(Gravity::Inaccurate, window_warnings(&windows, measures.time));
    let fraction = numerics.numerical_contact_dissipation_fraction;
    // At the end the stepper itself issues this warning.
    let is_notable = fraction > CONTACT_DISSIPATION_WARNING && !has_ended;
    let warning = is_notable.then(|| {
        format!(
            "The computation of contact loses {:.1} % of {} (above {:.0} %): a finer mesh at the contact reduces it.",
            100.0 * fraction,
            measures.energy.turnover_in_words(),
            100.0 * CONTACT_DISSIPATION_WARNING
        )
    });
    all.add(Gravity::Inaccurate, warning);
}

/// Warns of fields that were evaluated at few times.
fn sampling_warning(measures: &Measures) -> Option<String> {
    let samples = measures.stress.as_ref()?.samples;
    (samples < FEW_SAMPLES).then(|| {
        format!(
            "Stress, strain and depth were evaluated at {samples} instants only, so that peaks in between are missed: record \
             fields more often."
        )
    })
}

/// Warns of energy that rigid bodies lost to each other, where it is a notable part of the turnover.
fn rigid_impact_warning(energy: &Energy) -> Option<String> {
    let lost = energy.impact_j();
    (lost > RIGID_IMPACT_WARNING * energy.turnover_j).then(|| {
        format!(
            "Rigid bodies do not rebound from planes and from each other: {} J were lost so, {:.1} % of {}. Mesh one of the two where \
             their rebound matters.",
            number(lost),
            100.0 * lost / energy.turnover_j,
            energy.turnover_in_words()
        )
    })
}

/// Warns of bodies with too little inertia of rotation, and of those whose mesh does not resolve their deformation.
fn body_warnings(all: &mut Warnings, measures: &Measures, plan: &Plan) {
    let heavy = plan.bodies.iter().filter(|body| body.inertia_lost > INERTIA_WARNING).map(|body| {
        format!(
            "The spin of {} is wrong by up to {:.1} %: mass redistribution removes as much of its rotational inertia. Refine its mesh, \
             or lower `contact.mass_redistribution`.",
            body.name,
            100.0 * body.inertia_lost
        )
    });
    all.add(Gravity::Inaccurate, heavy);
    let fractions = plan.bodies.iter().zip(measures.hourglass.fractions());
    let stabilised = fractions.filter(|(_, fraction)| *fraction > HOURGLASS_WARNING).map(|(body, fraction)| {
        format!(
            "The mesh of {} is too coarse for its deformation: the stabilisation of its elements (hourglass modes, crushed corners) held \
             {:.1} % of its strain energy (above {:.0} %). Refine it.",
            body.name,
            100.0 * fraction,
            100.0 * HOURGLASS_WARNING
        )
    });
    all.add(Gravity::Coarse, stabilised);
}

/// Warns of contact that is missed or has not ended.
fn contact_warnings(all: &mut Warnings, measures: &Measures, plan: &Plan, outcome: Option<&Outcome>) {
    // What a run in progress has not touched it still may.
    let Some(outcome) = outcome else { return };
    // What a run had no time for is no fault of the scene.
    let is_finished = outcome.ending == Ending::Finished;
    let missed = || plan.distant_pairs.iter().filter(|pair| pair.on_tissue);
    let is_joined =
        measures.pairs.values().any(|p| p.on_tissue) || missed().next().is_some() || every_two_meet(plan);
    if measures.absorbed.is_some() && !is_joined {
        all.add(Gravity::NoImpact, ["No contact pair involves the tissue: nothing can hit it.".to_owned()]);
    }
    let cannot = missed().map(|pair| {
        format!(
            "Nothing can touch in {} ({}): check the direction of the velocity, the gap and the end time.",
            pair.name, pair.why
        )
    });
    all.add(Gravity::Remark, cannot);
    // A body that strikes something need not touch the tissue itself.
    let has_struck = |body: &str| {
        let touched = measures.pairs.values().filter(|pair| pair.force.contact_span.is_some());
        touched.filter(|pair| !pair.is_of_itself()).any(|pair| pair.between.iter().any(|name| name == body))
    };
    let is_missed = |pair: &&PairMeasures| {
        is_finished && pair.force.contact_span.is_none() && !has_struck(&pair.between[1 - pair.reported_on])
    };
    let missed = first_of(measures.strikes().filter(is_missed).map(|pair| pair.name.clone())).map(|pairs| {
        format!("Nothing touched in {pairs}: check the direction of the velocity, the gap and the end time.")
    });
    all.add(Gravity::Remark, missed);
    let touching = measures.strikes().filter(|pair| pair.force.is_in_contact());
    let going_on = first_of(touching.map(|pair| pair.between.join(" and "))).map(|pairs| {
        format!(
            "The impact is not over at the end of the run ({pairs} still touch): its numbers are not final."
        )
    });
    all.add(Gravity::NotFinal, going_on);
}

/// The first three names, and how many more there are; `None` without any.
fn first_of(names: impl Iterator<Item = String>) -> Option<String> {
    const FEW: usize = 3;
    let names: Vec<String> = names.collect();
    let listed = names.iter().take(FEW).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len() {
        0 => None,
        count if count <= FEW => Some(listed),
        count => Some(format!("{listed} and {} more", count - FEW)),
    }
}

/// Warns of contact patches that are not resolved, and of waves reflected from artificial ends of the model.
fn resolution_warnings(all: &mut Warnings, measures: &Measures) {
    let across = |pair: &PairMeasures| pair.force.peak().patch.nodes_across;
    let is_coarse = |pair: &&PairMeasures| {
        pair.force.contact_span.is_some() && !pair.is_of_points && across(pair) < NODES_ACROSS
    };
    let coarse = || measures.pairs.values().filter(is_coarse);
    let fewest = coarse().map(across).min().unwrap_or_default();
    let coarse = first_of(coarse().map(named)).map(|pairs| {
        let nodes = if fewest == 1 { "one node lies".to_owned() } else { format!("{fewest} nodes lie") };
        format!(
            "The mesh is too coarse for the contact patch of {pairs} and its pressure: only {nodes} across it at the peak force (fewer than \
             {NODES_ACROSS})."
        )
    });
    all.add(Gravity::Coarse, coarse);
    let returned = |pair: &PairMeasures| wave_return(measures, pair).filter(|time| *time < measures.time);
    let earliest = measures.pairs.values().filter_map(returned).fold(f64::INFINITY, f64::min);
    let disturbed = measures.pairs.values().filter(|pair| returned(pair).is_some());
    let disturbed = first_of(disturbed.map(named)).map(|pairs| {
        format!(
            "The ends of the model may disturb the result from {} on: a wave from the contact of {pairs} may have returned from them. Make \
             the model longer, or end the run earlier.",
            seconds(earliest)
        )
    });
    all.add(Gravity::Inaccurate, disturbed);
}

/// The pair in words: the contact of a body with itself has the name of that body twice.
fn named(pair: &PairMeasures) -> String {
    if pair.is_of_itself() { format!("{} with itself", pair.between[0]) } else { pair.name.clone() }
}

/// The window over which the force of a pair is averaged, and the mean step [s].
struct Window {
    pair: String,
    length: f64,
    step: f64,
}

impl Window {
    fn of(pair: &PairMeasures) -> Option<Self> {
        Some(Self { pair: named(pair), length: pair.force.window()?, step: pair.force.mean_step() })
    }
}

/// Warns of force windows that are longer than the run, and of those shorter than two steps; each names the pairs, and has the numbers of
/// the worst.
fn window_warnings(windows: &[Window], end: f64) -> impl Iterator<Item = String> {
    let (long, fitting): (Vec<&Window>, Vec<&Window>) = windows.iter().partition(|of| end < of.length);
    let short: Vec<&Window> =
        fitting.into_iter().filter(|of| of.length < FEWEST_STEPS_OF_WINDOW * of.step).collect();
    let names = |windows: &[&Window]| first_of(windows.iter().map(|of| of.pair.clone()));
    let longest = long.iter().map(|of| of.length).fold(0.0, f64::max);
    let without_peak = names(&long).map(|pairs| {
        format!(
            "The run ended after {}, less than the {} over which the force of {pairs} is averaged: it has no peak force.",
            seconds(end),
            seconds(longest)
        )
    });
    let worst = short.iter().min_by(|a, b| (a.length * b.step).total_cmp(&(b.length * a.step)));
    let unconverged = names(&short).zip(worst).map(|(pairs, worst)| {
        format!(
            "The peak force of {pairs} does not converge: it is averaged over {}, less than two steps of {}. \
             Omit `measures.force_window_s` (the window is then 1/10 of the contact, ten steps at least), or take shorter steps.",
            seconds(worst.length),
            seconds(worst.step)
        )
    });
    without_peak.into_iter().chain(unconverged)
}

fn projection_warning(energy: &Energy) -> Option<String> {
    let work = projection_work(energy);
    (work > PROJECTION_WARNING * energy.turnover_j).then(|| {
        format!(
            "Energies are uncertain by {:.1} % of {} (above {:.0} %): the position projection, which removes penetration, did {} J of work.",
            100.0 * work / energy.turnover_j,
            energy.turnover_in_words(),
            100.0 * PROJECTION_WARNING,
            number(work)
        )
    })
}

/// Warns of penetration deeper than contact normally leaves.
fn penetration_warning(deepest: &Depth) -> Option<String> {
    let Depth { depth, fraction, left_to_nodes, between, time } = deepest;
    let limit = PENETRATION_WARNING.max(MARGIN * left_to_nodes);
    (*fraction > limit).then(|| {
        format!(
            "Contact let the bodies overlap: of {between} a point lay {} mm inside the other side at {}, {:.1} % of a face (above {:.0} %). {TOO_DEEP}",
            number(1e3 * depth),
            seconds(*time),
            100.0 * fraction,
            100.0 * limit
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
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::quantity::Quantity;
    use super::*;
    use crate::plan::ByPair;
    use crate::step::{BodyEnergy, PairLedger};

    #[test]
    fn main_numbers_that_are_not_resolved_are_named_in_one_warning() {
        let summary = include_str!("../../../api/examples/summary.response.json");
        let summary: serde_json::Value = serde_json::from_str(summary).unwrap();
        let mut results: Results = serde_json::from_value(summary["results"].clone()).unwrap();
        let said = |results: &mut Results, [force, patch, depth]: [&ErrorEstimate; 3]| {
            let (impact, tissue) = (&mut results.impacts[0], results.tissue.as_mut().unwrap());
            impact.peak_force_n.error = force.clone();
            impact.largest_patch_area_mm2.error = patch.clone();
            tissue.significant_stress[0].depth_mm.as_mut().unwrap().error = depth.clone();
            tissue.energy_given_j.error = force.clone();
            let mut all = Warnings::default();
            doubtful_numbers(&mut all, results);
            all.to_vec()
        };
        let [good, coarse] =
            [true, false].map(|is_resolved| Quantity::with_mesh_error(1.0, 0.1, is_resolved).error);
        assert!(said(&mut results, [&good; 3]).is_empty());
        assert_eq!(
            said(&mut results, [&coarse, &coarse, &good]),
            [
                "The mesh is too coarse for some of the main numbers (peak force, largest contact patch and energy given to the \
              tissue): an order of magnitude, no more."
            ]
        );
        let unknown = ErrorEstimate::NotEstimated;
        let both = said(&mut results, [&good, &unknown, &coarse]);
        assert!(
            both.len() == 2 && both[0].contains("for one of the main numbers, the depth of stress:"),
            "{both:?}"
        );
        assert!(both[1].ends_with("was not estimated: largest contact patch."), "{both:?}");
    }

    #[test]
    fn windows_of_many_pairs_are_one_warning() {
        let of = |pair: &str, length, step| Window { pair: pair.into(), length, step };
        let pairs = [of("a–b", 1e-6, 1e-6), of("a–c", 1e-6, 2e-6), of("a–d", 1e-5, 1e-6)];
        let said: Vec<String> = window_warnings(&pairs, 1e-3).collect();
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(
            said[0].contains("of a–b, a–c does") && said[0].contains("two steps of 2.000 µs"),
            "{said:?}"
        );
        let early: Vec<String> = window_warnings(&pairs, 5e-6).collect();
        assert!(early.len() == 2 && early[0].contains("force of a–d is averaged"), "{early:?}");
    }

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
    fn what_is_lost_is_no_more_than_all_of_what_it_is_a_share_of() {
        let warned = |scale_j: f64, turnover_j: f64| {
            let mut pairs = ByPair::default();
            pairs.of(0, || PairLedger { impact_j: 3.0, ..PairLedger::default() });
            rigid_impact_warning(&Energy { pairs, scale_j, turnover_j, ..Energy::default() }).unwrap()
        };
        assert!(warned(4.0, 4.0).contains("3.000 J were lost so, 75.0 % of the energy of the impact."));
        // Weight has done more work than the bodies had energy at their first impact.
        assert!(warned(1.0, 4.0).contains("75.0 % of all energy that was lost."));
    }
}
