//! A rigid body.

use super::shape::Shape;
use crate::tensor::Vec3;

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
