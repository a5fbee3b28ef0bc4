//! VTK files of unstructured grids: legacy `.vtk` and XML `.vtu` ("VTK File Formats", kitware). Both give a [`grid::Grid`],
//! whose cells and arrays become a mesh with parts and sets.

mod cell_type;
mod compression;
mod grid;
mod labels;
mod legacy;
mod legacy_arrays;
mod scalar;
mod stream;
mod text;
mod unstructured;

#[cfg(test)]
mod tests;

use super::FieldNames;
use crate::mesh::{Mesh, MeshError};

/// Reads a legacy `.vtk` file.
///
/// # Errors
/// As [`super::read_mesh`].
pub(super) fn read_legacy(bytes: &[u8], fields: &FieldNames) -> Result<Mesh, MeshError> {
    legacy::read(bytes, fields)
}

/// Whether a legacy file is one of text, as its third line says.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    bytes
        .split(|byte| *byte == b'\n')
        .nth(2)
        .is_some_and(|line| line.trim_ascii().eq_ignore_ascii_case(b"ASCII"))
}

/// Reads a `.vtu` file.
///
/// # Errors
/// As [`super::read_mesh`].
pub(super) fn read_unstructured(bytes: &[u8], fields: &FieldNames) -> Result<Mesh, MeshError> {
    unstructured::read(bytes, fields)
}
