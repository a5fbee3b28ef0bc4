//! Local refinement in a scene document: regions of a body with small elements.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Elements near a place are split into eight until they are small enough, with hanging nodes between coarse and fine ones.
/// Curved surfaces keep their facets. Cannot be combined with erosion of the body, or with mortar contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinementDocument {
    /// Place to refine around.
    pub around: Around,
    /// Largest distance between the place and the bounding box of an element (along x, y, z) to be refined [m].
    pub within_m: f64,
    /// Largest edge length along the surface of these elements [m]; across it they are halved as often.
    pub size_m: f64,
}

/// Place around which elements are small.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Around {
    /// The point where the path of the projectile's centre first meets the other body; on the projectile, its foremost
    /// point on that path.
    Impact,
    /// A point of the scene [m].
    PointM([f64; 3]),
    /// The nodes of a node set of the mesh.
    Set(String),
}
