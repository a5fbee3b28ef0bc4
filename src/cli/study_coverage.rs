//! `contuse study coverage`: coverage of the error bars.

use super::json::write_json;
use super::run::watch_for_ctrl_c;
use super::{CliError, Exit};
use crate::step::Interrupt;
use crate::study::coverage::{CoverageStudy, Number, cases, impacts, study_coverage, study_impacts};
use clap::Args;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write;
use std::sync::atomic::Ordering;

/// Arguments of `contuse study coverage`.
#[derive(Args, Debug)]
pub struct CoverageArgs {
    /// Run impacts on layered tissue, compared with much finer meshes, instead of scenes with exact solutions.
    #[arg(long)]
    pub impacts: bool,
    /// Omit the finest meshes.
    #[arg(long)]
    pub short: bool,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Most numbers beyond their error bars that are listed for impacts.
const MOST_LISTED: usize = 20;

/// Runs the scenes with exact solutions, or the impacts; prints Markdown by default.
///
/// # Errors
/// If the answer cannot be written.
pub fn coverage(args: &CoverageArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let cancelled = watch_for_ctrl_c()?;
    let is_cancelled = || cancelled.load(Ordering::Relaxed);
    let interrupt = || is_cancelled().then_some(Interrupt::Cancel);
    let study = match args.impacts {
        true => study_impacts(&impacts(args.short), &interrupt),
        false => study_coverage(&cases(args.short), &interrupt),
    };
    match (args.json, args.impacts) {
        (true, _) => write_json(&study, out)?,
        (false, true) => out.write_all(impacts_in_markdown(&study).as_bytes())?,
        (false, false) => out.write_all(markdown(&study).as_bytes())?,
    }
    Ok(if is_cancelled() { Exit::Cancelled } else { Exit::Success })
}

fn markdown(study: &CoverageStudy) -> String {
    let (share, numbers) = study.share(|_| true);
    let mut text = format!(
        "{} runs, {numbers} numbers whose exact value is known: {:.1} % within their error bars\n",
        study.runs,
        100.0 * share
    );
    let all: Vec<&Number> = study.numbers.iter().collect();
    table(&mut text, &all, "quantity", |number| &number.quantity);
    table(&mut text, &all, "scenario", |number| number.scenario);
    let missed: Vec<&Number> = study.numbers.iter().filter(|number| !number.is_covered()).collect();
    list_missed(&mut text, &missed);
    list_without(&mut text, study);
    text
}

fn impacts_in_markdown(study: &CoverageStudy) -> String {
    let mut text = String::new();
    for bars in ["two levels", "three levels"] {
        for (chosen_on, what) in [(false, "reported on"), (true, "constants were chosen on")] {
            let picks = |number: &&Number| number.bars == bars && number.chosen_on == chosen_on;
            let picked: Vec<&Number> = study.numbers.iter().filter(picks).collect();
            let plain: Vec<&Number> = picked.iter().copied().filter(|number| number.resolved).collect();
            let percent = |of: &[&Number]| 100.0 * of.iter().filter(|n| n.is_covered()).count() as f64 / of.len().max(1) as f64;
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "\n{bars}, impacts that {what}: {} numbers, {:.1} % within their error bars; {} of them resolved, {:.1} % within",
                picked.len(), percent(&picked), plain.len(), percent(&plain)
            );
            if !chosen_on {
                table(&mut text, &picked, "quantity", |number| &number.quantity);
            }
            table(&mut text, &picked, "impact", |number| number.scenario);
        }
    }
    let excess = |number: &Number| number.error / number.error_bar;
    let mut missed: Vec<&Number> = study.numbers.iter().filter(|number| !number.is_covered()).collect();
    missed.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
    let _ = writeln!(text, "\nThe farthest {MOST_LISTED} of {} beyond their error bars:", missed.len());
    missed.truncate(MOST_LISTED);
    list_missed(&mut text, &missed);
    list_without(&mut text, study);
    text
}

fn list_missed(text: &mut String, missed: &[&Number]) {
    if !missed.is_empty() {
        *text += "\n| not within its error bar | | exact | computed | error | error bar |\n|---|---|---|---|---|---|\n";
    }
    for n in missed {
        let _ = writeln!(
            text,
            "| {}, {} | {} | {:.5e} | {:.5e} | {:.1e} | {:.1e} |",
            n.scenario, n.run, n.quantity, n.exact, n.value, n.error, n.error_bar
        );
    }
}

fn list_without(text: &mut String, study: &CoverageStudy) {
    for none in &study.without {
        let _ = writeln!(text, "\n{}, {}: {}", none.scenario, none.run, none.reason);
    }
}

/// Coverage of each group of numbers, with the median error and error bar relative to the number, and the median of their ratio.
fn table(text: &mut String, numbers: &[&Number], title: &str, group: fn(&Number) -> &str) {
    let groups: BTreeSet<&str> = numbers.iter().map(|number| group(number)).collect();
    let _ = write!(
        text,
        "\n| {title} | numbers | within | median error | median error bar | bar / error |\n|---|---|---|---|---|---|\n"
    );
    for name in groups {
        let of_group: Vec<&Number> = numbers.iter().copied().filter(|n| group(n) == name).collect();
        let covered = of_group.iter().filter(|number| number.is_covered()).count();
        let median = |part: &dyn Fn(&Number) -> f64| {
            let mut parts: Vec<f64> =
                of_group.iter().map(|n| part(n)).filter(|part| part.is_finite()).collect();
            parts.sort_by(f64::total_cmp);
            parts.get(parts.len() / 2).copied()
        };
        let written = |part: Option<f64>| part.map_or_else(|| "-".into(), |middle| format!("{middle:.1e}"));
        let _ = writeln!(
            text,
            "| {name} | {} | {:.0} % | {} | {} | {} |",
            of_group.len(),
            100.0 * covered as f64 / of_group.len().max(1) as f64,
            written(median(&|n| n.error / n.exact.abs())),
            written(median(&|n| n.error_bar / n.exact.abs())),
            median(&|n| n.error_bar / n.error).map_or_else(|| "-".into(), |ratio| format!("{ratio:.1}"))
        );
    }
}
