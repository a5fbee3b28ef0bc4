//! `contuse study bulk-modulus`: what a lower bulk modulus changes, and saves.

use super::json::write_json;
use super::plan::{duration, write_table};
use super::run::{announce, available_threads, exit_of_study, read_scene, watch_for_ctrl_c};
use super::{CliError, Exit};
use crate::measure::QuantityOfInterest;
use crate::scene::{Budget, FolderSource};
use crate::step::Interrupt;
use crate::study::bulk_modulus::{BulkRequest, BulkStudy, FACTORS, study_bulk_modulus};
use crate::study::error::{Row, TARGETS};
use clap::Args;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Arguments of `contuse study bulk-modulus`.
#[derive(Args, Debug)]
pub struct BulkModulusArgs {
    /// Scene document; its mesh files are in the same folder.
    pub scene: PathBuf,
    /// Factors on the bulk moduli of the scene. Water has 2.2 GPa: 44 times 50 MPa.
    #[arg(long, value_delimiter = ',', default_values_t = [0.25, 0.5, 1.0, 2.0, 4.0], value_parser = factor)]
    pub factors: Vec<f64>,
    /// Threads of each run; all cores by default.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
}

fn factor(text: &str) -> Result<f64, String> {
    let factor: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let [low, high] = FACTORS;
    if (low..=high).contains(&factor) { Ok(factor) } else { Err(format!("must be between {low} and {high}")) }
}

/// Runs the study. Exit code 3 if no run finished, 4 if it was stopped.
///
/// # Errors
/// Errors in the scene or the flags.
pub fn bulk_modulus(args: &BulkModulusArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let (_, loaded) = read_scene(&args.scene)?;
    loaded.warnings.iter().for_each(|warning| eprintln!("{warning}"));
    let folder = args.scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let cancelled = watch_for_ctrl_c()?;
    let study = study_bulk_modulus(&mut BulkRequest {
        document: &loaded.scene.document,
        source: &FolderSource::new(folder),
        budget: &Budget::COMMAND_LINE,
        factors: &args.factors,
        threads: args.threads.map_or_else(available_threads, usize::from),
        interrupt: &|| cancelled.load(Ordering::Relaxed).then_some(Interrupt::Cancel),
        progress: &mut |number, count, setting| announce(number, count, &setting.name()),
    });
    if args.json {
        write_json(&study, out)?;
    } else {
        write_study(&study, out)?;
    }
    Ok(exit_of_study(study.stopped.as_ref(), &study.rows))
}

fn write_study(study: &BulkStudy, out: &mut dyn Write) -> io::Result<()> {
    let quantities: Vec<QuantityOfInterest> = study.smallest.keys().copied().collect();
    writeln!(
        out,
        "{}: results on one mesh, and their difference from the largest bulk modulus\n",
        study.scene
    )?;
    let mut header = vec!["bulk modulus".to_owned(), "steps".into(), "processor".into()];
    header.extend(quantities.iter().map(|q| format!("{} [{}]", q.short_title(), q.unit())));
    let cells = |row: &Row| {
        let mut cells =
            vec![format!("× {}", row.setting.bulk_factor), row.steps.to_string(), duration(row.cost_s())];
        cells.extend(quantities.iter().map(|q| match (row.values.get(q), row.errors.get(q)) {
            (Some(value), Some(change)) => format!("{value:.4} ({:+.1} %)", 100.0 * change),
            (Some(value), None) => format!("{value:.4}"),
            (None, _) if row.is_finished() => "–".to_owned(),
            (None, _) => row.ending.replace('_', " "),
        }));
        cells
    };
    write_table(&header, &study.rows.iter().map(cells).collect::<Vec<_>>(), out)?;
    for row in study.rows.iter().filter(|row| row.reason.is_some()) {
        writeln!(out, "\n{}: {}", row.name, row.reason.as_deref().unwrap_or_default())?;
    }
    writeln!(out, "\nSmallest bulk modulus within a difference, of those below the largest:")?;
    let mut header = vec![String::new()];
    header.extend(TARGETS.map(|target| format!("{} %", 100.0 * target)));
    let cells = |q: &QuantityOfInterest| {
        let of =
            |factor: &Option<f64>| factor.map_or_else(|| "none".to_owned(), |factor| format!("× {factor}"));
        std::iter::once(q.short_title().to_owned()).chain(study.smallest[q].iter().map(of)).collect()
    };
    write_table(&header, &quantities.iter().map(cells).collect::<Vec<Vec<String>>>(), out)
}
