//! Meshes in a scene document: a file in the folder of the scene, an uploaded mesh, or a generator.

use super::segmentation_document::SegmentationDocument;
use crate::mesh::defaults::one;
use crate::mesh::generate::Generator;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Source of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MeshDocument {
    /// Read from a file in the folder of the scene, or from an uploaded mesh.
    File(MeshFileDocument),
    /// Generated from a few parameters.
    Generator(Generator),
    /// Made from the labels of a scan, or from closed surfaces.
    Segmentation(SegmentationDocument),
}

/// A mesh file, or parts of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFileDocument {
    /// File name relative to the scene's folder (`.msh`, `.inp`, `.vtk`, `.vtu`, `.k`, `.feb`, `.bdf`), or the id of an uploaded mesh.
    pub name: String,
    /// Parts of the file that make up this body; all by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<Vec<String>>,
    /// CSV file in the scene's folder with arrays of its elements. The first column is `element`, the number of an element from 0 in the
    /// order of the file, or `part`; the columns a_x, a_y, a_z are the array `a` of three components.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// Number of times each element is split into eight. Curved surfaces keep their facets.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub refine: u32,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_zero(count: &u32) -> bool {
    *count == 0
}

/// Position and orientation of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacementDocument {
    /// Scale factor (0.001 for a mesh in millimetres).
    #[serde(default = "one")]
    pub scale: f64,
    /// Rotation about the origin, after scaling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationDocument>,
    /// Translation [m], after rotation.
    #[serde(default)]
    pub translation_m: [f64; 3],
}

/// A rotation about an axis through the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotationDocument {
    /// Axis of rotation; any length.
    pub axis: [f64; 3],
    /// Angle of rotation, right-handed about the axis [degree].
    pub angle_deg: f64,
}

impl MeshDocument {
    /// Numbers of elements by direction; of a scan, along a metre; of a mesh from a file, the number into which each element is split along an edge.
    pub fn counts(&self) -> Vec<u32> {
        match self {
            Self::Generator(generator) => {
                generator.clone().counts_mut().into_iter().map(|count| *count).collect()
            }
            Self::File(file) => vec![1_u32.checked_shl(file.refine).unwrap_or(u32::MAX)],
            // Elements along a metre.
            Self::Segmentation(scan) => vec![(1.0 / scan.size_m).round().max(1.0) as u32],
        }
    }
}
