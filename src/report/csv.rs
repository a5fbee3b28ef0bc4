//! The recorded time series as a table.

use super::RecordedRun;
use super::averaged_force::Average;
use crate::measure::impact_force::FRACTION_OF_CONTACT;
use crate::measure::summary::Results;
use crate::scene::document::ForceFilter;
use std::io::{self, Write};

/// Writes remarks, in lines that begin with `#`; then one line per recorded time: each pair's force, averaged as in the
/// summary, and patch area, then the energies.
///
/// # Errors
/// When writing fails.
pub fn write(run: &RecordedRun, out: &mut dyn Write) -> io::Result<()> {
    let average = force_average(run);
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    for (name, pair) in &run.pairs {
        let force = pair.averaged_force(average).into_iter().map(|(_, force)| force).collect();
        let words = match average {
            Average::Window(window) => format!("mean force over the last {window} s"),
            Average::Filter(filter) => format!("force, filtered by {}", filter.name()),
        };
        columns.push((format!("{name} {words} [N]"), force));
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

/// Remarks: research use only, how the run ended, and why its results are withheld, if so.
fn remarks(run: &RecordedRun, out: &mut dyn Write) -> io::Result<()> {
    let summary = &run.summary;
    let mut remark = |text: &str| writeln!(out, "# {}", text.replace(['\n', '\r'], " "));
    if let Some(notice) = summary["notice"].as_str() {
        remark(notice)?;
    }
    let text = |pointer: &str| summary.pointer(pointer).and_then(|value| value.as_str()).unwrap_or_default();
    if summary["ending"] != "finished" {
        remark(&format!("The run did not finish: {}. {}", text("/ending"), text("/failure/message")))?;
    }
    if let Some(reason) = run.withheld() {
        remark(&format!("The results are withheld, and these lines must not be used as such: {reason}."))?;
    }
    Ok(())
}

/// A quoted text. Where a spreadsheet would read a formula, an apostrophe marks it as text.
pub fn text_cell(text: &str) -> String {
    let mark = if text.starts_with(['=', '+', '-', '@', '\t', '\r']) { "'" } else { "" };
    format!("\"{mark}{}\"", text.replace('"', "\"\""))
}

/// Averaging of the peak force in the summary; a tenth of the run where the summary does not give it.
pub(super) fn force_average(run: &RecordedRun) -> Average {
    let impact = run.values.as_ref().and_then(Results::headline_impact);
    let filter = impact.and_then(|i| i.force_filter.as_deref()).and_then(ForceFilter::from_name);
    let window = impact.and_then(|i| i.force_window_s).filter(|window| *window > 0.0);
    let of_run =
        || run.summary["time_s"].as_f64().filter(|time| *time > 0.0).map(|time| FRACTION_OF_CONTACT * time);
    match filter {
        Some(filter) => Average::Filter(filter),
        None => Average::Window(window.or_else(of_run).unwrap_or(1.0)),
    }
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
