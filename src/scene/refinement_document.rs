//! Local refinement in a scene document: where the elements of a body are to be small.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elements near a place are split into eight until they are small enough, with hanging nodes between coarse and fine ones. The facets of
/// curved surfaces stay what they are. Not together with erosion of the body, or with mortar contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinementDocument {
    /// Near what.
    pub around: Around,
    /// So near: the box around an element, along the axes of space, is no farther away [m].
    pub within_m: f64,
    /// Longest edge along the surface that elements there may have [m]; across it they are halved as often.
    pub size_m: f64,
}

/// What elements are small around.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Around {
    /// Where the line that the centre of the projectile flies along first meets the other body, and on the projectile where it lies ahead.
    Impact,
    /// A point [m].
    PointM([f64; 3]),
    /// The nodes of a node set of the mesh.
    Set(String),
}
