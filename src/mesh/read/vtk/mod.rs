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

use crate::mesh::{Mesh, MeshError};

/// Reads a legacy `.vtk` file.
///
/// # Errors
/// Those of [`super::read_mesh`].
pub(super) fn read_legacy(bytes: &[u8]) -> Result<Mesh, MeshError> {
    legacy::read(bytes)
}

/// Reads a `.vtu` file.
///
/// # Errors
/// Those of [`super::read_mesh`].
pub(super) fn read_unstructured(bytes: &[u8]) -> Result<Mesh, MeshError> {
    unstructured::read(bytes)
}
