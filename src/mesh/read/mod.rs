//! Mesh files: Gmsh `.msh` (2.2 and 4.1, ASCII and binary) and Abaqus `.inp`.
//!
//! The readers take bytes from anywhere, trust none of them, and fail with the line or the byte where a file goes wrong.
//! Volumes may be of any kind of [`CellKind`](super::CellKind), mixed in one file. Named groups of volume elements become parts, groups of anything else node sets.

mod abaqus;
mod assembly;
mod cursor;
mod gmsh;

#[cfg(test)]
mod tests;

use super::{Mesh, MeshError};
use serde::{Deserialize, Serialize};

/// A file format that can be read; it is written as the extension of its files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(
    feature = "service",
    derive(utoipa::ToSchema),
    schema(description = "The formats that can be uploaded.")
)]
pub enum MeshFormat {
    /// Gmsh `.msh`, version 2.2 or 4.1, ASCII or binary of either byte order.
    #[serde(rename = "msh")]
    Gmsh,
    /// Abaqus or CalculiX `.inp`.
    #[serde(rename = "inp")]
    Abaqus,
}

impl MeshFormat {
    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Gmsh => "msh",
            Self::Abaqus => "inp",
        }
    }

    /// The format that a file name ends in (`.msh`, `.inp`, in any case).
    pub fn from_name(name: &str) -> Option<Self> {
        let (_, extension) = name.rsplit_once('.')?;
        [Self::Gmsh, Self::Abaqus].into_iter().find(|f| extension.eq_ignore_ascii_case(f.extension()))
    }

    /// The format that the beginning of a file looks like.
    pub fn sniff(bytes: &[u8]) -> Option<Self> {
        match bytes.trim_ascii_start() {
            start if start.starts_with(b"$MeshFormat") || start.starts_with(b"$Comments") => Some(Self::Gmsh),
            start if start.starts_with(b"*") => Some(Self::Abaqus),
            _ => None,
        }
    }
}

/// Reads a mesh; coordinates are taken as metres ([`Mesh::transformed`] scales others).
///
/// Nodes that no volume element uses are left out, with a note.
///
/// # Errors
/// `Malformed` with the place where the file breaks its format, names a node that it does not have, or holds a number
/// that is not finite; `UnsupportedElements` for volume elements of other kinds; `Unsupported` for versions, encodings
/// and keywords that are refused; `Empty` for a file without volume elements.
pub fn read_mesh(bytes: &[u8], format: MeshFormat) -> Result<Mesh, MeshError> {
    match format {
        MeshFormat::Gmsh => gmsh::read(bytes),
        MeshFormat::Abaqus => abaqus::read(bytes),
    }
}
