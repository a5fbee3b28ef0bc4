//! The report as one self-contained, printable HTML page.

use super::number_of_kpa;
use super::numbers::cards;
use super::omissions::omissions;
use super::pictures::pictures;
use super::section_picture::section_picture;
use super::{RecordedRun, Shown, is_miss};
use crate::measure::summary::{number, rounded};
use serde_json::Value;
use std::fmt::Write as _;

const STYLE: &str = include_str!("report.css");

/// The HTML page of a run.
///
/// # Errors
/// The message of the drawing library.
pub fn page(run: &RecordedRun) -> Result<String, String> {
    let summary = &run.summary;
    let title = escaped(summary["scene"].as_str().unwrap_or("a scene"));
    let mut body = String::new();
    header(&mut body, run);
    provenance(&mut body, run);
    section(&mut body, run);
    cards(&mut body, summary);
    stress_table(&mut body, summary);
    list(&mut body, "To read before the numbers are used", &summary["warnings"]);
    list_of(&mut body, "What the model omits", &omissions(run));
    criteria_table(&mut body, summary);
    body += "<section><h2>Over time</h2><div class=\"pictures\">";
    for picture in pictures(run)? {
        push(
            &mut body,
            format_args!(
                "<figure>{}<figcaption>{}</figcaption></figure>",
                inline(&picture.svg),
                picture.title
            ),
        );
    }
    body += "</div></section>";
    strain_table(&mut body, summary);
    quality_table(&mut body, summary);
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

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The picture without its XML declaration, marked as an image.
fn inline(svg: &str) -> String {
    let from = svg.find("<svg").unwrap_or_default();
    svg[from..].replacen("<svg ", "<svg role=\"img\" ", 1)
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
            "<p class=\"state {ending}\">{ending} at {} µs of {} µs, {} steps</p>",
            number(1e6 * summary["time_s"].as_f64().unwrap_or_default()),
            number(1e6 * summary["end_time_s"].as_f64().unwrap_or_default()),
            summary["steps"]
        ),
    );
    push(out, format_args!("<p class=\"notice\">{}</p></header>", text(&summary["notice"])));
    if is_miss(summary) {
        out.push_str("<p class=\"withheld\">Nothing touched: there are no numbers of an impact.</p>\n");
    }
    if let Some(reason) = summary.pointer("/withheld/reason") {
        push(out, format_args!("<p class=\"withheld\">The results are withheld: {}.</p>", text(reason)));
    }
}

/// The section through the impact at the worst instant.
fn section(out: &mut String, run: &RecordedRun) {
    let stresses = run.summary.pointer("/results/tissue/significant_stress").and_then(Value::as_array);
    let thresholds: Vec<f64> =
        stresses.into_iter().flatten().filter_map(|stress| stress["threshold_pa"].as_f64()).collect();
    let picture = run.instant.as_ref().and_then(|instant| section_picture(instant, &run.scene, &thresholds));
    if let Some((svg, caption)) = picture.filter(|_| !is_miss(&run.summary)) {
        push(
            out,
            format_args!(
                "<figure class=\"section\">{}<figcaption>{caption}</figcaption></figure>",
                inline(&svg)
            ),
        );
    }
}

fn list(out: &mut String, title: &str, items: &Value) {
    let items = items.as_array().into_iter().flatten().filter_map(Value::as_str);
    list_of(out, title, &items.map(str::to_owned).collect::<Vec<_>>());
}

fn list_of(out: &mut String, title: &str, items: &[String]) {
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
    push(out, format_args!("<section><h2>{title}</h2><table><thead><tr>"));
    for name in head {
        push(out, format_args!("<th>{name}</th>"));
    }
    out.push_str("</tr></thead><tbody>\n");
    for row in rows {
        push(out, format_args!("<tr><td>{}</td></tr>", row.join("</td><td>")));
    }
    out.push_str("</tbody></table></section>\n");
}

/// The number, in brackets if its error is unknown or exceeds it.
fn value_of(shown: Shown) -> String {
    if shown.is_resolved { number(shown.value) } else { format!("({})", number(shown.value)) }
}

fn with_error(quantity: &Value) -> String {
    let Some(shown) = Shown::of(quantity) else { return "–".into() };
    let error = shown.error.map_or_else(String::new, |error| format!(" ± {}", rounded(error)));
    let doubt = shown.doubt().map_or_else(String::new, |doubt| format!(", {doubt}"));
    format!("{}{error}{doubt}", value_of(shown))
}

fn stress_table(out: &mut String, summary: &Value) {
    if is_miss(summary) {
        return;
    }
    let tissue = &summary["results"]["tissue"];
    let mut rows = Vec::new();
    for stress in tissue["significant_stress"].as_array().into_iter().flatten() {
        let threshold = number_of_kpa(stress["threshold_pa"].as_f64().unwrap_or_default());
        let layers = stress["layers"].as_array().into_iter().flatten().map(|layer| {
            let depth = |index: usize| {
                layer["depth_mm"][index].as_f64().map_or_else(String::new, |depth| format!("{depth:.1}"))
            };
            format!("{} {}–{} mm", escaped(layer["part"].as_str().unwrap_or_default()), depth(0), depth(1))
        });
        let ends = stress["reaches"].as_array().into_iter().flatten().filter_map(Value::as_str);
        let ends = ends.map(|end| format!("reaches {}: at least so deep and large", escaped(end)));
        rows.push(vec![
            format!("von Mises &gt; {threshold}"),
            with_error(&stress["depth_mm"]),
            with_error(&stress["volume_mm3"]),
            layers.chain(ends).collect::<Vec<_>>().join(", "),
        ]);
    }
    for dose in tissue["dose_volumes"].as_array().into_iter().flatten() {
        let name =
            if dose["measure"] == "principal_strain" { "principal strain" } else { "energy density [J/m³]" };
        rows.push(vec![
            format!("{name} &gt; {}", number(dose["threshold"].as_f64().unwrap_or_default())),
            "–".into(),
            with_error(&dose["volume_mm3"]),
            String::new(),
        ]);
    }
    table(out, "Where in the tissue", &["threshold", "depth [mm]", "volume [mm³]", "parts"], &rows);
}

/// Strain and stress of the tissue: exceeded in volumes, which converge with the mesh, and at points, which need not.
fn strain_table(out: &mut String, summary: &Value) {
    if is_miss(summary) {
        return;
    }
    let tissue = &summary["results"]["tissue"];
    let mut rows = Vec::new();
    let mut add = |name: String, unit: &str, quantity: &Value| {
        if Shown::of(quantity).is_some() {
            rows.push(vec![name, unit.to_owned(), with_error(quantity)]);
        }
    };
    let in_volume = &tissue["exceeded_in_volume"];
    let volume = format!("exceeded in {} mm³", number(in_volume["volume_mm3"].as_f64().unwrap_or_default()));
    add(format!("principal strain {volume}"), "-", &in_volume["principal_strain"]);
    add(format!("von Mises stress {volume}"), "Pa", &in_volume["von_mises_pa"]);
    for of in tissue["percentiles"].as_array().into_iter().flatten() {
        let part = escaped(of["part"].as_str().unwrap_or_default());
        add(format!("principal strain of {part}, 95th percentile by volume (MPS95)"), "-", &of["mps95"]);
    }
    add("principal strain, largest at a point".into(), "-", &tissue["peak_principal_strain"]);
    add("von Mises stress, largest at a point".into(), "Pa", &tissue["peak_von_mises_pa"]);
    table(out, "Strain and stress of the tissue", &["quantity", "unit", "value"], &rows);
}

fn criteria_table(out: &mut String, summary: &Value) {
    let of = |criterion: &Value| {
        let text = |name: &str| escaped(criterion[name].as_str().unwrap_or_default());
        let unit = if criterion["unit"] == "-" { String::new() } else { format!(" {}", text("unit")) };
        let value = match criterion["value"].as_f64() {
            // A value that follows from the scene alone has no error.
            Some(value) if criterion.get("error").is_none() => format!("{}{unit}", number(value)),
            Some(_) => format!("{}{unit}", with_error(criterion)),
            None => "–".into(),
        };
        vec![text("title"), value, text("statement"), format!("{}. {}", text("meaning"), text("source"))]
    };
    let rows: Vec<Vec<String>> =
        summary["injury_measures"].as_array().into_iter().flatten().map(of).collect();
    table(
        out,
        "Injury criteria",
        &["criterion", "value", "what it says here", "what it is compared with"],
        &rows,
    );
}

fn quality_table(out: &mut String, summary: &Value) {
    let gate = |gate: &Value| {
        let value = |name: &str| gate[name].as_f64().unwrap_or(f64::NAN);
        vec![
            escaped(gate["meaning"].as_str().unwrap_or_default()),
            format!("{:.1e}", value("value")),
            format!("{:.0e}", value("limit")),
            escaped(gate["result"].as_str().unwrap_or_default()),
        ]
    };
    let rows: Vec<Vec<String>> = summary["gates"].as_array().into_iter().flatten().map(gate).collect();
    table(out, "Checks of the computation", &["check", "value", "limit", "result"], &rows);
    let bars = escaped(summary["error_bars"].as_str().unwrap_or_default());
    push(out, format_args!("<p class=\"small\">Error bars: {bars}.</p>"));
}

/// Engine, scene and recording, by which a reader finds them again.
fn provenance(out: &mut String, run: &RecordedRun) {
    let known = |name: &str| run.metadata.get(name).map(String::as_str);
    let mut items = Vec::new();
    if let Some(version) = known("engine_version") {
        let commit = known("engine_commit").filter(|commit| *commit != "unknown");
        items.push(format!("Contuse {version}{}", commit.map_or_else(String::new, |c| format!(" ({c})"))));
    }
    items.extend(known("scene_hash").map(|hash| format!("scene: SHA-256 {hash}")));
    if !run.digest.is_empty() {
        items.push(format!("recording: SHA-256 {}", run.digest));
    }
    push(out, format_args!("<p class=\"small provenance\">{}</p>", escaped(&items.join(" · "))));
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_number_in_a_table_has_brackets_once_and_a_miss_no_table() {
        let unknown = json!({"value": 2730.0, "error": "not estimated"});
        assert_eq!(with_error(&unknown), "(2730), error not estimated");
        let mut miss = String::new();
        let summary = json!({"results": {"nothing_touched": true, "impacts": [], "headline": {}}});
        stress_table(&mut miss, &summary);
        assert!(miss.is_empty(), "{miss}");
    }
}
