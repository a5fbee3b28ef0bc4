//! The summary in plain words, sentence by sentence.

use super::listed::FEW_NODES;
use super::lower_bounds::GREATEST_DEPTH;
use super::quantity::{ErrorEstimate, Quantity};
use super::results::{Impact, Results, Shown, SignificantStress, Tissue};
use super::written::{interval, seconds, short, shown_in, within};
use crate::step::{Ending, Failure};

/// A few sentences on the numbers of a run that has reached a time [s], for readers without a technical background: the contact of the
/// headline and its first threshold of stress. `torn` holds the sentences on softened and eroded tissue, `worst` the gravest warning.
pub(super) fn plain_words(
    results: &Shown,
    (ending, time): (Option<&Ending>, f64),
    torn: impl Iterator<Item = String>,
    worst: Option<String>,
) -> Vec<String> {
    let results = match results {
        Shown::Results(results) => results,
        Shown::Withheld { reason, remedy, .. } => {
            return vec![format!("No result can be given: {reason}."), (*remedy).to_owned()];
        }
    };
    // Caveat for an incomplete run.
    let mut words = Vec::new();
    let until = |what: &str| {
        format!(
            "{what} {} after the start: the numbers cover the time until then, not the whole impact.",
            seconds(time)
        )
    };
    match ending {
        Some(Ending::Finished) => {}
        None => words.push(until("The run has reached")),
        Some(Ending::Cancelled) => words.push(until("The run was stopped")),
        Some(Ending::Failed { failure }) => {
            words.push(until("The run failed"));
            words.push(why(failure));
        }
    }
    if results.nothing_touched {
        words.insert(0, nothing_touched(results, ending == Some(&Ending::Finished)));
        return words;
    }
    words.extend(contact(results));
    if let Some(tissue) = &results.tissue {
        let of_headline = results.headline.significant_stress;
        let stress = of_headline.and_then(|index| tissue.significant_stress.get(index));
        words.extend(in_tissue(stress, tissue, ending == Some(&Ending::Finished)));
        words.extend(stress.and_then(reaches_end));
        if results.impacts.iter().any(|impact| impact.on_tissue && impact.contact_span_s.is_some()) {
            words.push(energy(tissue));
        }
    }
    words.extend(torn);
    words.extend(worst.filter(|worst| !words.contains(worst)));
    words
}

/// "a, b and c".
pub(super) fn in_a_row(names: &[&str]) -> String {
    match names {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        names => names.concat(),
    }
}

/// Why a run failed, where, and what to do.
fn why(failure: &Failure) -> String {
    let place = failure.place().map_or_else(String::new, |place| format!(" This was in {place}."));
    format!("{}{place} {}", failure.message, failure.remedy)
}

/// First and only sentence on a run in which nothing touched.
fn nothing_touched(results: &Results, is_over: bool) -> String {
    let untouched =
        results.impacts.iter().filter(|impact| impact.is_reported() && impact.contact_span_s.is_none());
    let names = untouched.map(|impact| impact.between.join(" and ")).collect::<Vec<_>>();
    let pairs = if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) };
    if !is_over {
        return format!("Nothing has touched{pairs} so far: there is no impact to evaluate yet.");
    }
    format!(
        "Nothing touched{pairs}: there was no impact to evaluate. Check the direction of the velocity, the gap and \
         the end time."
    )
}

/// "123 N (± 4)", or "0.25 (± 0.01)" of a pure number, whose unit is "-"; a value that does not exceed its error is marked
/// as uncertain.
fn value(quantity: &Quantity, unit: &str) -> String {
    value_or(quantity, unit, "these meshes do not show whether it converges")
}

/// The same; `doubt` says why a value that exceeds its error may not be resolved.
fn value_or(quantity: &Quantity, unit: &str, doubt: &str) -> String {
    let (scale, unit) = shown_in(quantity.value, unit);
    let digits = within(scale * quantity.value, quantity.error.half_width().map(|error| scale * error));
    let bound = if quantity.is_lower_bound && digits != "0" { "at least " } else { "" };
    match &quantity.error {
        ErrorEstimate::NothingTouched => "nothing".into(),
        ErrorEstimate::NotEstimated => format!("{bound}about {digits}{unit} (error not estimated)"),
        ErrorEstimate::Estimated(error) if error.resolved => {
            format!("{bound}{digits}{unit} ({})", interval(quantity, scale).unwrap_or_default())
        }
        ErrorEstimate::Estimated(error) => {
            let is_small = error.total < quantity.value.abs();
            let doubt = if is_small { doubt } else { "its numerical error exceeds the value" };
            format!("{bound}about {digits}{unit} ({doubt})")
        }
    }
}

/// "up to " before a largest value over time; one that is a lower bound has no end.
fn up_to(quantity: &Quantity) -> &'static str {
    if quantity.is_lower_bound { "" } else { "up to " }
}

/// Sentence on the contact of the headline.
fn contact(results: &Results) -> Option<String> {
    let impact = results.headline_impact().filter(|impact| impact.contact_span_s.is_some())?;
    let area = if impact.touches_in_points {
        String::new()
    } else {
        let area = &impact.largest_patch_area_mm2;
        format!(", and on {}{}", up_to(area), value_or(area, "mm²", FEW_NODES))
    };
    let is_other = |other: &&Impact| other.contact_span_s.is_some() && !std::ptr::eq(*other, impact);
    let others = match results.impacts.iter().filter(is_other).count() {
        0 => String::new(),
        1 => " There was one other contact.".into(),
        count => format!(" There were {count} other contacts."),
    };
    let ([a, b], force) = (&impact.between, &impact.peak_force_n);
    Some(format!(
        "{a} and {b} pressed against each other with {}{}, {} after the start{area}.{others}",
        up_to(force),
        value(force, "N"),
        seconds(impact.peak_force_time_s.value),
    ))
}

/// Sentence on the depth and the volume above a threshold, and the layers that they are in.
fn in_tissue(stress: Option<&SignificantStress>, tissue: &Tissue, has_finished: bool) -> Option<String> {
    let until = seconds(tissue.looked_at_until_s);
    let Some(stress) = stress else {
        return (!has_finished).then(|| {
            format!("Stresses were not evaluated after {until}: nothing is known about them later.")
        });
    };
    let threshold = short(1e-3 * stress.threshold_pa);
    let so_far =
        if has_finished { String::new() } else { format!(" up to {until}, when it was last evaluated") };
    let parts: Vec<&str> = stress.layers.iter().map(|layer| &layer.part[..]).collect();
    if parts.is_empty() {
        return Some(format!("No tissue saw more than {threshold} kPa (von Mises stress){so_far}."));
    }
    let parts = in_a_row(&parts);
    let depth = stress.depth_mm.as_ref().map(|depth| format!(", {} deep", value(depth, "mm")));
    Some(format!(
        "More than {threshold} kPa (von Mises stress) was reached in {parts}{}, in a volume of {}{so_far}.",
        depth.unwrap_or_default(),
        value(&stress.volume_mm3, "mm³")
    ))
}

/// Sentence on a region above the threshold that continues beyond the model, or is as deep as the tissue.
fn reaches_end(stress: &SignificantStress) -> Option<String> {
    if !stress.reaches.is_empty() {
        return Some(format!("This region reaches {}: the model ends there.", stress.reaches.join(" and ")));
    }
    stress.reaches_greatest_depth().then(|| {
        format!("This region reaches {GREATEST_DEPTH}: below the nearest surface there is no deeper tissue.")
    })
}

fn energy(tissue: &Tissue) -> String {
    let of_loss = tissue
        .projectile_loss_j
        .as_ref()
        .map_or_else(String::new, |loss| format!(", of {} that the projectile lost", value(loss, "J")));
    let frame = if tissue.has_moving_frame() { ", in the frame of the tissue at first contact" } else { "" };
    let given = value(&tissue.energy_given_j, "J");
    let still = if tissue.energy_given_j.is_lower_bound { "; it was still growing" } else { "" };
    format!("When the run ended the tissue had been given {given}{of_loss}{frame}{still}.")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tissue(looked_at_until_s: f64, stresses: &[f64]) -> Tissue {
        use super::super::{GateResult, Located, Peaks, Split};
        let zero = || Quantity::new(0.0, GateResult::Passed);
        let split = || Split {
            strain_j: zero(),
            kinetic_j: zero(),
            recoverable_j: zero(),
            dissipated_j: zero(),
            not_from_contact_j: zero(),
        };
        Tissue {
            energy_given_j: zero(),
            absorbed_energy_j: zero(),
            absorbed_energy_by_work_j: zero(),
            absorbed_split: split(),
            peak_absorbed_energy_j: zero(),
            peak_absorbed_energy_time_s: zero(),
            peak_absorbed_split: split(),
            frame_velocity_m_per_s: [0.0; 3],
            contact_ended: true,
            projectile_loss_j: None,
            looked_at_until_s,
            significant_stress: stresses
                .iter()
                .map(|&threshold_pa| SignificantStress {
                    threshold_pa,
                    depth_mm: None,
                    depth_resolution_mm: None,
                    depth_time_s: 0.0,
                    volume_mm3: zero(),
                    volume_at_end_mm3: zero(),
                    point_spacing_mm: 0.0,
                    numerical_volume_mm3: 0.0,
                    reaches: Vec::new(),
                    depth_reaches: Vec::new(),
                    layers: Vec::new(),
                })
                .collect(),
            dose_volumes: Vec::new(),
            exceeded_in_volume: None,
            percentiles: Vec::new(),
            peaks: Peaks::default(),
            deflection_mm: Located { quantity: zero(), position_m: [0.0; 3], time_s: 0.0 },
            viscous_response_m2_per_s: zero(),
        }
    }

    #[test]
    fn a_few_sentences_have_the_main_numbers_and_the_worst_warning() {
        let summary = include_str!("../../../api/examples/summary.response.json");
        let summary: serde_json::Value = serde_json::from_str(summary).unwrap();
        let results: Results = serde_json::from_value(summary["results"].clone()).unwrap();
        assert!(results.tissue.as_ref().is_some_and(|tissue| tissue.significant_stress.len() > 1));
        let ending = (Some(&Ending::Finished), 1e-4);
        let worst = "The impact is not over.".to_owned();
        let words = plain_words(&Shown::Results(results), ending, std::iter::empty(), Some(worst.clone()));
        let [force, stress, energy, last] = &words[..] else { panic!("{words:?}") };
        assert!(
            force.contains("ball and block") && force.contains(" 1000 N (its numerical error"),
            "{force}"
        );
        assert!(stress.contains("10 kPa") && stress.contains(" deep, in a volume of "), "{stress}");
        assert!(energy.contains("had been given ") && energy.contains(" J") && *last == worst, "{words:?}");
    }

    #[test]
    fn a_doubt_is_the_right_one() {
        let said = |total: f64| value(&Quantity::with_mesh_error(0.2444, total, false), "-");
        assert_eq!(said(0.02), "about 0.244 (these meshes do not show whether it converges)");
        assert_eq!(said(0.3), "about 0.24 (its numerical error exceeds the value)");
        let of_patch = value_or(&Quantity::with_mesh_error(1e6, 100.0, false), "mm²", FEW_NODES);
        assert_eq!(of_patch, "about 1000000 mm² (fewer than five nodes across it)");
        let certain = Quantity::with_mesh_error(0.2444, 0.02, true);
        let bound = Quantity { is_lower_bound: true, ..certain.clone() };
        assert_eq!(value(&bound, "mm"), "at least 0.244 mm (± 0.020)");
        let large = Quantity::with_mesh_error(31_234.0, 1234.0, true);
        assert_eq!(value(&large, "mm³"), "31.2 cm³ (± 1.2)");
        let cut = Quantity { possible: [Some(0.0), Some(0.25)], ..certain };
        let bound = Quantity { is_lower_bound: true, ..cut.clone() };
        assert_eq!(value(&bound, "mm"), "at least 0.244 mm (± 0.020)");
        assert_eq!(value(&cut, "mm"), "0.244 mm (between 0.224 and 0.250)");
    }

    #[test]
    fn an_energy_given_that_still_grows_is_at_least_what_it_is() {
        let given = Quantity::with_mesh_error(3.9, 0.2, true);
        let of = |is_lower_bound: bool| {
            energy(&Tissue {
                energy_given_j: Quantity { is_lower_bound, ..given.clone() },
                ..tissue(1e-3, &[])
            })
        };
        assert_eq!(of(false), "When the run ended the tissue had been given 3.90 J (± 0.20).");
        assert_eq!(
            of(true),
            "When the run ended the tissue had been given at least 3.90 J (± 0.20); it was still growing."
        );
    }

    #[test]
    fn a_failure_is_said_with_its_cause_its_place_and_its_remedy() {
        use crate::step::{ElementPlace, FailureCause};
        let mut failure = Failure::of_no_run(FailureCause::StepTooLong, "It turned too far.");
        let remedy = FailureCause::StepTooLong.remedy();
        assert_eq!(why(&failure), format!("It turned too far. {remedy}"));
        let (body, part) = ("gel".into(), "block".into());
        failure.element = Some(ElementPlace { body, part, element: 7, position_m: None });
        let said = why(&failure);
        assert_eq!(
            said,
            format!("It turned too far. This was in element 7 of part block of body gel. {remedy}")
        );
    }

    #[test]
    fn a_region_as_deep_as_the_tissue_is_said_to_be() {
        use super::super::GateResult;
        let mut stress = tissue(1e-4, &[1e4]).significant_stress.remove(0);
        assert_eq!(reaches_end(&stress), None);
        stress.depth_mm = Some(Quantity::new(20.0, GateResult::Passed).within_zero_and(Some(20.0)));
        assert!(reaches_end(&stress).is_some_and(|said| said.contains("there is no deeper tissue")));
        stress.reaches = vec!["the held nodes “bone”".to_owned()];
        assert!(
            reaches_end(&stress)
                .is_some_and(|said| said.contains("reaches the held nodes “bone”: the model"))
        );
    }

    #[test]
    fn nothing_is_denied_that_was_not_looked_at() {
        let said = |until: f64, stresses: &[f64], has_finished: bool| {
            let tissue = tissue(until, stresses);
            in_tissue(tissue.significant_stress.first(), &tissue, has_finished).unwrap_or_default()
        };
        assert_eq!(said(1e-4, &[1e4], true), "No tissue saw more than 10 kPa (von Mises stress).");
        assert!(said(0.0, &[], false).contains("nothing is known"));
        assert!(said(5e-5, &[1e4], false).contains("up to 50.00 µs, when it was last evaluated"));
    }
}
