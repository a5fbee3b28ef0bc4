//! `contuse study stability`: the matrix of stiff and extreme cases.

use super::picture::PictureArgs;
use super::run::watch_for_ctrl_c;
use super::{CliError, Exit, write_json};
use crate::step::Interrupt;
use crate::study::stability::{Cell, StabilityStudy, Stepping, Verdict, cases, picture, study_stability};
use clap::Args;
use std::fmt::Write as _;
use std::io::{self, IsTerminal as _, Write};
use std::sync::atomic::Ordering;

/// Steps of the implicit scheme over the explicit one where none are asked for.
const USUAL_RATIOS: [u32; 4] = [1, 10, 100, 1000];

/// Arguments of `contuse study stability`.
#[derive(Args, Debug)]
pub struct StabilityArgs {
    /// The ends of each axis only, and no implicit steps as short as the explicit ones unless `--implicit` asks for them: less than a
    /// minute of one core; with them some minutes, most of them for one cell, the thinnest layers.
    #[arg(long)]
    pub short: bool,
    /// Steps of the implicit scheme over the explicit one; 0 leaves the scheme out. By default 1, 10, 100 and 1000, and with `--short` all
    /// but the first.
    #[arg(long, value_delimiter = ',')]
    pub implicit: Option<Vec<u32>>,
    /// Answer as JSON.
    #[arg(long)]
    pub json: bool,
    /// The matrix as a picture.
    #[command(flatten)]
    pub picture: PictureArgs,
}

/// Runs the matrix; Markdown by default. Exit code 1 when a cell neither finished nor was diagnosed.
///
/// # Errors
/// When a file cannot be written.
pub fn stability(args: &StabilityArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let cancelled = watch_for_ctrl_c()?;
    let usual = if args.short { &USUAL_RATIOS[1..] } else { &USUAL_RATIOS };
    let steppings = Stepping::with_implicit(args.implicit.as_deref().unwrap_or(usual));
    let cases = cases(args.short);
    let study = study_stability(
        &cases,
        &steppings,
        &|| cancelled.load(Ordering::Relaxed).then_some(Interrupt::Cancel),
        &mut |cell| {
            if io::stderr().is_terminal() {
                eprintln!("{} {}, {}: {}", cell.axis, cell.value, cell.stepping, cell.ending);
            }
        },
    );
    args.picture.write(|| picture(&study))?;
    if args.json {
        write_json(&study, out)?;
    } else {
        out.write_all(markdown(&study, cases.len() * steppings.len()).as_bytes())?;
    }
    Ok(match () {
        () if study.stopped.is_some() => Exit::Cancelled,
        () if study.wrong > 0 => Exit::Unexpected,
        () => Exit::Success,
    })
}

/// The matrix for people: what finished, then why the rest did not. `asked` is how many cells it has when it is whole.
fn markdown(study: &StabilityStudy, asked: usize) -> String {
    let mut text = String::new();
    if let Some(why) = &study.stopped {
        let missing = asked - study.cells.len();
        let _ = writeln!(
            text,
            "STOPPED ({why}): the last cell is incomplete, and {missing} of {asked} cells are missing.\n"
        );
    }
    let _ = write!(
        text,
        "{} cells; of {} that could happen {} finish within their gates ({:.0} %); {} without a diagnosis\n\n",
        study.cells.len(),
        study.physical,
        study.physical_finished,
        100.0 * study.physical_finished as f64 / study.physical.max(1) as f64,
        study.wrong
    );
    text += "| axis | value | stepping | ending | energy error | growth | contact loss | smallest J | penetration | steps | time |\n";
    text += "|---|---|---|---|---|---|---|---|---|---|---|\n";
    for cell in &study.cells {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}", line(cell));
    }
    text += "\n## What did not finish\n\n";
    for cell in study.cells.iter().filter(|cell| cell.verdict != Verdict::Finished) {
        let reason = cell.reason.as_deref().unwrap_or_default();
        let remedy = cell.remedy.as_ref().map(|remedy| format!(" Remedy: {remedy}")).unwrap_or_default();
        let _ = writeln!(text, "- {} {}, {}: {reason}{remedy}", cell.axis, cell.value, cell.stepping);
    }
    text
}

fn line(cell: &Cell) -> String {
    let head =
        format!("| {} | {} | {} | {}", cell.axis, cell.value, cell.stepping, cell.ending.replace('_', " "));
    if cell.verdict == Verdict::Refused {
        return format!("{head} | | | | | | | |");
    }
    let reached =
        if cell.reached < 1.0 - 1e-9 { format!(" at {:.0} %", 100.0 * cell.reached) } else { String::new() };
    format!(
        "{head}{reached} | {:.1e} | {:.4} | {:.1} % | {:.3} | {:.1e} | {} | {:.2} s |",
        cell.balance_error,
        cell.growth,
        100.0 * cell.contact_loss,
        cell.smallest_jacobian,
        cell.penetration,
        cell.steps,
        cell.wall_s
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_that_was_stopped_says_what_is_missing() {
        let cases = cases(true);
        let steppings = Stepping::with_implicit(&[]);
        let stop = || Some(Interrupt::Cancel);
        let study = study_stability(&cases, &steppings, &stop, &mut |_| {});
        let text = markdown(&study, cases.len() * steppings.len());
        let missing = format!("{} of {} cells are missing", cases.len() - 1, cases.len());
        assert!(text.starts_with("STOPPED (cancelled)") && text.contains(&missing), "{text}");
        assert!(text.contains("it was stopped by hand. Remedy: let it run to its end"), "{text}");
    }
}
