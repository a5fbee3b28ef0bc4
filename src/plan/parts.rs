//! Components of a plan before it is complete, and the errors of compilation.

use super::body::PlanBody;
use super::loads::Loads;
use super::rigid::RigidPlan;
use crate::mechanics::followers::{FollowerError, Followers, Masters};
use crate::mechanics::force::{BlockError, ElementBlock};
use crate::mechanics::sparse::SparseError;
use crate::mechanics::tensor::Vec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Why a validated scene could not be compiled.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum CompileError {
    /// The Jacobian of an element is not positive at a quadrature point.
    #[error("element {element} of body `{body}` has a Jacobian of {ratio:.3} of its mean: it is inverted")]
    InvertedElement {
        /// Name of the body, as in the scene.
        body: String,
        /// Index of the element in the body.
        element: usize,
        /// Smallest determinant divided by the mean.
        ratio: f64,
    },
    /// A node belongs to no element, or only to elements without mass.
    #[error("node {node} of body `{body}` has no mass")]
    MasslessNode {
        /// Name of the body, as in the scene.
        body: String,
        /// Index of the node in the body.
        node: usize,
    },
    /// The followers defined by the mesh are invalid.
    #[error("body `{body}`: {error}")]
    Followers {
        /// Name of the body; empty for all bodies together.
        body: String,
        /// The error, with node indices in the body.
        error: FollowerError,
    },
    /// A follower is held or driven, but its masters are not.
    #[error("node {node} of body `{body}` is held or driven, but follows nodes that are not all")]
    HeldFollower {
        /// Name of the body, as in the scene.
        body: String,
        /// Index of the node in the body.
        node: u32,
    },
    /// `auto` has not been replaced by explicit or implicit steps, which validation does.
    #[error("the integrator of the scene is still to be chosen")]
    NoIntegrator,
    /// Elements that no block can have.
    #[error(transparent)]
    Block(#[from] BlockError),
    /// The systems of an implicit integrator cannot be solved.
    #[error(transparent)]
    Sparse(#[from] SparseError),
}

/// Components of the plan, collected body by body.
#[derive(Default)]
pub(super) struct Parts {
    pub X: Vec<Vec3>,
    pub own_inverse_mass: Vec<Vec3>,
    pub mass: Vec<f64>,
    pub inverse_mass: Vec<Vec3>,
    pub u: Vec<Vec3>,
    pub v: Vec<Vec3>,
    pub blocks: Vec<ElementBlock>,
    pub bodies: Vec<PlanBody>,
    pub rigid: RigidPlan,
    pub loads: Loads,
    /// Followers with their masters and weights, from the meshes.
    pub ties: BTreeMap<u32, Masters>,
    pub followers: Arc<Followers>,
}
