//! `contuse study`: studies that run a scene many times.

use super::json::write_json;
use super::keep::KeepArgs;
use super::plan::{bytes, duration, write_table};
use super::run::{announce, available_threads, read_scene, watch_for_ctrl_c};
use super::{CliError, Exit};
use crate::scene::document::Keep;
use crate::step::Interrupt;
use crate::study::{
    ASYMMETRY, Difference, OmissionsRequest, OmissionsRow, OmissionsStudy, Theory, study_omissions,
};
use clap::{Args, Subcommand};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Studies of many runs.
#[derive(Debug, Subcommand)]
pub enum StudyCommand {
    /// Savings of omitted computations, and proof that they change no bit: everything omitted, then each item restored.
    Omissions(OmissionsArgs),
    /// Error against run time: cost and error of meshes, formulations, steps and tolerances.
    Error(super::study_error::ErrorArgs),
    /// Stability on stiff and extreme cases: a matrix of small impacts, each of which finishes or is diagnosed.
    Stability(super::study_stability::StabilityArgs),
    /// Bulk modulus: what a lower one than that of water changes, and saves, on one mesh.
    BulkModulus(super::study_bulk_modulus::BulkModulusArgs),
    /// Coverage of the error bars: scenes with exact solutions over meshes, speeds, steps and integrators.
    Coverage(super::study_coverage::CoverageArgs),
}

/// Arguments of `contuse study omissions`.
#[derive(Args, Debug)]
pub struct OmissionsArgs {
    /// Scene document; its mesh files are in the same folder.
    pub scene: PathBuf,
    /// Number of runs of each kind, interleaved; their median counts.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeat: u32,
    /// Threads of each run; all cores by default.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
    /// Items restored in every run, and not studied.
    #[command(flatten)]
    pub keep: KeepArgs,
}

/// Runs a study. Exit code 0 if every run agrees with the theory; 3 if the scene itself fails, 1 if a run differs.
///
/// # Errors
/// Errors in the scene or the flags.
pub fn study(command: &StudyCommand, out: &mut dyn Write) -> Result<Exit, CliError> {
    match command {
        StudyCommand::Omissions(args) => omissions(args, out),
        StudyCommand::Stability(args) => super::study_stability::stability(args, out),
        StudyCommand::BulkModulus(args) => super::study_bulk_modulus::bulk_modulus(args, out),
        StudyCommand::Coverage(args) => super::study_coverage::coverage(args, out),
        StudyCommand::Error(args) => super::study_error::error(args, out),
    }
}

fn omissions(args: &OmissionsArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let (document_json, mut loaded) = read_scene(&args.scene)?;
    loaded.warnings.iter().for_each(|warning| eprintln!("{warning}"));
    loaded.scene.restore(&args.keep.keep);
    let cancelled = watch_for_ctrl_c()?;
    // Recorded as by `contuse run`, so that the times are representative.
    let recording = std::env::temp_dir().join(format!("contuse-study-{}.mcap", std::process::id()));
    let studied = study_omissions(&mut OmissionsRequest {
        scene: &loaded.scene,
        document_json: &document_json,
        repeat: args.repeat,
        threads: args.threads.map_or_else(available_threads, usize::from),
        recording: Some(&recording),
        interrupt: &|| cancelled.load(Ordering::Relaxed).then_some(Interrupt::Cancel),
        progress: &mut |number, count, restored| announce(number, count, &kind_name(restored)),
    });
    remove(&recording)?;
    let study = studied.map_err(|error| CliError::Other(Box::new(error)))?;
    if args.json {
        write_json(&study, out)?;
    } else {
        write_study(&study, out)?;
    }
    Ok(exit_of(&study))
}

/// Removes the last recording; there may be none, and that of a failed run has another name.
fn remove(recording: &Path) -> Result<(), CliError> {
    for path in [recording.to_owned(), crate::record::partial_path(recording)] {
        if path.exists() {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}

fn exit_of(study: &OmissionsStudy) -> Exit {
    let ended = |name: &str| study.rows.iter().any(|row| row.ending == name);
    if study.holds {
        Exit::Success
    } else if ended("cancelled") {
        Exit::Cancelled
    } else if study.rows.first().is_some_and(|row| row.ending != "finished") {
        Exit::RunFailed
    } else {
        Exit::Unexpected
    }
}

fn kind_name(restored: &[Keep]) -> String {
    match restored {
        [] => "all omitted".into(),
        [keep] => format!("+ {keep}"),
        _ => "+ all of them".into(),
    }
}

fn write_study(study: &OmissionsStudy, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "{}: {} elements, {} thread(s), median of {} run(s) each\n",
        study.scene, study.elements, study.threads, study.repeat
    )?;
    let header =
        ["restored", "element-steps", "wall", "processor", "memory", "recording", "difference", "theory", ""];
    let rows: Vec<[String; 9]> = study.rows.iter().map(cells).collect();
    write_table(&header, &rows, out)?;
    writeln!(out)?;
    if study.holds {
        writeln!(out, "every run is as theory says: omission changes no result")
    } else {
        writeln!(out, "NOT as theory says: omission must change no result of a run that finishes")
    }
}

fn cells(row: &OmissionsRow) -> [String; 9] {
    let none = || "-".to_owned();
    let difference = match &row.difference {
        Difference::Bitwise => "bitwise equal".to_owned(),
        Difference::Rounding { largest_relative, quantity } => format!("{largest_relative:.1e} ({quantity})"),
    };
    let verdict = if row.holds { String::new() } else { format!("VIOLATED ({})", row.ending) };
    [
        kind_name(&row.restored),
        row.element_steps.to_string(),
        duration(row.wall_s),
        row.cpu_s.map_or_else(none, duration),
        bytes(row.memory_bytes),
        row.recording_bytes.map_or_else(none, bytes),
        difference,
        match row.theory {
            Theory::Bitwise => "bitwise".into(),
            Theory::Symmetric => format!("within {:.0} %", 100.0 * ASYMMETRY),
        },
        verdict,
    ]
}
