//! What a plan is put together from, and why it may not be.

use super::PlanBody;
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
    /// An element has no positive volume at a quadrature point.
    #[error("element {element} of body `{body}` has a Jacobian of {ratio:.3} of its mean: it is inverted")]
    InvertedElement {
        /// Body.
        body: String,
        /// Element in the body.
        element: usize,
        /// Smallest determinant over the mean.
        ratio: f64,
    },
    /// A mesh holds cells that there is no element for; validation reports them earlier.
    #[error("body `{body}`: {reason}")]
    NoElement {
        /// Body.
        body: String,
        /// Which cells.
        reason: String,
    },
    /// A node belongs to no element, or to elements without mass.
    #[error("node {node} of body `{body}` has no mass")]
    MasslessNode {
        /// Body.
        body: String,
        /// Node in the body.
        node: usize,
    },
    /// Nodes of the mesh cannot follow others as it says.
    #[error("body `{body}`: {error}")]
    Followers {
        /// Body.
        body: String,
        /// Why; nodes in the body.
        error: FollowerError,
    },
    /// A node that follows others is held or driven, and they are not.
    #[error("node {node} of body `{body}` is held or driven, but follows nodes that are not all")]
    HeldFollower {
        /// Body.
        body: String,
        /// Node in the body.
        node: u32,
    },
    /// Nobody has chosen explicit or implicit steps; validation does.
    #[error("the integrator of the scene is still to be chosen")]
    NoIntegrator,
    /// Elements that no block can have.
    #[error(transparent)]
    Block(#[from] BlockError),
    /// The systems of an implicit integrator cannot be solved.
    #[error(transparent)]
    Sparse(#[from] SparseError),
}

/// What is collected body after body.
#[derive(Default)]
pub(super) struct Parts {
    pub X: Vec<Vec3>,
    pub mass: Vec<f64>,
    pub inverse_mass: Vec<Vec3>,
    pub u: Vec<Vec3>,
    pub v: Vec<Vec3>,
    pub blocks: Vec<ElementBlock>,
    pub bodies: Vec<PlanBody>,
    pub rigid: RigidPlan,
    pub loads: Loads,
    /// Whom nodes follow, as the meshes say.
    pub ties: BTreeMap<u32, Masters>,
    pub followers: Arc<Followers>,
}
