//! Mesh files: Gmsh `.msh` (2.2 and 4.1, ASCII and binary) and Abaqus `.inp`.
//!
//! The readers accept arbitrary bytes, trust none of them, and report the line or byte of an error. Volumes may be of any
//! [`CellKind`](super::CellKind), mixed in one file. Named groups of volume elements become parts, groups of other elements
//! node sets.

mod abaqus;
mod assembly;
mod cursor;
mod gmsh;

#[cfg(test)]
mod tests;

use super::{Mesh, MeshError};
use serde::{Deserialize, Serialize};

/// A supported file format; serialised as its file extension.
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
    /// File extension of the format.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Gmsh => "msh",
            Self::Abaqus => "inp",
        }
    }

    /// The format from the extension of a file name (`.msh`, `.inp`, not case-sensitive).
    pub fn from_name(name: &str) -> Option<Self> {
        let (_, extension) = name.rsplit_once('.')?;
        [Self::Gmsh, Self::Abaqus].into_iter().find(|f| extension.eq_ignore_ascii_case(f.extension()))
    }

    /// The format from the first bytes of a file.
    pub fn sniff(bytes: &[u8]) -> Option<Self> {
        match bytes.trim_ascii_start() {
            start if start.starts_with(b"$MeshFormat") || start.starts_with(b"$Comments") => Some(Self::Gmsh),
            start if start.starts_with(b"*") => Some(Self::Abaqus),
            _ => None,
        }
    }
}

/// Reads a mesh; coordinates are in metres ([`Mesh::transformed`] scales others).
///
/// Nodes without a volume element are omitted, with a note.
///
/// # Errors
/// `Malformed`, with the place, for a violation of the format, a reference to a missing node, or a number that is not
/// finite; `UnsupportedElements` for volume elements of other kinds; `Unsupported` for versions, encodings and keywords
/// that are not supported; `Empty` for a file without volume elements.
pub fn read_mesh(bytes: &[u8], format: MeshFormat) -> Result<Mesh, MeshError> {
    match format {
        MeshFormat::Gmsh => gmsh::read(bytes),
        MeshFormat::Abaqus => abaqus::read(bytes),
    }
}
