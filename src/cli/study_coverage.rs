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
    let study = if args.impacts {
        study_impacts(&impacts(args.short), &interrupt)
    } else {
        study_coverage(&cases(args.short), &interrupt)
    };
    match (args.json, args.impacts) {
        (true, _) => write_json(&study, out)?,
        (false, true) => out.write_all(impacts_in_markdown(&study).as_bytes())?,
        (false, false) => out.write_all(markdown(&study).as_bytes())?,
    }
    Ok(if is_cancelled() { Exit::Cancelled } else { Exit::Success })
}

fn markdown(study: &CoverageStudy) -> String {
    let (fraction, numbers) = study.fraction(|_| true);
    let mut text = format!(
        "{} runs, {numbers} numbers whose exact value is known: {:.1} % within their error bars\n",
        study.runs,
        100.0 * fraction
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
    for bars in ["two levels", "three levels", "accuracy"] {
        for (chosen_on, what) in [(false, "are reported on only"), (true, "constants may be chosen on")] {
            let picks = |number: &&Number| number.bars == bars && number.chosen_on == chosen_on;
            let picked: Vec<&Number> = study.numbers.iter().filter(picks).collect();
            if picked.is_empty() {
                continue;
            }
            let plain: Vec<&Number> = picked.iter().copied().filter(|number| number.resolved).collect();
            let runs: BTreeSet<_> = picked.iter().map(|number| (number.scenario, &number.run)).collect();
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "\n{bars}, impacts that {what}, {} runs: {}; of these resolved: {}",
                runs.len(),
                in_words(&picked),
                in_words(&plain)
            );
            table(&mut text, &picked, "quantity", |number| &number.quantity);
            table(&mut text, &picked, "impact", |number| number.scenario);
        }
    }
    let excess = |number: &Number| number.error / number.error_bar;
    let mut missed: Vec<&Number> = study.numbers.iter().filter(|number| !number.is_covered()).collect();
    missed.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
    let _ = writeln!(text, "\n{} numbers are not within their error bars; the farthest:", missed.len());
    missed.truncate(MOST_LISTED);
    list_missed(&mut text, &missed);
    list_without(&mut text, study);
    text
}

/// How many numbers there are, how many are within their error bars, and how wide these are.
fn in_words(numbers: &[&Number]) -> String {
    let covered = numbers.iter().filter(|number| number.is_covered()).count();
    let fraction = 100.0 * covered as f64 / numbers.len().max(1) as f64;
    let ratio = written(median(numbers, |n| n.error_bar / n.error), 1);
    format!("{} numbers, {fraction:.1} % within, median of bar / error {ratio}", numbers.len())
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
        let relative = |part: fn(&Number) -> f64| {
            median(&of_group, |n| part(n) / n.exact.abs())
                .map_or_else(|| "-".into(), |middle| format!("{middle:.1e}"))
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {:.0} % | {} | {} | {} |",
            of_group.len(),
            100.0 * covered as f64 / of_group.len().max(1) as f64,
            relative(|n| n.error),
            relative(|n| n.error_bar),
            written(median(&of_group, |n| n.error_bar / n.error), 1)
        );
    }
}

/// Median of the finite ones of a part of each number.
fn median(numbers: &[&Number], part: impl Fn(&Number) -> f64) -> Option<f64> {
    let mut parts: Vec<f64> = numbers.iter().map(|n| part(n)).filter(|part| part.is_finite()).collect();
    parts.sort_by(f64::total_cmp);
    parts.get(parts.len() / 2).copied()
}

fn written(number: Option<f64>, digits: usize) -> String {
    number.map_or_else(|| "-".into(), |number| format!("{number:.digits$}"))
}
