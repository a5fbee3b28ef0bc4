//! Uploaded meshes: identified by content, visible only to those who uploaded them.

mod shelf;

pub use shelf::{MeshShelf, ShelfError, is_id};

use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// An uploaded mesh with its report.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = UploadedMesh)]
pub struct StoredMesh {
    /// SHA-256 of its bytes, hexadecimal: the name by which scenes use it.
    pub id: String,
    /// Format of the file.
    pub format: MeshFormat,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// Time of the first upload, RFC 3339.
    pub created_at: String,
    /// Contents and quality of the mesh.
    #[serde(flatten)]
    pub report: MeshReport,
}

/// Why an upload gave no mesh.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum MeshRefusal {
    /// It is not one, or takes more than a mesh may: what is wrong, and where in the file.
    #[error("{0}")]
    Invalid(String),
    /// The process that read it was killed: how. The mesh may be right.
    #[error("{0}")]
    Lost(String),
}
