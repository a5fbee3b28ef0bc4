//! Rigid bodies: shapes, inertia, rotation.
//!
//! A rigid body is represented by two *nodes* in addition to those of the meshes. Its `centre` is the centre of mass,
//! with 1/m along each axis; its `spin` is the angular velocity about its principal axes, with 1/I along each of
//! them. So one vector of velocities contains meshes and rigid bodies, M stays diagonal, and one contact solver
//! serves both: a contact at the point x of a rigid body has, in the direction n, the row `[n, Rᵀ((x − x_c) × n)]` of
//! its two nodes.

mod body;
mod boundary;
mod line;
mod motion;
mod polyhedron;
mod pose;
mod shape;

pub use body::RigidBody;
pub use boundary::triangulated;
pub use motion::{rotated, turn_freely};
pub use polyhedron::{MOST_PLANES, NoHull, Polyhedron, Solid};
pub use pose::{Pose, Rotation};
pub use shape::{Feet, Shape};
