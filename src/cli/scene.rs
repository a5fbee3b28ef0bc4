//! `contuse scene from`: a first scene of a mesh file, of a scan, or of closed surfaces.

use super::mesh_file::{
    is_febio, is_scan, is_surface, read_febio_file, read_mesh_file, read_scan_file, read_surface_file,
};
use super::output_file::write_file;
use super::{CliError, Exit};
use crate::mesh::read::febio::NOT_READ;
use crate::scene::febio::UnitSystem;
use crate::scene::first_scene::{first_scene, first_scene_of_scan};
use crate::scene::first_surfaces::{Nest, SurfaceFile};
use clap::{Args, Subcommand};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Subcommands on scene documents.
#[derive(Debug, Subcommand)]
pub enum SceneCommand {
    /// Write a first scene from a mesh file, a scan or surfaces: bodies, parts and sets with guessed roles; from a FEBio file also materials, conditions,
    /// loads and contact. What cannot be guessed is left blank, and `contuse validate` names it.
    From(FromArgs),
}

/// Arguments of `contuse scene from`.
#[derive(Args, Debug)]
pub struct FromArgs {
    /// Mesh file: .msh, .inp, .vtk, .vtu, .k, .feb or .bdf; a scan with labels: .nii, .nii.gz, .nrrd or .mha; or nested
    /// closed surfaces: one or more .stl.
    #[arg(required = true, value_name = "MESH")]
    pub meshes: Vec<PathBuf>,
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
    let [mesh, others @ ..] = args.meshes.as_slice() else {
        return Err(CliError::Usage("name a mesh file".into()));
    };
    if let Some(output) = &args.output {
        args.meshes.iter().try_for_each(|mesh| check_folder(output, mesh))?;
    }
    if let Some(other) = args.meshes.iter().find(|file| !others.is_empty() && !is_surface(file)) {
        let message =
            format!("{}: a scene is begun of one file, or of several surfaces (.stl)", other.display());
        return Err(CliError::Usage(message));
    }
    if let Some(other) = others.iter().find(|other| folder(other) != folder(mesh)) {
        let [mesh, other] = [mesh, other].map(|file| file.display());
        let message =
            format!("{other} is not in the folder of {mesh}: a scene reads files of its own folder");
        return Err(CliError::Usage(message));
    }
    if args.units.is_some() && !is_febio(mesh) {
        let scale = "the scale of \"placement\" makes metres of the lengths of other files";
        return Err(CliError::Usage(format!("--units is for FEBio files (.feb): {scale}")));
    }
    let (document, notes) = if is_febio(mesh) {
        let (mesh, scene) = read_febio_file(mesh, args.units)?;
        let is_of_sections = |note: &String| !note.starts_with(NOT_READ);
        (scene?, mesh.notes.into_iter().filter(is_of_sections).collect())
    } else if is_scan(mesh) {
        let (volume, name) = read_scan_file(mesh)?;
        (first_scene_of_scan(&volume, &name), volume.notes)
    } else if is_surface(mesh) {
        let read = |file: &PathBuf| {
            let (surface, name) = read_surface_file(file)?;
            Ok::<_, CliError>(SurfaceFile { file: name.clone(), name, surface })
        };
        let surfaces = args.meshes.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        (Nest::of(&surfaces).first_scene(), Vec::new())
    } else {
        let (mesh, name) = read_mesh_file(mesh)?;
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

/// The folder of a file, if there is one.
fn folder(path: &Path) -> Option<PathBuf> {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    parent.canonicalize().ok()
}

/// Refuses a scene outside the folder of its mesh, which it could not read, and one that exists.
fn check_folder(scene: &Path, mesh: &Path) -> Result<(), CliError> {
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
