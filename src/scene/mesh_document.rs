//! Meshes in a scene document: a file beside it, an uploaded mesh, or a generator.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where a mesh comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MeshDocument {
    /// Read from a file beside the scene, or from an uploaded mesh.
    File(MeshFileDocument),
    /// Made from a few numbers.
    Generator(Generator),
}

/// A mesh file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFileDocument {
    /// File name relative to the scene's folder (`.msh`, `.inp`), or the id of an uploaded mesh.
    pub name: String,
    /// Parts of the file that make this body; all when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<Vec<String>>,
}

/// Where a body stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacementDocument {
    /// Scale factor (0.001 for a mesh in millimetres).
    #[serde(default = "one")]
    pub scale: f64,
    /// Axis and angle of the rotation about the origin [degree].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationDocument>,
    /// Translation [m].
    #[serde(default)]
    pub translation_m: [f64; 3],
}

fn one() -> f64 {
    1.0
}

/// A rotation about an axis through the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotationDocument {
    /// Axis, of any length.
    pub axis: [f64; 3],
    /// Angle, right-handed [degree].
    pub angle_deg: f64,
}

/// A mesh made from a few numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Generator {
    /// A cubed-sphere shell: part `ball`, node sets `outer`, `inner`.
    HollowBall {
        /// Centre [m].
        #[serde(default)]
        center_m: [f64; 3],
        /// Outer radius [m].
        outer_radius_m: f64,
        /// Inner radius [m].
        inner_radius_m: f64,
        /// Elements along each edge of the cube.
        elements_around: u32,
        /// Layers through the wall.
        elements_through: u32,
    },
    /// A solid ball, a cube blended into a cubed sphere: part `ball`, node set `outer`.
    SolidBall {
        /// Centre [m].
        #[serde(default)]
        center_m: [f64; 3],
        /// Radius [m].
        radius_m: f64,
        /// Elements along each edge of the cube.
        elements_around: u32,
        /// Layers between the core and the surface.
        elements_through: u32,
    },
    /// A round baton: part `baton`, node sets `side`, `bottom`, `top`.
    Cylinder {
        /// Centre of the bottom disc [m].
        #[serde(default)]
        base_center_m: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
        /// Radius [m].
        radius_m: f64,
        /// Length [m].
        length_m: f64,
        /// Elements along each edge of the core square of the disc.
        elements_around: u32,
        /// Layers between the core and the side.
        elements_through: u32,
        /// Elements along the axis.
        elements_along: u32,
    },
    /// A block: part `block`, node sets `x_min` … `z_max`.
    Block {
        /// Lowest corner [m].
        min_m: [f64; 3],
        /// Highest corner [m].
        max_m: [f64; 3],
        /// Elements along x, y, z.
        elements: [u32; 3],
        /// Size ratio of the largest to the smallest element along x, y, z; the smallest are at `grading_center_m`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        grading: Option<[f64; 3]>,
        /// Where the elements are smallest [m]; the block's centre by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        grading_center_m: Option<[f64; 3]>,
    },
    /// A limb: bone hole, muscle, fat, skin about the y axis; parts `muscle`, `fat`, `skin`; node sets `bone`, `skin_outer`,
    /// `end_low`, `end_high`; material axes e1 along the limb, e2 circumferential, e3 radial.
    LimbSegment {
        /// Outer semi-axes of the section along x and z, skin included [m].
        semi_axes_m: [f64; 2],
        /// Length along y, centred at 0 [m].
        length_m: f64,
        /// Radius of the bone hole [m].
        bone_radius_m: f64,
        /// Thickness of the fat [m].
        fat_thickness_m: f64,
        /// Thickness of the skin [m].
        skin_thickness_m: f64,
        /// Where it will be hit: angle of the section from +z towards +x [degree], and y [m]. Elements are graded towards it.
        #[serde(default)]
        impact_angle_deg: f64,
        /// y of the impact point [m].
        #[serde(default)]
        impact_y_m: f64,
        /// Elements around the section.
        elements_around: u32,
        /// Elements along the limb.
        elements_along: u32,
        /// Elements through the muscle.
        elements_muscle: u32,
        /// Elements through the fat.
        elements_fat: u32,
        /// Elements through the skin.
        elements_skin: u32,
        /// Size ratio of the largest to the smallest element around and along.
        #[serde(default = "default_limb_grading")]
        grading: f64,
    },
}

fn default_limb_grading() -> f64 {
    4.0
}
