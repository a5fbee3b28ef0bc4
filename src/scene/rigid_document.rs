//! Rigid bodies in a scene document: shape, position, mass and inertia.

use super::mesh_document::RotationDocument;
use crate::mechanics::rigid::{Pose, Rotation, Shape};
use crate::mechanics::tensor::Vec3;
use crate::mesh::defaults::{is_false, is_one, one};
use nalgebra::Unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rigid body, without a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidDocument {
    /// Shape, centred at the centre of mass.
    pub shape: ShapeDocument,
    /// Centre of mass [m].
    #[serde(default)]
    pub center_m: [f64; 3],
    /// Rotation about the centre of mass; for a cylinder or capsule, after aligning its axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationDocument>,
    /// Mass [kg]; alternative to the density.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Density [kg/m³]; alternative to the mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_kg_per_m3: Option<f64>,
    /// Principal moments of inertia [kg m²]: about x, y, z for a box or ball; across, along and across the axis for a
    /// cylinder or capsule; for a surface about its principal axes in ascending order, or about x, y, z where these are principal; by default
    /// those of a homogeneous body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia_kg_m2: Option<[f64; 3]>,
}

/// A shape of a rigid body, convex in contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeDocument {
    /// A solid ball about the centre of mass.
    Ball {
        /// Radius of the ball [m].
        radius_m: f64,
    },
    /// A box along x, y, z, unless it is rotated.
    Box {
        /// Half its edges along x, y, z [m].
        half_extents_m: [f64; 3],
    },
    /// A cylinder with flat ends.
    Cylinder {
        /// Radius of the cylinder [m].
        radius_m: f64,
        /// Half its length [m].
        half_length_m: f64,
        /// Direction of its axis; any length.
        axis: [f64; 3],
    },
    /// A cylinder with hemispherical ends, such as a baton.
    Capsule {
        /// Radius of the cylinder and of its ends [m].
        radius_m: f64,
        /// Half the distance between the centres of its ends [m].
        half_length_m: f64,
        /// Direction of its axis; any length.
        axis: [f64; 3],
    },
    /// The body that a closed surface of triangles encloses. The file's axes are those of the scene, unless it is rotated; its origin is
    /// not used.
    Stl {
        /// File name relative to the scene's folder (`.stl`, ASCII or binary), or the id of an uploaded surface.
        name: String,
        /// Scale factor (0.001 for a file in millimetres).
        #[serde(default = "one", skip_serializing_if = "is_one")]
        scale: f64,
        /// Let the convex hull of a surface that is not convex take part in contact; volume and inertia are those of the surface.
        #[serde(default, skip_serializing_if = "is_false")]
        convex_hull: bool,
    },
}

impl ShapeDocument {
    /// The shape, with the axis of a cylinder or capsule along y; `None` for one from a file.
    pub fn shape(&self) -> Option<Shape> {
        Some(match *self {
            Self::Ball { radius_m: radius } => Shape::Ball { radius },
            Self::Box { half_extents_m } => Shape::Box { half: half_extents_m.into() },
            Self::Cylinder { radius_m: radius, half_length_m: half_length, .. } => {
                Shape::Cylinder { radius, half_length }
            }
            Self::Capsule { radius_m: radius, half_length_m: half_length, .. } => {
                Shape::Capsule { radius, half_length }
            }
            Self::Stl { .. } => return None,
        })
    }

    /// Axis of a cylinder or capsule.
    pub fn axis(&self) -> Option<[f64; 3]> {
        match self {
            Self::Ball { .. } | Self::Box { .. } | Self::Stl { .. } => None,
            Self::Cylinder { axis, .. } | Self::Capsule { axis, .. } => Some(*axis),
        }
    }
}

impl RigidDocument {
    /// Initial position and orientation; `None` for a direction without a length.
    pub fn pose(&self) -> Option<Pose> {
        let laid = match self.shape.axis() {
            None => Rotation::identity(),
            Some(axis) => {
                let axis = Vec3::from(axis).try_normalize(0.0)?;
                // The shortest rotation between opposite directions is not unique: any half turn will do.
                Rotation::rotation_between(&Vec3::y(), &axis)
                    .unwrap_or_else(|| Rotation::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI))
            }
        };
        let turned = match &self.rotation {
            None => Rotation::identity(),
            Some(rotation) => {
                let axis = Unit::try_new(Vec3::from(rotation.axis), 0.0)?;
                Rotation::from_axis_angle(&axis, rotation.angle_deg.to_radians())
            }
        };
        Some(Pose { centre: self.center_m.into(), orientation: turned * laid })
    }

    /// Mass of its shape [kg]; `None` when neither mass nor density is given.
    pub fn mass(&self, shape: &Shape) -> Option<f64> {
        self.mass_kg.or_else(|| Some(self.density_kg_per_m3? * shape.volume()))
    }

    /// Principal moments of inertia of its shape [kg m²] for a given mass [kg].
    pub fn inertia(&self, shape: &Shape, mass: f64) -> Vec3 {
        self.inertia_kg_m2.map_or_else(|| shape.inertia_per_mass() * mass, Vec3::from)
    }
}
