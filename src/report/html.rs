//! The report as one self-contained, printable HTML page.

use super::RecordedRun;
use super::numbers::cards;
use super::omissions::omissions;
use super::pictures::pictures;
use super::section_picture::section_picture;
use super::simulated::simulated;
use super::text::{capitalised, escaped, with_powers};
use crate::measure::summary::{Group, InjuryMeasure, Row, listing, numerics_group, rounded, seconds, short};
use serde_json::Value;
use std::fmt::Write as _;

const STYLE: &str = include_str!("report.css");

/// Who had a run computed, and when, where that is known: a recording does not say.
#[derive(Clone, Copy, Debug, Default)]
pub struct Origin<'a> {
    /// Who submitted it.
    pub submitted_by: Option<&'a str>,
    /// When it was submitted, RFC 3339.
    pub submitted_at: Option<&'a str>,
    /// When its computation ended, RFC 3339.
    pub computed_at: Option<&'a str>,
}

/// The HTML page of a run.
///
/// # Errors
/// The message of the drawing library.
pub fn page(run: &RecordedRun, origin: &Origin<'_>) -> Result<String, String> {
    let summary = &run.summary;
    let title = escaped(summary["scene"].as_str().unwrap_or("a scene"));
    let listing = run.results().map(listing).unwrap_or_default();
    let mut body = String::new();
    header(&mut body, run);
    provenance(&mut body, run, origin);
    if !run.is_miss() {
        section(&mut body, run);
        cards(&mut body, &listing, run.withheld().is_some());
    }
    // The gravest warning is among the plain words; here it stands first in the list of all.
    let (mut words, warnings) = (strings(&summary["plain_words"]), strings(&summary["warnings"]));
    words.retain(|sentence| !warnings.contains(sentence));
    list(&mut body, "In plain words", &words);
    list(&mut body, "To read before the numbers are used", &warnings);
    over_time(&mut body, run)?;
    let bodies: Vec<Vec<String>> = simulated(run).into_iter().map(Vec::from).collect();
    body += "<div class=\"simulated\">";
    table(
        &mut body,
        "What was simulated",
        &["body and part", "what it is", "source of the material"],
        &bodies,
    );
    body += "</div>";
    list(&mut body, "What the model omits", &omissions(run));
    criteria_table(&mut body, &run.criteria);
    listing.iter().filter(|_| !run.is_miss()).for_each(|group| group_table(&mut body, group));
    let of_computation = run.numerics.as_ref().map(|numerics| numerics_group(numerics, &run.relaxation));
    if let Some(group) = of_computation {
        group_table(&mut body, &group);
    }
    quality_table(&mut body, run);
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title} – report</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n"
    ))
}

/// Writing to a String cannot fail.
fn push(out: &mut String, text: std::fmt::Arguments) {
    let _ = out.write_fmt(text);
    out.push('\n');
}

/// The picture without its XML declaration, marked as an image that shows something.
fn inline(svg: &str, what: &str) -> String {
    let from = svg.find("<svg").unwrap_or_default();
    svg[from..].replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{what}\" "), 1)
}

fn header(out: &mut String, run: &RecordedRun) {
    let summary = &run.summary;
    let text = |value: &Value| escaped(value.as_str().unwrap_or_default());
    let ending = text(&summary["ending"]);
    push(out, format_args!("<header><h1>{}</h1>", text(&summary["scene"])));
    if let Some(description) = run.scene["description"].as_str().filter(|d| !d.is_empty()) {
        push(out, format_args!("<p class=\"description\">{}</p>", escaped(description)));
    }
    push(
        out,
        format_args!(
            "<p class=\"state {ending}\">{ending} at {} of {}, {} steps</p>",
            seconds(summary["time_s"].as_f64().unwrap_or_default()),
            seconds(summary["end_time_s"].as_f64().unwrap_or_default()),
            summary["steps"]
        ),
    );
    if let Some(failure) = &run.failure {
        let place = failure.place().map_or_else(String::new, |place| format!(" Where: {place}."));
        let text = format!("The run failed: {}{place} What to do: {}", failure.message, failure.remedy);
        push(out, format_args!("<p class=\"withheld\">{}</p>", escaped(&text)));
    }
    push(out, format_args!("<p class=\"notice\">{}</p></header>", text(&summary["notice"])));
    if run.is_miss() {
        out.push_str("<p class=\"withheld\">Nothing touched: there was no impact to evaluate.</p>\n");
    }
    if let Some(reason) = run.withheld() {
        push(out, format_args!("<p class=\"withheld\">The results are withheld: {}.</p>", escaped(reason)));
    }
}

/// The charts. What follows them are tables, which may go on at the next page.
fn over_time(out: &mut String, run: &RecordedRun) -> Result<(), String> {
    out.push_str("<section><h2>Over time</h2><div class=\"pictures\">\n");
    for picture in pictures(run)? {
        let (svg, title) = (inline(&picture.svg, picture.title), picture.title);
        push(out, format_args!("<figure>{svg}<figcaption>{title}</figcaption></figure>"));
    }
    out.push_str("</div></section>\n");
    Ok(())
}

/// The section through the impact at the worst instant.
fn section(out: &mut String, run: &RecordedRun) {
    let tissue = run.results().and_then(|results| results.tissue.as_ref());
    let stresses = tissue.iter().flat_map(|tissue| &tissue.significant_stress);
    let thresholds: Vec<f64> = stresses.map(|stress| stress.threshold_pa).collect();
    let picture = run
        .instant
        .as_ref()
        .and_then(|instant| section_picture(instant, run.worst().what, &run.scene, &thresholds));
    // The table omits the peak where points are beyond the limit of their law; their colours are no results either.
    let is_omitted = tissue.is_some_and(|tissue| tissue.peaks.peak_von_mises_pa.is_none());
    let remark = if is_omitted { "; the largest stress at a point is no result of this run" } else { "" };
    if let Some((svg, caption)) = picture {
        push(
            out,
            format_args!(
                "<figure class=\"section\">{}<figcaption>{caption}{remark}</figcaption></figure>",
                inline(&svg, "Section through the impact")
            ),
        );
    }
}

fn strings(items: &Value) -> Vec<String> {
    items.as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
}

fn list(out: &mut String, title: &str, items: &[String]) {
    if items.is_empty() {
        return;
    }
    push(out, format_args!("<section><h2>{title}</h2><ul>"));
    for item in items {
        push(out, format_args!("<li>{}</li>", escaped(item)));
    }
    out.push_str("</ul></section>\n");
}

/// A table with headings and rows of cells.
fn table(out: &mut String, title: &str, head: &[&str], rows: &[Vec<String>]) {
    if rows.is_empty() {
        return;
    }
    // A table wider than the page scrolls by itself.
    push(out, format_args!("<section><h2>{title}</h2><div class=\"table\"><table><thead><tr>"));
    for name in head {
        push(out, format_args!("<th>{name}</th>"));
    }
    out.push_str("</tr></thead><tbody>\n");
    for row in rows {
        push(out, format_args!("<tr><td>{}</td></tr>", row.join("</td><td>")));
    }
    out.push_str("</tbody></table></div></section>\n");
}

/// The numbers of a contact or of the tissue.
fn group_table(out: &mut String, group: &Group) {
    let title = escaped(&group.title);
    if group.nothing_touched {
        push(out, format_args!("<section><h2>{title}</h2><p>Nothing touched.</p></section>"));
        return;
    }
    let row = |row: &Row| {
        let title = escaped(&row.title);
        let title = if row.is_part { format!("<span class=\"part\">{title}</span>") } else { title };
        vec![title, escaped(&with_powers(&row.value())), escaped(&with_powers(&row.remark()))]
    };
    let mut rows: Vec<Vec<String>> = group.rows.iter().map(row).collect();
    let mut head = vec!["quantity", "value", "numerical error and remarks"];
    // A column without any remark is none.
    if rows.iter().all(|cells| cells[2].is_empty()) {
        head.pop();
        for cells in &mut rows {
            cells.truncate(2);
        }
    }
    table(out, &title, &head, &rows);
}

/// The criteria; what each says has its value.
fn criteria_table(out: &mut String, criteria: &[InjuryMeasure]) {
    let row = |criterion: &InjuryMeasure| {
        vec![
            escaped(&capitalised(&criterion.title)),
            escaped(&capitalised(&criterion.statement)),
            escaped(&format!("{}. {}", capitalised(&criterion.meaning), criterion.source)),
        ]
    };
    let rows: Vec<Vec<String>> = criteria.iter().map(row).collect();
    out.push_str("<div class=\"criteria\">\n");
    table(out, "Injury criteria", &["criterion", "what it says here", "what it is compared with"], &rows);
    out.push_str("</div>\n");
}

fn quality_table(out: &mut String, run: &RecordedRun) {
    let summary = &run.summary;
    let gate = |gate: &Value| {
        let value = |name: &str| gate[name].as_f64().unwrap_or(f64::NAN);
        let written = |text: String| escaped(&with_powers(&text));
        vec![
            escaped(gate["meaning"].as_str().unwrap_or_default()),
            written(rounded(value("value"))),
            written(short(value("limit"))),
            escaped(gate["result"].as_str().unwrap_or_default()),
        ]
    };
    let rows: Vec<Vec<String>> = summary["gates"].as_array().into_iter().flatten().map(gate).collect();
    out.push_str("<div class=\"checks\">\n");
    table(out, "Checks of the computation", &["check", "value", "limit", "result"], &rows);
    let bars = escaped(summary["error_bars"].as_str().unwrap_or_default());
    push(out, format_args!("<p class=\"small\">Error bars: {bars}.</p>"));
    if let Some(accuracy) = &run.accuracy {
        let words = escaped(&capitalised(&accuracy.words()));
        push(out, format_args!("<p class=\"small\">{words}.</p>"));
    }
    out.push_str("</div>\n");
}

/// A moment, RFC 3339 in UTC, to the second.
fn moment(text: &str) -> String {
    format!("{} UTC", text.get(..19).unwrap_or(text).replace('T', " "))
}

/// Who and when; then engine, scene and recording, by which a reader finds them again.
fn provenance(out: &mut String, run: &RecordedRun, origin: &Origin<'_>) {
    let facts = [
        ("Submitted by", origin.submitted_by.map(str::to_owned)),
        ("Submitted on", origin.submitted_at.map(moment)),
        ("Computed", origin.computed_at.map(moment)),
    ];
    let known = facts.into_iter().filter_map(|(what, value)| Some((what, escaped(&value?))));
    let known =
        known.map(|(what, value)| format!("<dt>{what}</dt><dd>{value}</dd>")).collect::<Vec<_>>().concat();
    if !known.is_empty() {
        push(out, format_args!("<dl class=\"origin\">{known}</dl>"));
    }
    let known = |name: &str| run.metadata.get(name).map(String::as_str);
    let mut items = Vec::new();
    if let Some(version) = known("engine_version") {
        let commit = known("engine_commit").filter(|commit| *commit != "unknown");
        items.push(format!("Contuse {version} ({})", commit.unwrap_or("commit not stated by its build")));
    }
    items.extend(known("scene_hash").map(|hash| format!("scene: SHA-256 {hash}")));
    if !run.digest.is_empty() {
        items.push(format!("recording: SHA-256 {}", run.digest));
    }
    push(out, format_args!("<p class=\"small provenance\">{}</p>", escaped(&items.join(" · "))));
}

#[cfg(test)]
mod tests {
    use super::super::tests::example;
    use super::*;
    use crate::measure::summary::number;
    use serde_json::json;

    #[test]
    fn every_row_of_the_listing_is_in_the_page_and_a_miss_has_none() {
        let mut run = example();
        let unknown = Origin::default();
        let numbers = page(&run, &unknown).unwrap();
        // What is not known has no row.
        assert!(!numbers.contains("<dt>") && !numbers.contains("not stated</dd>"), "{numbers}");
        let known = Origin {
            submitted_by: Some("anna & co"),
            computed_at: Some("2026-11-28T15:30:12.123Z"),
            ..unknown
        };
        let known = page(&run, &known).unwrap();
        assert!(
            known.contains("<dd>anna &amp; co</dd>") && known.contains("<dd>2026-11-28 15:30:12 UTC</dd>")
        );
        for row in listing(run.results().unwrap()).iter().flat_map(|group| &group.rows) {
            let value = escaped(&with_powers(&row.value()));
            assert!(numbers.contains(&escaped(&row.title)) && numbers.contains(&value));
        }
        // Small numbers are written as powers of ten, and a zero as such.
        run.summary["gates"] = json!([{"meaning": "energy", "value": 1e-9, "limit": 0.01, "result": "passed"},
            {"meaning": "overlap", "value": 0.0, "limit": 1e-6, "result": "passed"}]);
        let checks = page(&run, &unknown).unwrap();
        assert!(checks.contains("energy</td><td>1.0 × 10⁻⁹</td><td>0.01</td>"), "{checks}");
        assert!(checks.contains("overlap</td><td>0</td><td>10⁻⁶</td>"), "{checks}");
        assert!(numbers.contains("(1000) N") && numbers.contains("NOT RESOLVED"), "{numbers}");
        // The list of warnings is whole and in their order, and repeats none of the plain words.
        let mut with_worst = run.clone();
        with_worst.summary["warnings"] = json!(["Not over.", "Too coarse.", "Untested."]);
        with_worst.summary["plain_words"] = json!(["A sentence.", "Not over."]);
        let listed = page(&with_worst, &unknown).unwrap();
        assert!(
            listed.contains(
                "are used</h2><ul>\n<li>Not over.</li>\n<li>Too coarse.</li>\n<li>Untested.</li>\n</ul>"
            ),
            "{listed}"
        );
        assert!(listed.matches("Not over.").count() == 1 && listed.contains("<li>A sentence.</li>\n</ul>"));
        // What a criterion says is written once.
        let criteria = numbers.split_once("Injury criteria").unwrap().1.split_once("</table>").unwrap().0;
        let values: Vec<String> =
            run.criteria.iter().filter_map(|of| Some(format!("{} {}", number(of.value?), of.unit))).collect();
        assert!(!values.is_empty());
        for value in values {
            assert_eq!(criteria.matches(&value).count(), 1, "{value}: {criteria}");
        }
        let of_computation = numerics_group(run.numerics.as_ref().unwrap(), &run.relaxation);
        assert!(of_computation.rows.len() > 4 && numbers.contains("smallest Jacobian J</td><td>0.7353"));
        for row in &of_computation.rows {
            let value = escaped(&with_powers(&row.value()));
            assert!(numbers.contains(&escaped(&row.title)) && numbers.contains(&value));
        }
        let element = json!({"body": "gel", "part": "block", "element": 255});
        run.summary["failure"] = json!({"cause": "element_inverted", "message": "J < 0.", "remedy": "Refine.", "element": element});
        let of = json!({"number": "impulse", "relative": 0.02, "of": "number"});
        run.summary["accuracy"] = json!({"reached": false, "requested": 0.01, "numbers": [of], "mesh_factor": 2.0, "is_estimated": false});
        run.take_numbers().unwrap();
        let failed = page(&run, &unknown).unwrap();
        let said =
            "The run failed: J &lt; 0. Where: element 255 of part block of body gel. What to do: Refine.";
        assert!(
            failed.contains("<p class=\"small\">Accuracy of 1 % NOT reached with 2.00 times"),
            "{failed}"
        );
        assert!(failed.contains(said) && !numbers.contains("The run failed"), "{failed}");
        run.summary["results"]["nothing_touched"] = true.into();
        run.take_numbers().unwrap();
        let miss = page(&run, &unknown).unwrap();
        assert!(miss.contains("Nothing touched") && !miss.contains("(1000) N"), "{miss}");
    }
}
