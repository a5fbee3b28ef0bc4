//! Mesh files named on the command line.

use super::CliError;
use crate::mesh::Mesh;
use crate::mesh::read::stl::ClosedSurface;
use crate::mesh::read::{FieldNames, MeshFormat};
use crate::mesh::segmentation::LabelVolume;
use crate::scene::build::read_file;
use crate::scene::febio::{UnitSystem, read_febio};
use crate::scene::problem::Pointer;
use crate::scene::segmentation_source::{read_scan, read_surface};
use crate::scene::{Budget, FolderSource, Problems};
use serde_json::Value;
use std::path::Path;

/// The labels of a scan, and the name of its file without its folder.
pub(super) fn read_scan_file(path: &Path) -> Result<(LabelVolume, String), CliError> {
    let (source, name) = source_of(path);
    let read = read_scan(&source, &name, Budget::COMMAND_LINE.mesh_bytes, &Pointer::root());
    let (volume, _) = read.map_err(crate::scene::Problem::alone)?;
    Ok((volume, name))
}

/// The closed surface of a file, and the name of the file without its folder.
pub(super) fn read_surface_file(path: &Path) -> Result<(ClosedSurface, String), CliError> {
    let (source, name) = source_of(path);
    let read = read_surface(&source, &name, Budget::COMMAND_LINE.mesh_bytes, &Pointer::root());
    let (surface, _) = read.map_err(crate::scene::Problem::alone)?;
    Ok((surface, name))
}

/// The format that the name of a file says.
fn format_of(path: &Path) -> Option<MeshFormat> {
    MeshFormat::from_name(&path.file_name()?.to_string_lossy())
}

/// Whether a file is a closed surface, by its name.
pub(super) fn is_surface(path: &Path) -> bool {
    format_of(path) == Some(MeshFormat::Stl)
}

/// Whether a file is a scan, by its name.
pub(super) fn is_scan(path: &Path) -> bool {
    format_of(path).and_then(MeshFormat::volume).is_some()
}

/// Whether a file is one of FEBio, by its name.
pub(super) fn is_febio(path: &Path) -> bool {
    format_of(path) == Some(MeshFormat::Febio)
}

/// The mesh of a FEBio file, and a scene of it, or the parts of the file without a counterpart in a scene.
pub(super) fn read_febio_file(
    path: &Path,
    units: Option<UnitSystem>,
) -> Result<(Mesh, Result<Value, Problems>), CliError> {
    let (source, name) = source_of(path);
    let read = read_febio(&source, (&name, Budget::COMMAND_LINE.mesh_bytes), units);
    Ok(read.map_err(crate::scene::Problem::alone)?)
}

/// The folder and the name of a file.
fn source_of(path: &Path) -> (FolderSource, String) {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    (FolderSource::new(folder), name)
}

/// The mesh of a file, and the name of the file without its folder; files that it includes are in the same folder.
pub(super) fn read_mesh_file(path: &Path) -> Result<(Mesh, String), CliError> {
    read_mesh_and_fields(path, &FieldNames::NONE)
}

/// The mesh of a file with the requested arrays of its elements.
pub(super) fn read_mesh_and_fields(path: &Path, fields: &FieldNames) -> Result<(Mesh, String), CliError> {
    let (source, name) = source_of(path);
    let read = read_file(&source, (&name, fields), Budget::COMMAND_LINE.mesh_bytes, &Pointer::root());
    let (mesh, _) = read.map_err(crate::scene::Problem::alone)?;
    Ok((mesh, name))
}
