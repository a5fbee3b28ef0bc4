//! `contuse report`: a report on a recorded run.

use super::output_file::{REPORT, check_output, write_file};
use super::run::{available_threads, read_scene, watch_for_ctrl_c};
use super::{CliError, Exit};
use crate::record::{McapRecorder, RecordingInfo};
use crate::report::{RecordedRun, html};
use crate::step::Interrupt;
use crate::study::{RunRequest, run_scene};
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Arguments of `contuse report`.
#[derive(Args, Debug)]
pub struct ReportArgs {
    /// Recording (.mcap), or scene document to run for the report.
    pub input: PathBuf,
    /// HTML page to write.
    #[arg(short, long, default_value = "report.html")]
    pub output: PathBuf,
    /// Threads of the run of a scene; all cores by default.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// Writes a report.
///
/// # Errors
/// The errors in the scene or the recording, or why the page cannot be written.
pub fn report(args: &ReportArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    check_output(&args.output, &REPORT, "--output (-o)")?;
    let is_scene = args.input.extension().is_some_and(|extension| extension == "json");
    let run = if is_scene { run_for_report(args)? } else { read(&args.input)? };
    let page = html::page(&run, &html::Origin::default()).map_err(CliError::Picture)?;
    write_file(&args.output, |file| file.write_all(page.as_bytes()))?;
    writeln!(out, "{}", args.output.display())?;
    Ok(Exit::Success)
}

/// Runs a scene into a temporary recording, which is read back and removed.
fn run_for_report(args: &ReportArgs) -> Result<RecordedRun, CliError> {
    refuse_summary(&args.input)?;
    let (document_json, mut loaded) = read_scene(&args.input)?;
    loaded.scene.document.imply_accuracy();
    loaded.warnings.iter().for_each(|warning| eprintln!("{warning}"));
    let recording = std::env::temp_dir().join(format!("contuse-report-{}.mcap", std::process::id()));
    let cancelled = watch_for_ctrl_c()?;
    let info = RecordingInfo::of(&loaded.scene, &document_json);
    let mut recorder = McapRecorder::new(&recording, info);
    let result = run_scene(RunRequest {
        scene: &loaded.scene,
        sinks: vec![&mut recorder],
        also: None,
        threads: args.threads.map_or_else(available_threads, usize::from),
        interrupt: &|| cancelled.load(Ordering::Relaxed).then_some(Interrupt::Cancel),
        progress: &mut |_| {},
    });
    let run = result.map_err(|error| CliError::Other(Box::new(error))).and_then(|_| read(&recording));
    // The file may be missing if the run could not begin.
    let _ = std::fs::remove_file(&recording);
    run
}

/// Rejects a summary, which is not a scene.
fn refuse_summary(path: &Path) -> Result<(), CliError> {
    let bytes = std::fs::read(path).map_err(|source| CliError::Input { path: path.to_owned(), source })?;
    let document: serde_json::Value = serde_json::from_slice(&bytes).unwrap_or_default();
    if document.get("engine_version").is_some() && document.get("bodies").is_none() {
        return Err(CliError::Usage(format!(
            "{} is the summary of a run, not a scene: report on the recording of that run (.mcap)",
            path.display()
        )));
    }
    Ok(())
}

/// Reads a recording; one that cannot be read is an error of usage.
pub(super) fn read(path: &Path) -> Result<RecordedRun, CliError> {
    RecordedRun::read(path).map_err(|error| CliError::Usage(error.to_string()))
}
