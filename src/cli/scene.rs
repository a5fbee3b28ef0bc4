//! `contuse scene from`: a first scene of a mesh file.

use super::mesh_file::{is_febio, is_scan, read_febio_file, read_mesh_file, read_scan_file};
use super::output_file::write_file;
use super::{CliError, Exit};
use crate::mesh::read::febio::NOT_READ;
use crate::scene::febio::UnitSystem;
use crate::scene::first_scene::{first_scene, first_scene_of_scan};
use clap::{Args, Subcommand};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Subcommands on scene documents.
#[derive(Debug, Subcommand)]
pub enum SceneCommand {
    /// Write a first scene of a mesh file or a scan: bodies, parts and sets with guessed roles; of a FEBio file also materials, conditions,
    /// loads and contact. What only you know is left open, and `contuse validate` names it.
    From(FromArgs),
}

/// Arguments of `contuse scene from`.
#[derive(Args, Debug)]
pub struct FromArgs {
    /// Mesh file: .msh, .inp, .vtk, .vtu, .k, .feb or .bdf; or a scan with labels: .nii, .nii.gz, .nrrd or .mha.
    pub mesh: PathBuf,
    /// Scene to write, in the folder of the mesh [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Units of the numbers of a FEBio file that names none: SI, mm-N-s, mm-kg-s, um-nN-s, CGS, mm-g-s or mm-mg-s.
    #[arg(long, value_name = "SYSTEM")]
    pub units: Option<UnitSystem>,
}

/// Executes a command on scene documents.
///
/// # Errors
/// Why a file cannot be read or written.
pub fn scene(command: &SceneCommand, out: &mut dyn Write) -> Result<Exit, CliError> {
    let SceneCommand::From(args) = command;
    if let Some(output) = &args.output {
        check_folder(output, &args.mesh)?;
    }
    if args.units.is_some() && !is_febio(&args.mesh) {
        let scale = "the scale of \"placement\" makes metres of the lengths of other files";
        return Err(CliError::Usage(format!("--units is for FEBio files (.feb): {scale}")));
    }
    let (document, notes) = if is_febio(&args.mesh) {
        let (mesh, scene) = read_febio_file(&args.mesh, args.units)?;
        let is_of_sections = |note: &String| !note.starts_with(NOT_READ);
        (scene?, mesh.notes.into_iter().filter(is_of_sections).collect())
    } else if is_scan(&args.mesh) {
        let (volume, name) = read_scan_file(&args.mesh)?;
        (first_scene_of_scan(&volume, &name), volume.notes)
    } else {
        let (mesh, name) = read_mesh_file(&args.mesh)?;
        (first_scene(&mesh, &name), mesh.notes)
    };
    for note in &notes {
        eprintln!("note: {note}");
    }
    match &args.output {
        Some(output) => write_file(output, |file| writeln!(file, "{document:#}"))?,
        None => writeln!(out, "{document:#}")?,
    }
    Ok(Exit::Success)
}

/// Refuses a scene outside the folder of its mesh, which it could not read, and one that exists.
fn check_folder(scene: &Path, mesh: &Path) -> Result<(), CliError> {
    let folder = |path: &Path| {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        parent.canonicalize().ok()
    };
    if scene.exists() {
        return Err(CliError::Usage(format!("{} exists: name another file with -o", scene.display())));
    }
    if folder(scene) == folder(mesh) {
        return Ok(());
    }
    Err(CliError::Usage(format!(
        "{} is not in the folder of {}: a scene reads meshes of its own folder; write it there with -o",
        scene.display(),
        mesh.display()
    )))
}
