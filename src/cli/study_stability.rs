//! `contuse study stability`: the matrix of stiff and extreme cases, or that of ordinary impacts.

use super::json::write_json;
use super::picture::PictureArgs;
use super::run::{available_threads, watch_for_ctrl_c};
use super::{CliError, Exit};
use crate::step::Interrupt;
use crate::study::stability::{
    Cell, StabilityStudy, Stepping, Verdict, cases, ordinary_impacts, picture, study_stability,
};
use clap::Args;
use std::fmt::Write as _;
use std::io::{self, IsTerminal as _, Write};
use std::sync::atomic::Ordering;

/// Default ratios of implicit to explicit steps.
const USUAL_RATIOS: [u32; 4] = [1, 10, 100, 1000];

/// Penetration over face size below which contact counts as tight.
const TIGHT: f64 = 0.02;

/// Arguments of `contuse study stability`.
#[derive(Args, Debug)]
pub struct StabilityArgs {
    /// Ordinary impacts instead of extreme ones: five projectiles on three tissues at six speeds, on three meshes, with
    /// two formulations, to the end of contact; takes hours on one core, or two minutes with `--short` (one mesh, one
    /// formulation, two speeds). Explicit steps only.
    #[arg(long, conflicts_with = "implicit")]
    pub ordinary: bool,
    /// Only the ends of each axis, and no implicit steps as short as the explicit ones unless requested with
    /// `--implicit`: less than a minute on one core; with them some minutes, mostly for one cell, the thinnest layers.
    #[arg(long)]
    pub short: bool,
    /// Number of meshes of the ordinary impacts, coarsest first, up to three; each takes about four times the work of
    /// the one before.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=3))]
    pub meshes: u8,
    /// Ratios of implicit to explicit steps; 0 omits the implicit scheme. By default 1, 10, 100 and 1000, and with
    /// `--short` all but the first.
    #[arg(long, value_delimiter = ',')]
    pub implicit: Option<Vec<u32>>,
    /// Only cases with this text in their name, such as `rigid ball on limb`.
    #[arg(long, value_name = "TEXT")]
    pub only: Option<String>,
    /// Number of parallel cells; one per core by default.
    #[arg(long)]
    pub threads: Option<usize>,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
    /// Output files of the picture.
    #[command(flatten)]
    pub picture: PictureArgs,
}

/// Runs the matrix; prints Markdown by default. Exit code 1 if a cell neither finished nor was diagnosed.
///
/// # Errors
/// If a file cannot be written.
pub fn stability(args: &StabilityArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    args.picture.check()?;
    let cancelled = watch_for_ctrl_c()?;
    // Default step ratios; the ordinary impacts are explicit only.
    let usual = if args.short { &USUAL_RATIOS[1..] } else { &USUAL_RATIOS };
    let usual = if args.ordinary { &[] } else { usual };
    let steppings = Stepping::with_implicit(args.implicit.as_deref().unwrap_or(usual));
    let mut cases = if args.ordinary {
        ordinary_impacts(args.short, usize::from(args.meshes))
    } else {
        cases(args.short)
    };
    // Restrict the cases by name.
    if let Some(text) = &args.only {
        cases.retain(|case| case.axis.contains(text.as_str()) || case.label.contains(text.as_str()));
        if cases.is_empty() {
            return Err(CliError::Usage(format!("no case of this matrix has \"{text}\" in its name")));
        }
    }
    let study = study_stability(
        &cases,
        &steppings,
        args.threads.unwrap_or_else(available_threads),
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
        let table = if args.ordinary { table_of_impacts } else { table_of_cells };
        out.write_all(markdown(&study, cases.len() * steppings.len(), table).as_bytes())?;
    }
    Ok(match () {
        () if study.stopped.is_some() => Exit::Cancelled,
        () if study.wrong > 0 => Exit::Unexpected,
        () => Exit::Success,
    })
}

/// The matrix as Markdown: what finished, then why the rest did not. `requested` is the number of cells of the whole
/// matrix.
fn markdown(study: &StabilityStudy, requested: usize, table: fn(&[Cell]) -> String) -> String {
    let mut text = String::new();
    if let Some(why) = &study.stopped {
        let missing = requested - study.cells.len();
        let _ = writeln!(
            text,
            "STOPPED ({why}): running cells are incomplete, and {missing} of {requested} cells are missing.\n"
        );
    }
    // Statistics, table, and the diagnoses of what did not finish.
    let _ = writeln!(
        text,
        "{} cells; of {} physical ones {} finish within their limits ({:.1} %); {} without a diagnosis",
        study.cells.len(),
        study.physical,
        study.physical_finished,
        100.0 * study.physical_finished as f64 / study.physical.max(1) as f64,
        study.wrong
    );
    let finished = || study.cells.iter().filter(|cell| cell.verdict == Verdict::Finished);
    let tight = finished().filter(|cell| cell.face_penetration < TIGHT).count();
    let _ = writeln!(
        text,
        "{tight} of the {} that finished never penetrate deeper than {:.0} % of a face\n",
        finished().count(),
        100.0 * TIGHT
    );
    text += &table(&study.cells);
    text += "\n## What did not finish\n\n";
    for cell in study.cells.iter().filter(|cell| cell.verdict != Verdict::Finished) {
        let reason = cell.reason.as_deref().unwrap_or_default();
        let remedy = cell.remedy.as_ref().map(|remedy| format!(" Remedy: {remedy}")).unwrap_or_default();
        let _ = writeln!(text, "- {} {}, {}: {reason}{remedy}", cell.axis, cell.value, cell.stepping);
    }
    text
}

/// One line per cell.
fn table_of_cells(cells: &[Cell]) -> String {
    let head = "| axis | value | stepping | ending | energy error | growth | contact loss | smallest J | penetration | steps | time |\n";
    let lines = cells.iter().map(|cell| line(cell) + "\n");
    format!("{head}|---|---|---|---|---|---|---|---|---|---|---|\n{}", lines.collect::<String>())
}

/// One line per impact: its meshes side by side, and their worst values.
fn table_of_impacts(cells: &[Cell]) -> String {
    let mut text = "| impact | speed | deflection by mesh [mm] | energy error | contact loss | smallest J | penetration, of a face | time |\n".to_owned();
    text += "|---|---|---|---|---|---|---|---|\n";
    let speed = |cell: &Cell| cell.value.split(',').next().unwrap_or_default().to_owned();
    for meshes in cells.chunk_by(|a, b| a.axis == b.axis && speed(a) == speed(b)) {
        let deflection = |cell: &Cell| match cell.verdict {
            Verdict::Finished => format!("{:.2}", 1e3 * cell.deflection_m),
            _ => format!("{} at {:.0} %", cell.ending.replace('_', " "), 100.0 * cell.reached),
        };
        let worst = |of: fn(&Cell) -> f64| meshes.iter().map(of).fold(0.0, f64::max);
        let least = meshes.iter().map(|cell| cell.smallest_jacobian).fold(f64::INFINITY, f64::min);
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.1e} | {:.1} % | {least:.3} | {:.1e} | {:.1} s |",
            meshes[0].axis,
            speed(&meshes[0]),
            meshes.iter().map(deflection).collect::<Vec<_>>().join(" · "),
            worst(|cell| cell.balance_error),
            100.0 * worst(|cell| cell.contact_loss),
            worst(|cell| cell.face_penetration),
            meshes.iter().map(|cell| cell.wall_s).sum::<f64>()
        );
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
        let study = study_stability(&cases, &steppings, 1, &stop, &mut |_| {});
        let text = markdown(&study, cases.len() * steppings.len(), table_of_cells);
        let missing = format!("{} of {} cells are missing", cases.len() - 1, cases.len());
        assert!(text.starts_with("STOPPED (cancelled)") && text.contains(&missing), "{text}");
        assert!(text.contains("it was stopped by hand. Remedy: let it finish"), "{text}");
    }
}
