//! Series of VTK files for ParaView and PyVista: `.vtu` files, one a body and time, listed by a `.pvd` file.
//!
//! An [`Assembler`] makes [`Block`]s from the messages of a recording; a [`Series`] writes them to a [`Folder`] or an
//! [`Archive`]. [`VtuRecorder`] gives it the messages of a run. The formats are those of the VTK File Formats
//! documentation, version 1.0 with headers of `UInt32`.

mod array;
mod assemble;
mod block;
mod body;
mod contact;
mod folder;
mod grid;
mod mesh_file;
mod packed_data;
mod recorder;
mod rigid;
mod series;
mod tar;
#[cfg(test)]
mod tests;

pub use array::{Array, NumberType};
pub use assemble::Assembler;
pub use block::{Block, BlockSurface, Blocks};
pub use folder::{Folder, folder_of};
pub use grid::{CellArrays, FieldValue, Grid};
pub use mesh_file::write_vtu;
pub use recorder::VtuRecorder;
pub use series::{Place, Series};
pub use tar::Archive;

/// Name of the folder of a series called `name`.
fn folder_name(name: &str) -> String {
    format!("{name}_vtu")
}
