//! The recorded lines as a table.

use super::RecordedRun;
use std::io::{self, Write};

/// What is to be known of the table, in lines that begin with `#`; then one line a recorded time: each pair's force over the window of the summary and patch area, then the energies.
///
/// # Errors
/// When it cannot be written.
pub fn write(run: &RecordedRun, out: &mut dyn Write) -> io::Result<()> {
    let window = force_window(run);
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    for (name, pair) in &run.pairs {
        let force = pair.windowed_force(window).into_iter().map(|(_, force)| force).collect();
        columns.push((format!("{name} mean force over the last {window} s [N]"), force));
        columns.push((format!("{name} patch area [m²]"), pair.patch_area_m2.clone()));
    }
    for (name, line) in &run.bodies {
        columns
            .push((format!("{name} kinetic and strain energy [J]"), line.iter().map(|(_, e)| *e).collect()));
    }
    for (name, line) in [("absorbed by the tissue [J]", &run.absorbed), ("total [J]", &run.total)] {
        columns.push((name.to_owned(), line.iter().map(|(_, e)| *e).collect()));
    }
    remarks(run, out)?;
    let header: Vec<String> = columns.iter().map(|(name, _)| text_cell(name)).collect();
    writeln!(out, "time [s],{}", header.join(","))?;
    for (row, (time, _)) in run.total.iter().enumerate() {
        let cells: Vec<String> = columns
            .iter()
            .map(|(_, values)| values.get(row).map_or_else(String::new, f64::to_string))
            .collect();
        writeln!(out, "{time},{}", cells.join(","))?;
    }
    Ok(())
}

/// That it is for research only, how the run ended, and why its results are withheld if they are.
fn remarks(run: &RecordedRun, out: &mut dyn Write) -> io::Result<()> {
    let summary = &run.summary;
    let mut remark = |text: &str| writeln!(out, "# {}", text.replace(['\n', '\r'], " "));
    if let Some(notice) = summary["notice"].as_str() {
        remark(notice)?;
    }
    let text = |pointer: &str| summary.pointer(pointer).and_then(|value| value.as_str()).unwrap_or_default();
    if summary["ending"] != "finished" {
        remark(&format!(
            "The run did not come to its end: {}. {}",
            text("/ending"),
            text("/failure/message")
        ))?;
    }
    if summary.get("withheld").is_some() {
        remark(&format!("The results are withheld, these lines are none: {}.", text("/withheld/reason")))?;
    }
    Ok(())
}

/// A text in quotes. Where a spreadsheet would read a formula, an apostrophe before it says that it is a text.
pub fn text_cell(text: &str) -> String {
    let mark = if text.starts_with(['=', '+', '-', '@', '\t', '\r']) { "'" } else { "" };
    format!("\"{mark}{}\"", text.replace('"', "\"\""))
}

/// Window of the peak force [s], as the summary says.
pub(super) fn force_window(run: &RecordedRun) -> f64 {
    let told = super::headline_impact(super::values(&run.summary))
        .and_then(|impact| impact["force_window_s"].as_f64());
    told.filter(|window| *window > 0.0).unwrap_or(5e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_no_formulas() {
        assert_eq!(text_cell("ball \"A\""), "\"ball \"\"A\"\"\"");
        for text in ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1"] {
            assert_eq!(text_cell(text), format!("\"'{text}\""));
        }
    }
}
