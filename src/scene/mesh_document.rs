//! Meshes in a scene document: a file in the folder of the scene, an uploaded mesh, or a generator.

use super::defaults::{is_false, is_one, one};
use super::segmentation_document::SegmentationDocument;
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

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
fn is_nought(length: &f64) -> bool {
    length.to_bits() == 0.0_f64.to_bits()
}

fn uniform() -> [f64; 2] {
    [1.0; 2]
}

fn is_uniform(grading: &[f64; 2]) -> bool {
    grading.iter().all(is_one)
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

/// A mesh generated from a few parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Generator {
    /// A cubed-sphere shell: part `ball`, node sets `outer`, `inner`.
    HollowBall {
        /// Centre of the ball [m].
        #[serde(default)]
        center_m: [f64; 3],
        /// Outer radius of the ball [m].
        outer_radius_m: f64,
        /// Inner radius of the ball [m].
        inner_radius_m: f64,
        /// Elements along a quarter of a great circle, n: 6 n² per layer.
        elements_around: u32,
        /// Layers of elements through the wall.
        elements_through: u32,
    },
    /// A solid ball, a cube blended into a cubed sphere: part `ball`, node set `outer`; a quarter also has `x_min` and
    /// `y_min`.
    SolidBall {
        /// Centre of the ball [m].
        #[serde(default)]
        center_m: [f64; 3],
        /// Radius of the ball [m].
        radius_m: f64,
        /// Elements along a quarter of a great circle, n: n³ in the core, 6 n² per layer.
        elements_around: u32,
        /// Layers between the core and the surface.
        elements_through: u32,
        /// Size ratio of the largest to the smallest element along x and y; the smallest are at the poles ±z.
        #[serde(default = "one", skip_serializing_if = "is_one")]
        grading: f64,
        /// Only the quarter with x ≥ 0 and y ≥ 0 from the centre, for symmetric scenes.
        #[serde(default, skip_serializing_if = "is_false")]
        quarter: bool,
    },
    /// A round baton: part `baton`, node sets `side`, `bottom`, `top`, `ends`.
    Cylinder {
        /// Centre, half way along the axis [m].
        #[serde(default)]
        center_m: [f64; 3],
        /// Direction of the axis, from `bottom` to `top`; any length.
        axis: [f64; 3],
        /// Radius of the baton [m].
        radius_m: f64,
        /// Length along the axis [m].
        length_m: f64,
        /// Elements along a quarter of the circumference, n: n² in the core of a slice.
        elements_around: u32,
        /// Rings between the core and the side, of 4 n elements each.
        elements_through: u32,
        /// Elements along the axis.
        elements_along: u32,
    },
    /// A block along x, y, z: part `block`, node sets `x_min` … `z_max`.
    Block {
        /// Corner with the least coordinates [m].
        min_m: [f64; 3],
        /// Corner with the greatest coordinates [m].
        max_m: [f64; 3],
        /// Elements along x, y, z.
        elements: [u32; 3],
        /// Size ratio of the largest to the smallest element along x, y, z; the smallest are at `grading_center_m`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        grading: Option<[f64; 3]>,
        /// Point towards which the elements are smallest [m]; by default the centre of the block.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        grading_center_m: Option<[f64; 3]>,
    },
    /// Layers along z, such as skin, fat, muscle: one part per name, node sets `x_min` … `z_max`.
    LayeredBlock {
        /// Centre of the top surface [m].
        #[serde(default)]
        top_center_m: [f64; 3],
        /// Size along x and y [m].
        size_m: [f64; 2],
        /// Layers from the top (`z_max`) down.
        layers: Vec<LayerDocument>,
        /// Elements along x and y.
        elements: [u32; 2],
        /// Size ratio of the largest to the smallest element along x and y; the smallest are at the centre.
        #[serde(default = "uniform", skip_serializing_if = "is_uniform")]
        grading: [f64; 2],
        /// Distance from the centre along x and y within which the elements are uniform and smallest [m].
        #[serde(default, skip_serializing_if = "is_nought")]
        uniform_within_m: f64,
    },
    /// A limb along y with an elliptic section: bone hole, muscle, fat, skin; parts `muscle`, `fat`, `skin`; node sets
    /// `bone`, `skin_outer`, `end_low`, `end_high`; material axes e1 along the limb, e2 circumferential, e3 outwards.
    LimbSegment(LimbSegmentDocument),
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

impl Generator {
    /// All element counts, for modification.
    pub fn counts_mut(&mut self) -> Vec<&mut u32> {
        match self {
            Self::HollowBall { elements_around, elements_through, .. }
            | Self::SolidBall { elements_around, elements_through, .. } => {
                vec![elements_around, elements_through]
            }
            Self::Cylinder { elements_around, elements_through, elements_along, .. } => {
                vec![elements_around, elements_through, elements_along]
            }
            Self::Block { elements, .. } => elements.iter_mut().collect(),
            Self::LayeredBlock { layers, elements, .. } => {
                elements.iter_mut().chain(layers.iter_mut().map(|layer| &mut layer.elements)).collect()
            }
            Self::LimbSegment(limb) => vec![
                &mut limb.elements_around,
                &mut limb.elements_along,
                &mut limb.muscle_elements,
                &mut limb.fat_elements,
                &mut limb.skin_elements,
            ],
        }
    }
}

/// A layer of a layered block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerDocument {
    /// Name of its part; layers with the same name form one part.
    pub part: String,
    /// Thickness along z [m].
    pub thickness_m: f64,
    /// Layers of elements through the thickness.
    pub elements: u32,
}

/// A segment of a limb.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimbSegmentDocument {
    /// Centre of the segment, on its axis [m].
    #[serde(default)]
    pub center_m: [f64; 3],
    /// Outer semi-axis of the section along x, skin included [m].
    pub semi_axis_x_m: f64,
    /// Outer semi-axis of the section along z, skin included [m].
    pub semi_axis_z_m: f64,
    /// Length along y [m].
    pub length_m: f64,
    /// Semi-axis of the bone along x [m].
    pub bone_semi_axis_x_m: f64,
    /// Semi-axis of the bone along z [m].
    pub bone_semi_axis_z_m: f64,
    /// Offset of the bone axis from the limb axis along x and z [m].
    #[serde(default)]
    pub bone_offset_m: [f64; 2],
    /// Thickness of the fat layer [m].
    pub fat_thickness_m: f64,
    /// Thickness of the skin layer [m].
    pub skin_thickness_m: f64,
    /// Elements around the section.
    pub elements_around: u32,
    /// Elements along the limb.
    pub elements_along: u32,
    /// Layers of elements through the muscle.
    pub muscle_elements: u32,
    /// Layers of elements through the fat.
    pub fat_elements: u32,
    /// Layers of elements through the skin.
    pub skin_elements: u32,
    /// Angular position of the impact on the section, from +z towards +x [degree]; elements are smallest there.
    #[serde(default)]
    pub impact_angle_deg: f64,
    /// Position of the impact along the limb, y from the middle [m]; elements are smallest there.
    #[serde(default)]
    pub impact_along_m: f64,
    /// Size ratio of the largest to the smallest element around the limb.
    #[serde(default = "one")]
    pub grading_around: f64,
    /// Size ratio of the largest to the smallest element along the limb.
    #[serde(default = "one")]
    pub grading_along: f64,
    /// Thickness ratio of the innermost to the outermost layer of the muscle.
    #[serde(default = "one")]
    pub grading_muscle: f64,
    /// Distance from the impact, along and around the limb, within which the elements are uniform and smallest [m];
    /// somewhat more than the radius of the contact patch.
    #[serde(default, skip_serializing_if = "is_nought")]
    pub uniform_within_m: f64,
}
