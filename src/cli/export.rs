//! `contuse export`: a recorded run in other formats.

use super::output_file::{CSV, FHIR, PLY, STL, check_distinct, check_output, write_file};
use super::recording_output::check_series;
use super::report::read;
use super::{CliError, Exit};
use crate::record::RecordError;
use crate::record::vtk::Folder;
use crate::report::date::now;
use crate::report::fields::write_series;
use crate::report::surface::{Surfaces, surfaces_at, write_ply, write_stl};
use crate::report::{ReadError, csv, fhir};
use clap::Args;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

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
    let kinds = [
        (&args.fhir, &FHIR, "--fhir"),
        (&args.csv, &CSV, "--csv"),
        (&args.stl, &STL, "--stl"),
        (&args.ply, &PLY, "--ply"),
    ];
    check_distinct(
        [&args.recording].into_iter().chain(kinds.iter().flat_map(|(path, ..)| *path)).chain(&args.vtu),
    )?;
    for (path, kind, flag) in kinds {
        path.iter().try_for_each(|path| check_output(path, kind, flag))?;
    }
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
        let bundle = fhir::bundle(&run, &now(), None);
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
        // As many digits as single precision has.
        writeln!(out, "{}: at {} ms", path.display(), (1e3 * surfaces.time_s) as f32)?;
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
