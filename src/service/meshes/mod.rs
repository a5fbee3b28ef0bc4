//! Uploaded meshes: named by what they are, seen only by those who uploaded them.

mod shelf;

pub use shelf::{MeshShelf, ShelfError, is_id};

use crate::mesh::read::MeshFormat;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// What a mesh holds, and how good it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeshReport {
    /// Number of nodes.
    pub nodes: u64,
    /// Number of elements.
    pub elements: u64,
    /// Number of elements of each part.
    pub parts: BTreeMap<String, u64>,
    /// Number of nodes of each node set.
    pub node_sets: BTreeMap<String, u64>,
    /// Lowest corner of the box around it, in the unit of the file.
    pub bounding_box_min: [f64; 3],
    /// Highest corner.
    pub bounding_box_max: [f64; 3],
    /// How good its elements are.
    pub quality: MeshQualityReport,
    /// What its reader noticed.
    pub notes: Vec<String>,
}

/// How good the elements of a mesh are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeshQualityReport {
    /// Smallest scaled Jacobian at corners and quadrature points [-], 1 for bricks; not positive: the mesh cannot run.
    pub min_scaled_jacobian: f64,
    /// The element where that is.
    pub worst_element: u32,
    /// Elements with a Jacobian that is not positive at a quadrature point.
    pub negative_elements: u64,
    /// The first of them.
    pub first_negative_elements: Vec<u32>,
    /// Elements that are sound inside but folded at a corner: they can run, with poor accuracy.
    pub folded_elements: u64,
    /// Largest ratio of longest to shortest edge in one element [-]; null where an edge has no length.
    pub max_aspect_ratio: Option<f64>,
    /// Nodes at exactly the position of an earlier one.
    pub coincident_nodes: u64,
    /// Shortest edge, in the unit of the file.
    pub min_edge: f64,
    /// Longest edge.
    pub max_edge: f64,
    /// Volume, in the cube of that unit.
    pub volume: f64,
}

/// An uploaded mesh.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[schema(as = UploadedMesh)]
pub struct StoredMesh {
    /// SHA-256 of its bytes, hexadecimal: the name by which scenes use it.
    pub id: String,
    /// Its format.
    pub format: MeshFormat,
    /// Its size [bytes].
    pub bytes: u64,
    /// When it came first, RFC 3339.
    pub created_at: String,
    /// What it holds.
    #[serde(flatten)]
    pub report: MeshReport,
}

/// Why an upload is not a mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct MeshRefusal {
    /// What is wrong, and where in the file.
    pub message: String,
}
