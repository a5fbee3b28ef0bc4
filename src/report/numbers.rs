//! The four numbers of a report, each with its uncertainty in words.

use super::{Shown, is_miss, recorded, title};
use crate::measure::QuantityOfInterest;
use crate::measure::summary::{number, rounded};
use serde_json::Value;
use std::fmt::Write as _;

/// Cards of the four main results.
pub(super) fn cards(out: &mut String, summary: &Value) {
    if is_miss(summary) {
        return;
    }
    let results = &summary["results"];
    out.push_str("<section class=\"cards\">\n");
    for quantity in QuantityOfInterest::HEADLINE {
        let (shown, unit) = (recorded(results, quantity).and_then(Shown::of), quantity.unit());
        let title = title(results, quantity).replace('&', "&amp;").replace('<', "&lt;");
        let (class, value) = match shown {
            Some(shown) if shown.is_resolved => ("", number(shown.value)),
            Some(shown) => (" doubtful", format!("≈ {}", rounded(shown.value))),
            None => (" doubtful", "–".into()),
        };
        let words =
            shown.map_or_else(|| "This run has no such number.".into(), |shown| in_words(shown, unit));
        let _ = writeln!(
            out,
            "<div class=\"card{class}\"><h2>{title}</h2><p class=\"value\">{value} <span>{unit}</span></p><p class=\"error\">{words}</p></div>"
        );
    }
    out.push_str("</section>\n");
}

/// The uncertainty of a number in a sentence.
fn in_words(shown: Shown, unit: &str) -> String {
    let Shown { value, error, is_resolved } = shown;
    let Some(error) = error else {
        return "Its numerical error was not estimated: an indication, not a result.".into();
    };
    if is_resolved {
        let fraction = 100.0 * error / value.abs();
        return format!(
            "± {} {unit}: between {} and {} {unit}, a numerical error of {} %.",
            rounded(error),
            number(value - error),
            number(value + error),
            rounded(fraction)
        );
    }
    format!(
        "± {} {unit}: the mesh does not resolve it. No more than an order of magnitude, up to {} {unit}.",
        rounded(error),
        rounded(value + error)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn page_of(force: &Value, patch: &Value) -> String {
        let impact = json!({"peak_force_n": force, "largest_patch_area_mm2": patch});
        let mut page = String::new();
        cards(&mut page, &json!({"results": {"impacts": [impact], "headline": {"impact": 0}}}));
        page
    }

    #[test]
    fn each_number_has_its_uncertainty_in_words() {
        let quantity = |value: f64, error: f64, resolved: bool| json!({"value": value, "error": {"total": error, "resolved": resolved}});
        let page = page_of(&quantity(2730.0, 5300.0, false), &quantity(482.0, 12.0, true));
        assert!(page.contains("≈ 2700 <span>N</span>") && page.contains("order of magnitude"), "{page}");
        assert!(
            page.contains(">482.0 <span>mm²</span>") && page.contains("between 470.0 and 494.0 mm²"),
            "{page}"
        );
        assert!(page.contains("This run has no such number"), "{page}");
        // Brackets once had others around them from the style sheet.
        assert!(!page.contains('(') && !include_str!("report.css").contains("content:"), "{page}");
    }

    #[test]
    fn a_number_without_an_error_is_no_plain_one_and_a_miss_has_none() {
        let unknown = json!({"value": 2730.0, "error": "not estimated"});
        let page = page_of(&unknown, &unknown);
        assert!(page.contains("card doubtful") && page.contains("not estimated"), "{page}");
        assert!(!page.contains(">2730"), "{page}");
        let mut miss = String::new();
        cards(&mut miss, &json!({"results": {"nothing_touched": true, "impacts": [], "headline": {}}}));
        assert!(miss.is_empty(), "{miss}");
    }
}
