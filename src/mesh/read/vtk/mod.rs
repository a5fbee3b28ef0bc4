//! VTK files of unstructured grids: legacy `.vtk` and XML `.vtu` ("VTK File Formats", kitware). Both give a [`grid::Grid`],
//! whose cells and arrays become a mesh with parts and sets.

mod cell_type;
mod compression;
mod grid;
mod labels;
pub(super) mod legacy;
mod scalar;
mod stream;
pub(super) mod unstructured;

#[cfg(test)]
mod tests;
