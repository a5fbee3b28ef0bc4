//! Uploaded meshes: identified by content, visible only to those who uploaded them.

mod shelf;

pub use shelf::{MeshShelf, ShelfError, is_id};

use crate::mesh::read::MeshFormat;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// Contents and quality of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeshReport {
    /// Number of nodes in the file.
    pub nodes: u64,
    /// Number of elements in the file.
    pub elements: u64,
    /// Number of elements of each part.
    pub parts: BTreeMap<String, u64>,
    /// Number of nodes of each node set.
    pub node_sets: BTreeMap<String, u64>,
    /// Lower corner of the bounding box, in the unit of the file.
    pub bounding_box_min: [f64; 3],
    /// Upper corner of the bounding box.
    pub bounding_box_max: [f64; 3],
    /// Quality of the elements.
    pub quality: MeshQualityReport,
    /// Notes of the reader.
    pub notes: Vec<String>,
}

/// Quality of the elements of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeshQualityReport {
    /// Smallest scaled Jacobian at corners and quadrature points [-], 1 for bricks; not positive: the mesh cannot run.
    pub min_scaled_jacobian: f64,
    /// Element with that Jacobian.
    pub worst_element: u32,
    /// Number of elements with a non-positive Jacobian at a quadrature point.
    pub negative_elements: u64,
    /// The first of these elements.
    pub first_negative_elements: Vec<u32>,
    /// Number of elements that are valid inside but folded at a corner: they can run, with poor accuracy.
    pub folded_elements: u64,
    /// Largest ratio of longest to shortest edge in one element [-]; null if an edge has zero length.
    pub max_aspect_ratio: Option<f64>,
    /// Number of nodes at exactly the position of an earlier one.
    pub coincident_nodes: u64,
    /// Shortest edge, in the unit of the file.
    pub min_edge: f64,
    /// Longest edge, in the unit of the file.
    pub max_edge: f64,
    /// Volume, in the cube of that unit.
    pub volume: f64,
}

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

/// Why an upload is not a mesh.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{message}")]
pub struct MeshRefusal {
    /// Description of the error, and where it is in the file.
    pub message: String,
}
