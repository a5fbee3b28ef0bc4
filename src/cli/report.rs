//! `contuse report` and `contuse export`: reports and exports of a recorded run.

use super::output_file::{check_writable, write_file};
use super::run::{available_threads, read_scene, watch_for_ctrl_c};
use super::{CliError, Exit};
use crate::record::{McapRecorder, RecordingInfo};
use crate::report::{RecordedRun, csv, fhir, html};
use crate::step::Interrupt;
use crate::study::{RunRequest, run_scene};
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{SystemTime, UNIX_EPOCH};

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

/// Arguments of `contuse export`.
#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("format").required(true).multiple(true))]
pub struct ExportArgs {
    /// Recording to export (.mcap).
    pub recording: PathBuf,
    /// Write a FHIR R4 bundle (JSON).
    #[arg(long, value_name = "FILE", group = "format")]
    pub fhir: Option<PathBuf>,
    /// Write force, patch area and energies over time.
    #[arg(long, value_name = "FILE", group = "format")]
    pub csv: Option<PathBuf>,
}

/// Writes a report.
///
/// # Errors
/// The errors in the scene or the recording, or why the page cannot be written.
pub fn report(args: &ReportArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    check_writable(&args.output, "--output (-o)")?;
    let is_scene = args.input.extension().is_some_and(|extension| extension == "json");
    let run = if is_scene { run_for_report(args)? } else { read(&args.input)? };
    let page = html::page(&run).map_err(CliError::Picture)?;
    write_file(&args.output, |file| file.write_all(page.as_bytes()))?;
    writeln!(out, "{}", args.output.display())?;
    Ok(Exit::Success)
}

/// Runs a scene into a temporary recording, which is read back and removed.
fn run_for_report(args: &ReportArgs) -> Result<RecordedRun, CliError> {
    refuse_summary(&args.input)?;
    let (document_json, loaded) = read_scene(&args.input)?;
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

fn read(path: &Path) -> Result<RecordedRun, CliError> {
    RecordedRun::read(path).map_err(|error| CliError::Usage(error.to_string()))
}

/// Writes the requested exports.
///
/// # Errors
/// The errors in the recording, or why a file cannot be written.
pub fn export(args: &ExportArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    args.fhir.iter().try_for_each(|path| check_writable(path, "--fhir"))?;
    args.csv.iter().try_for_each(|path| check_writable(path, "--csv"))?;
    let run = read(&args.recording)?;
    if let Some(path) = &args.fhir {
        let bundle = fhir::bundle(&run, &now());
        let text = serde_json::to_string_pretty(&bundle).map_err(|error| CliError::Other(Box::new(error)))?;
        write_file(path, |file| writeln!(file, "{text}"))?;
        writeln!(out, "{}", path.display())?;
    }
    if let Some(path) = &args.csv {
        write_file(path, |file| csv::write(&run, file))?;
        writeln!(out, "{}", path.display())?;
    }
    Ok(Exit::Success)
}

/// Current time, RFC 3339.
fn now() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    rfc_3339(since)
}

/// Formats seconds since 1970 as a date: civil calendar from a day count (Hinnant).
fn rfc_3339(seconds: u64) -> String {
    let (days, of_day) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let era = days / 146_097;
    let of_era = days % 146_097;
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(rfc_3339(0), "1970-01-01T00:00:00Z");
        assert_eq!(rfc_3339(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(rfc_3339(1_709_251_199), "2024-02-29T23:59:59Z");
        assert_eq!(rfc_3339(4_102_444_800), "2100-01-01T00:00:00Z");
    }
}
