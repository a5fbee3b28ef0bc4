//! Mesh files named on the command line.

use super::CliError;
use crate::mesh::Mesh;
use crate::scene::build::read_file;
use crate::scene::problem::Pointer;
use crate::scene::{Budget, FolderSource};
use std::path::Path;

/// The mesh of a file, and the name of the file without its folder; files that it includes are in the same folder.
pub(super) fn read_mesh_file(path: &Path) -> Result<(Mesh, String), CliError> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let source = FolderSource::new(folder);
    let read = read_file(&source, &name, Budget::COMMAND_LINE.mesh_bytes, &Pointer::root());
    let (mesh, _) = read.map_err(crate::scene::Problem::alone)?;
    Ok((mesh, name))
}
