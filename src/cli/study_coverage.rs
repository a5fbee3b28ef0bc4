//! `contuse study coverage`: coverage of the error bars.

use super::json::write_json;
use super::run::watch_for_ctrl_c;
use super::{CliError, Exit};
use crate::step::Interrupt;
use crate::study::coverage::{CoverageStudy, Number, cases, study_coverage};
use clap::Args;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write;
use std::sync::atomic::Ordering;

/// Arguments of `contuse study coverage`.
#[derive(Args, Debug)]
pub struct CoverageArgs {
    /// Omit the finest meshes.
    #[arg(long)]
    pub short: bool,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Runs the scenes with exact solutions; prints Markdown by default.
///
/// # Errors
/// If the answer cannot be written.
pub fn coverage(args: &CoverageArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let cancelled = watch_for_ctrl_c()?;
    let is_cancelled = || cancelled.load(Ordering::Relaxed);
    let study = study_coverage(&cases(args.short), &|| is_cancelled().then_some(Interrupt::Cancel));
    if args.json {
        write_json(&study, out)?;
    } else {
        out.write_all(markdown(&study).as_bytes())?;
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
    table(&mut text, study, "quantity", |number| number.quantity);
    table(&mut text, study, "scenario", |number| number.scenario);
    let missed: Vec<&Number> = study.numbers.iter().filter(|number| !number.is_covered()).collect();
    if !missed.is_empty() {
        text += "\n| not within its error bar | | exact | computed | error | error bar |\n|---|---|---|---|---|---|\n";
    }
    // Writing to a String cannot fail.
    for n in missed {
        let (error, bar) = (n.error(), n.error_bar);
        let _ = writeln!(
            text,
            "| {}, {} | {} | {:.5e} | {:.5e} | {error:.1e} | {bar:.1e} |",
            n.scenario, n.run, n.quantity, n.exact, n.value
        );
    }
    for none in &study.without {
        let _ = writeln!(text, "\n{}, {}: {}", none.scenario, none.run, none.reason);
    }
    text
}

/// Coverage of each group of numbers, with the median error and error bar.
fn table(text: &mut String, study: &CoverageStudy, title: &str, group: fn(&Number) -> &'static str) {
    let groups: BTreeSet<&str> = study.numbers.iter().map(group).collect();
    let _ = write!(
        text,
        "\n| {title} | numbers | within | median error | median error bar |\n|---|---|---|---|---|\n"
    );
    for name in groups {
        let (share, count) = study.share(|number| group(number) == name);
        let of_group = || study.numbers.iter().filter(|n| group(n) == name && n.exact != 0.0);
        let relative = |part: fn(&Number) -> f64| {
            let mut parts: Vec<f64> = of_group().map(|n| part(n) / n.exact.abs()).collect();
            parts.sort_by(f64::total_cmp);
            parts.get(parts.len() / 2).map_or_else(|| "-".into(), |middle| format!("{middle:.1e}"))
        };
        let _ = writeln!(
            text,
            "| {name} | {count} | {:.0} % | {} | {} |",
            100.0 * share,
            relative(Number::error),
            relative(|n| n.error_bar)
        );
    }
}
