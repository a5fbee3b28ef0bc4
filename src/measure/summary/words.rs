//! The summary in plain words, sentence by sentence.

use super::table::{number, seconds};
use super::{ErrorEstimate, Quantity, Results, Shown};

/// What the numbers say, for people who read no tables.
pub(super) fn plain_words(results: &Shown) -> Vec<String> {
    let results = match results {
        Shown::Results(results) => results,
        Shown::Withheld { reason, .. } => return vec![format!("No result can be given: {reason}.")],
    };
    let mut words = Vec::new();
    contact(results, &mut words);
    stress(results, &mut words);
    energy(results, &mut words);
    words
}

/// "123 N (± 4)"; a number that is not larger than its error is said to be uncertain.
fn value(quantity: &Quantity, unit: &str) -> String {
    match &quantity.error {
        ErrorEstimate::NotEstimated | ErrorEstimate::NoOrder => {
            format!("{} {unit} (error not estimated)", number(quantity.value))
        }
        ErrorEstimate::Estimated(error) if error.resolved => {
            format!("{} {unit} (± {})", number(quantity.value), number(error.total))
        }
        ErrorEstimate::Estimated(_) => {
            format!("about {} {unit} (its numerical error is larger than itself)", number(quantity.value))
        }
    }
}

fn contact(results: &Results, words: &mut Vec<String>) {
    for impact in results.impacts.iter().filter(|impact| impact.on_tissue) {
        let [a, b] = &impact.between;
        if impact.contact_span_s.is_none() {
            words.push(format!("{a} and {b} never touched."));
            continue;
        }
        words.push(format!(
            "{a} and {b} pressed against each other with up to {}, {} after the start, on an area of {}.",
            value(&impact.peak_force_n, "N"),
            seconds(impact.peak_force_time_s.value),
            value(&impact.patch_area_mm2, "mm²")
        ));
    }
}

fn stress(results: &Results, words: &mut Vec<String>) {
    let Some(tissue) = &results.tissue else { return };
    for stress in &tissue.significant_stress {
        let threshold = number(1e-3 * stress.threshold_pa);
        if stress.layers.is_empty() {
            words.push(format!("No tissue saw more than {threshold} kPa (von Mises stress)."));
        }
        words.extend(stress.layers.iter().map(|layer| {
            let volume = number(layer.volume_mm3);
            match layer.depth_mm {
                Some([from, to]) => format!(
                    "The {} between {} and {} mm under the skin saw more than {threshold} kPa (von Mises stress), {volume} mm³ of it.",
                    layer.part,
                    number(from),
                    number(to)
                ),
                None => format!("{volume} mm³ of the {} saw more than {threshold} kPa (von Mises stress).", layer.part),
            }
        }));
    }
}

fn energy(results: &Results, words: &mut Vec<String>) {
    let Some(tissue) = &results.tissue else { return };
    let absorbed = value(&tissue.absorbed_energy_j, "J");
    let of_loss = tissue
        .projectile_loss_j
        .as_ref()
        .map_or_else(String::new, |loss| format!(", of {} that the projectile lost", value(loss, "J")));
    let end =
        if tissue.contact_ended { "" } else { " Contact had not ended: these are not the final numbers." };
    words.push(format!("When the run ended the tissue had taken up {absorbed}{of_loss}.{end}"));
}
