//! Rigid bodies: shapes, inertia, rotation.
//!
//! A rigid body is represented by two *nodes* in addition to those of the meshes. Its `centre` is the centre of mass,
//! with 1/m along each axis; its `spin` is the angular velocity about its principal axes, with 1/I along each of
//! them. So one vector of velocities contains meshes and rigid bodies, M stays diagonal, and one contact solver
//! serves both: a contact at the point x of a rigid body has, in the direction n, the row `[n, Rᵀ((x − x_c) × n)]` of
//! its two nodes.

mod boundary;
mod line;
mod motion;
mod polyhedron;
mod shape;

pub use boundary::triangulated;
pub use motion::{rotated, turn_freely};
pub use polyhedron::{MOST_PLANES, NoHull, Polyhedron, Solid};
pub use shape::{Feet, Shape};

use super::tensor::{Mat3, Vec3};

/// A rotation, from the axes of a body to those of space.
pub type Rotation = nalgebra::UnitQuaternion<f64>;

/// Constant data of a rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// Node of its centre of mass.
    pub centre: u32,
    /// Node of its angular velocity, in the axes of the body.
    pub spin: u32,
    /// Shape about the centre of mass, along the principal axes.
    pub shape: Shape,
    /// Mass of the body [kg].
    pub mass: f64,
    /// Principal moments of inertia [kg m²].
    pub inertia: Vec3,
}

/// Position and orientation of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position of the centre of mass [m].
    pub centre: Vec3,
    /// Rotation from the axes of the body to those of space.
    pub orientation: Rotation,
}

impl Pose {
    /// Position in space of a point of the body [m].
    pub fn place(&self, local: &Vec3) -> Vec3 {
        self.centre + self.orientation * local
    }
    /// Coordinates of a point of space in the axes of the body [m].
    pub fn local(&self, x: &Vec3) -> Vec3 {
        self.orientation.inverse_transform_vector(&(x - self.centre))
    }
    /// Moment arm of the point `x`: the matrix of its velocity in space [m/s] due to an angular velocity in the axes
    /// of the body [rad/s], `J ω = (R ω) × (x − x_c)`, `J = −[x − x_c]ₓ R`.
    pub fn lever(&self, x: &Vec3) -> Mat3 {
        -(x - self.centre).cross_matrix() * self.orientation.to_rotation_matrix().into_inner()
    }
    /// Whether position and orientation are finite.
    pub fn is_finite(&self) -> bool {
        self.centre.iter().chain(self.orientation.coords.iter()).all(|x| x.is_finite())
    }
}
