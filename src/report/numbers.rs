//! The four numbers of a report, each with its uncertainty in words.

use super::text::{capitalised, escaped};
use crate::measure::QuantityOfInterest;
use crate::measure::summary::{Group, Interval, Quantity, interval, rounded, within};
use std::fmt::Write as _;

/// Cards of the four main results of a listing, which is empty if they are withheld.
pub(super) fn cards(out: &mut String, listing: &[Group], is_withheld: bool) {
    let none = if is_withheld { "Withheld." } else { "This run has no such number." };
    out.push_str("<section class=\"cards\">\n");
    for of in QuantityOfInterest::HEADLINE {
        let unit = of.unit();
        let row = listing.iter().flat_map(|group| &group.rows).find(|row| row.of == Some(of));
        let quantity = row.and_then(|row| Some((row, row.quantity()?.0)));
        let title = escaped(&row.map_or_else(|| capitalised(of.title()), |row| capitalised(&row.title)));
        let is_plain = quantity.is_some_and(|(_, quantity)| quantity.error.is_resolved());
        let class = if is_plain { "" } else { " doubtful" };
        let value = quantity.map_or_else(|| "–".into(), |(row, _)| escaped(&row.value()));
        let words =
            quantity.map_or_else(|| none.into(), |(row, quantity)| in_words(quantity, unit, row.doubt()));
        let _ = writeln!(
            out,
            "<div class=\"card{class}\"><h2>{title}</h2><p class=\"value\">{value}</p><p class=\"error\">{words}</p></div>"
        );
    }
    out.push_str("</section>\n");
}

/// The uncertainty of a number in a sentence; `doubt` says why a number that exceeds its error is not resolved.
fn in_words(quantity: &Quantity, unit: &str, doubt: Option<&str>) -> String {
    let value = quantity.value;
    let Some(error) = quantity.error.half_width() else {
        return "Its numerical error was not estimated: an indication, not a result.".into();
    };
    let end = |value| within(value, Some(error));
    let words = interval(quantity, 1.0).unwrap_or_default();
    if !quantity.error.is_resolved() {
        let doubt = doubt.map_or_else(String::new, |doubt| format!(" ({doubt})"));
        return format!(
            "{} {unit}: the mesh does not resolve it{doubt}, no more than an order of magnitude.",
            capitalised(&words)
        );
    }
    match quantity.interval() {
        Some(Interval::From(low)) => format!(
            "{words} {unit}: at least {} {unit}, with a numerical error of {} %.",
            end(low),
            rounded(100.0 * error / value.abs())
        ),
        Some(Interval::Around(_)) => {
            let (low, high, fraction) = (end(value - error), end(value + error), 100.0 * error / value.abs());
            format!(
                "{words} {unit}: between {low} and {high} {unit}, a numerical error of {} %.",
                rounded(fraction)
            )
        }
        _ => format!("{} {unit}: the numerical error, up to what is possible.", capitalised(&words)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{example, quantity_of};
    use super::*;
    use crate::measure::summary::listing;
    use serde_json::{Value, json};

    fn page_of(force: &Value, patch: &Value) -> String {
        let mut run = example();
        let impact = &mut run.summary["results"]["impacts"][0];
        (impact["peak_force_n"], impact["largest_patch_area_mm2"]) = (force.clone(), patch.clone());
        run.summary["results"]["headline"] = json!({"impact": 0});
        run.take_numbers().unwrap();
        let mut page = String::new();
        cards(&mut page, &listing(run.results().unwrap()), false);
        page
    }

    #[test]
    fn each_number_has_its_uncertainty_in_words() {
        let page = page_of(&quantity_of(2730.0, 5300.0, false), &quantity_of(482.0, 12.0, true));
        assert!(page.contains(">(2700) N<") && page.contains("order of magnitude"), "{page}");
        assert!(page.contains(">482 mm²<") && page.contains("between 470 and 494 mm²"), "{page}");
        assert!(page.contains("This run has no such number"), "{page}");
        // A patch is not negative.
        let mut patch = quantity_of(482.0, 500.0, false);
        patch["possible"] = json!([0.0, null]);
        let page_of_patch = page_of(&quantity_of(2730.0, 5300.0, false), &patch);
        assert!(page_of_patch.contains("Up to 980 mm²: the mesh does not resolve it"), "{page_of_patch}");
        let few = page_of(&quantity_of(2730.0, 5300.0, false), &quantity_of(1e6, 100.0, false));
        assert!(
            few.contains("± 100 mm²: the mesh does not resolve it (fewer than five nodes across it)"),
            "{few}"
        );
        // A lower bound has no upper end, whatever is possible.
        let mut bound = quantity_of(482.0, 12.0, true);
        (bound["possible"], bound["is_lower_bound"]) = (json!([0.0, 490.0]), true.into());
        let page_of_bound = page_of(&quantity_of(2730.0, 5300.0, false), &bound);
        assert!(
            page_of_bound.contains(">≥ 482 mm²<") && !page_of_bound.contains("between 470"),
            "{page_of_bound}"
        );
        assert!(
            page_of_bound.contains("± 12 mm²: at least 470 mm², with a numerical error of 2.5 %."),
            "{page_of_bound}"
        );
        // Brackets once had others around them from the style sheet.
        assert!(!page.contains("((") && !include_str!("report.css").contains("content:"), "{page}");
    }

    #[test]
    fn withheld_numbers_are_not_said_to_be_missing() {
        let mut page = String::new();
        cards(&mut page, &[], true);
        assert_eq!(page.matches("Withheld.").count(), QuantityOfInterest::HEADLINE.len(), "{page}");
        assert!(!page.contains("no such number"), "{page}");
    }

    #[test]
    fn a_number_without_an_error_is_no_plain_one() {
        let unknown = json!({"value": 2730.0, "error": "not estimated", "gate": "passed"});
        let page = page_of(&unknown, &unknown);
        assert!(page.contains("card doubtful") && page.contains("not estimated"), "{page}");
        assert!(!page.contains(">2730"), "{page}");
    }
}
