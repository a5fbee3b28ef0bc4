//! The summary in plain words, sentence by sentence.

use super::laws::{LawRange, ranges_in_words};
use super::quantity::{ErrorEstimate, Quantity};
use super::results::{ExceededInVolume, Impact, Results, Shown, SignificantStress, StressedLayer, Tissue};
use super::written::{number, rounded, seconds};
use crate::step::{Ending, Failure};

/// Sentences on the numbers of a run that has reached a time [s], for readers without a technical background.
/// `torn` holds the sentences on softened and eroded tissue.
pub(super) fn plain_words(
    results: &Shown,
    (ending, time): (Option<&Ending>, f64),
    laws: &[LawRange],
    torn: impl Iterator<Item = String>,
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
    contact(results, &mut words);
    if let Some(tissue) = &results.tissue {
        stress(tissue, ending == Some(&Ending::Finished), &mut words);
        words.extend(tissue.exceeded_in_volume.as_ref().map(strain));
        if results.impacts.iter().any(|impact| impact.on_tissue && impact.contact_span_s.is_some()) {
            energy(tissue, &mut words);
        }
    }
    words.extend(torn);
    words.extend(ranges_in_words(laws));
    words
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

/// "123 N (± 4)", or "0.25 (± 0.01)" of a pure number, whose unit is empty; a value that does not exceed its error is marked
/// as uncertain.
fn value(quantity: &Quantity, unit: &str) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    match &quantity.error {
        ErrorEstimate::NothingTouched => "nothing".into(),
        ErrorEstimate::NotEstimated => {
            format!("about {}{unit} (error not estimated)", rounded(quantity.value))
        }
        ErrorEstimate::Estimated(error) if error.resolved => {
            format!("{}{unit} (± {})", number(quantity.value), rounded(error.total))
        }
        ErrorEstimate::Estimated(error) => {
            let is_small = error.total < quantity.value.abs();
            let doubt = if is_small {
                "these meshes do not show whether it converges"
            } else {
                "its numerical error exceeds the value"
            };
            format!("about {}{unit} ({doubt})", rounded(quantity.value))
        }
    }
}

fn contact(results: &Results, words: &mut Vec<String>) {
    let is_counted = |impact: &&Impact| {
        if results.tissue.is_some() { impact.on_tissue } else { !impact.is_of_itself() }
    };
    for impact in results.impacts.iter().filter(is_counted) {
        let [a, b] = &impact.between;
        if impact.contact_span_s.is_none() {
            words.push(format!("Nothing touched between {a} and {b}."));
            continue;
        }
        let area = if impact.touches_in_points {
            String::new()
        } else {
            format!(", and on up to {}", value(&impact.largest_patch_area_mm2, "mm²"))
        };
        words.push(format!(
            "{a} and {b} pressed against each other with up to {}, {} after the start{area}.",
            value(&impact.peak_force_n, "N"),
            seconds(impact.peak_force_time_s.value),
        ));
    }
}

fn stress(tissue: &Tissue, has_finished: bool, words: &mut Vec<String>) {
    let until = seconds(tissue.looked_at_until_s);
    if !has_finished && tissue.significant_stress.is_empty() {
        words.push(format!("Stresses were not evaluated after {until}: nothing is known about them later."));
    }
    let so_far =
        if has_finished { String::new() } else { format!(" up to {until}, when it was last evaluated") };
    for stress in &tissue.significant_stress {
        let threshold = number(1e-3 * stress.threshold_pa);
        if stress.layers.is_empty() {
            words.push(format!("No tissue saw more than {threshold} kPa (von Mises stress){so_far}."));
            continue;
        }
        words.extend(stress.layers.iter().map(|layer| in_layer(layer, stress, &threshold)));
        words.push(reach(stress, &threshold));
        words.extend(reaches_end(stress, &threshold));
    }
}

/// Sentence on the strain exceeded in a volume.
fn strain(in_volume: &ExceededInVolume) -> String {
    let volume = number(in_volume.volume_mm3);
    format!(
        "{volume} mm³ of the tissue were stretched by a principal strain (Green–Lagrange) of {} or more.",
        value(&in_volume.principal_strain.quantity, "")
    )
}

/// Sentence on the region of one part above the threshold.
fn in_layer(layer: &StressedLayer, stress: &SignificantStress, threshold: &str) -> String {
    let volume = layer.volume_mm3;
    let volume = if stress.volume_mm3.error.is_resolved() {
        number(volume)
    } else {
        format!("about {}", rounded(volume))
    };
    let part = &layer.part;
    match layer.depth_mm {
        Some([from, to]) => format!(
            "The {part} between {from:.1} and {to:.1} mm below the surface saw more than {threshold} kPa (von Mises stress), {volume} mm³ of \
             it."
        ),
        None => format!("{volume} mm³ of the {part} saw more than {threshold} kPa (von Mises stress)."),
    }
}

/// Sentence on a region above the threshold that continues beyond the model.
pub(super) fn reaches_end(stress: &SignificantStress, threshold: &str) -> Option<String> {
    (!stress.reaches.is_empty()).then(|| {
        format!(
            "The stress of {threshold} kPa reaches {}: the model ends there, so its depth and volume are lower bounds.",
            stress.reaches.join(" and ")
        )
    })
}

/// Sentence on the whole region above the threshold, with its uncertainty.
fn reach(stress: &SignificantStress, threshold: &str) -> String {
    let volume = value(&stress.volume_mm3, "mm³");
    match &stress.depth_mm {
        Some(depth) => format!(
            "Overall, the stress of {threshold} kPa reaches {} deep, in a volume of {volume}.",
            value(depth, "mm")
        ),
        None => format!("Overall, the stress of {threshold} kPa is exceeded in a volume of {volume}."),
    }
}

fn energy(tissue: &Tissue, words: &mut Vec<String>) {
    let absorbed = value(&tissue.absorbed_energy_j, "J");
    let of_loss = tissue
        .projectile_loss_j
        .as_ref()
        .map_or_else(String::new, |loss| format!(", of {} that the projectile lost", value(loss, "J")));
    let end =
        if tissue.contact_ended { "" } else { " Contact had not ended: these are not the final numbers." };
    let frame = if tissue.has_moving_frame() { ", in the frame of the tissue at first contact" } else { "" };
    words.push(format!("When the run ended the tissue had taken up {absorbed}{of_loss}{frame}.{end}"));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tissue(looked_at_until_s: f64, stresses: &[f64]) -> Tissue {
        use super::super::{GateResult, Located, Peaks, Split};
        let zero = || Quantity { value: 0.0, error: ErrorEstimate::NotEstimated, gate: GateResult::Passed };
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
    fn a_doubt_is_the_right_one() {
        let said = |total: f64| value(&Quantity::with_mesh_error(0.24, total, false), "");
        assert_eq!(said(0.02), "about 0.24 (these meshes do not show whether it converges)");
        assert_eq!(said(0.3), "about 0.24 (its numerical error exceeds the value)");
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
    fn nothing_is_denied_that_was_not_looked_at() {
        let said = |until: f64, stresses: &[f64], has_finished: bool| {
            let mut words = Vec::new();
            stress(&tissue(until, stresses), has_finished, &mut words);
            words.join(" ")
        };
        assert_eq!(said(1e-4, &[1e4], true), "No tissue saw more than 10.00 kPa (von Mises stress).");
        assert!(said(0.0, &[], false).contains("nothing is known"));
        assert!(said(5e-5, &[1e4], false).contains("up to 50.00 µs, when it was last evaluated"));
    }
}
