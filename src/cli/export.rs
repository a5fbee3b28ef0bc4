//! `contuse export`: a recorded run in other formats.

use super::output_file::{check_writable, write_file};
use super::recording_output::check_series;
use super::report::read;
use super::{CliError, Exit};
use crate::record::RecordError;
use crate::record::vtk::Folder;
use crate::report::fields::write_series;
use crate::report::surface::{Surfaces, surfaces_at, write_ply, write_stl};
use crate::report::{ReadError, csv, fhir};
use clap::Args;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Arguments of `contuse export`.
#[derive(Args, Debug)]
#[command(group = clap::ArgGroup::new("format").required(true).multiple(true))]
#[command(group = clap::ArgGroup::new("surface").multiple(true))]
pub struct ExportArgs {
    /// Recording to export (.mcap).
    pub recording: PathBuf,
    /// Write a FHIR R4 bundle (JSON).
    #[arg(long, value_name = "FILE", group = "format")]
    pub fhir: Option<PathBuf>,
    /// Write force, patch area and energies over time.
    #[arg(long, value_name = "FILE", group = "format")]
    pub csv: Option<PathBuf>,
    /// Write the fields for ParaView and PyVista: a series of VTK files (.pvd, with a folder of .vtu files).
    #[arg(long, value_name = "FILE", group = "format")]
    pub vtu: Option<PathBuf>,
    /// Write the deformed surfaces of the bodies as binary STL, in metres.
    #[arg(long, value_name = "FILE", groups = ["format", "surface"])]
    pub stl: Option<PathBuf>,
    /// Write the deformed surfaces of the bodies as binary PLY, in metres.
    #[arg(long, value_name = "FILE", groups = ["format", "surface"])]
    pub ply: Option<PathBuf>,
    /// Time of the surfaces in milliseconds; the nearest field time is taken [default: the last].
    #[arg(long, value_name = "MS", requires = "surface", allow_negative_numbers = true)]
    pub at_ms: Option<f64>,
    /// Body of the surfaces [default: all].
    #[arg(long, value_name = "NAME", requires = "surface")]
    pub body: Option<String>,
}

/// Writes the requested exports.
///
/// # Errors
/// The errors in the recording, or why a file cannot be written.
pub fn export(args: &ExportArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    args.fhir.iter().try_for_each(|path| check_writable(path, "--fhir"))?;
    args.csv.iter().try_for_each(|path| check_writable(path, "--csv"))?;
    args.stl.iter().try_for_each(|path| check_writable(path, "--stl"))?;
    args.ply.iter().try_for_each(|path| check_writable(path, "--ply"))?;
    args.vtu.iter().try_for_each(|path| check_series(path, "--vtu"))?;
    if args.fhir.is_some() || args.csv.is_some() {
        export_numbers(args, out)?;
    }
    if let Some(path) = &args.vtu {
        let recording = open(&args.recording)?;
        let place = Folder::create(path).map_err(|error| CliError::Other(Box::new(error)))?;
        let times = write_series(recording, &args.recording, place);
        let times = times.map_err(|error| failed(error, &args.recording))?;
        writeln!(out, "{}: {times} times", path.display())?;
    }
    if args.stl.is_some() || args.ply.is_some() {
        export_surfaces(args, out)?;
    }
    Ok(Exit::Success)
}

/// Writes what the summary and the time series say.
fn export_numbers(args: &ExportArgs, out: &mut dyn Write) -> Result<(), CliError> {
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
    Ok(())
}

/// Writes surfaces to a file.
type Writer = fn(&Surfaces, &mut dyn Write) -> std::io::Result<()>;

/// Writes the deformed surfaces.
fn export_surfaces(args: &ExportArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let time_s = args.at_ms.map(|ms| 1e-3 * ms);
    let surfaces = surfaces_at(open(&args.recording)?, &args.recording, time_s);
    let mut surfaces = surfaces.map_err(|error| failed(error, &args.recording))?;
    if let Some(name) = &args.body {
        let known: Vec<String> = surfaces.bodies.iter().map(|body| body.name.clone()).collect();
        surfaces.bodies.retain(|body| body.name == *name);
        if surfaces.bodies.is_empty() {
            let known = known.join(", ");
            return Err(CliError::Usage(format!("--body {name}: there is no such body; there are {known}")));
        }
    }
    let files: [(&Option<PathBuf>, Writer); 2] = [(&args.stl, write_stl), (&args.ply, write_ply)];
    for (path, write) in files.into_iter().filter_map(|(path, write)| Some((path.as_ref()?, write))) {
        write_file(path, |file| write(&surfaces, file))?;
        writeln!(out, "{}: at {} ms", path.display(), 1e3 * surfaces.time_s)?;
    }
    Ok(())
}

fn open(path: &Path) -> Result<File, CliError> {
    File::open(path).map_err(|source| CliError::Input { path: path.to_owned(), source })
}

/// Error of an export: of the recording, or of a file that cannot be written.
fn failed(error: ReadError, recording: &Path) -> CliError {
    match &error {
        ReadError::Fields(RecordError::File { path, .. }) if path != recording => {
            CliError::Other(Box::new(error))
        }
        _ => CliError::Usage(error.to_string()),
    }
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
