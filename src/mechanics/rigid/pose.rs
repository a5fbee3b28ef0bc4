//! Position and orientation of a rigid body.

use crate::tensor::{Mat3, Vec3};

/// A rotation, from the axes of a body to those of space.
pub type Rotation = nalgebra::UnitQuaternion<f64>;

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
    pub fn moment_arm(&self, x: &Vec3) -> Mat3 {
        -(x - self.centre).cross_matrix() * self.orientation.to_rotation_matrix().into_inner()
    }
    /// Whether position and orientation are finite.
    pub fn is_finite(&self) -> bool {
        self.centre.iter().chain(self.orientation.coords.iter()).all(|x| x.is_finite())
    }
}
