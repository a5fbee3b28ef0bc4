//! Options of the time integration, and of what precedes it.

use super::statics::Statics;
use crate::mechanics::sparse::{Cholesky, SparseError, SymmetricMatrix, Unknowns};
use serde::{Deserialize, Serialize};

/// Dynamic relaxation before the clock starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicRelaxation {
    /// Duration of the relaxation [s].
    pub duration: f64,
    /// Mass-proportional damping α [1/s].
    pub damping: f64,
}

/// Time integration scheme with its parameters.
#[derive(Clone, Debug)]
pub enum Integrator {
    /// Central differences with a lumped mass matrix.
    Explicit(Explicit),
    /// The θ scheme, or equilibrium without mass.
    Implicit(Box<Implicit>),
}

/// Options of the explicit integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explicit {
    /// Safety factor: fraction of the critical time step [-].
    pub safety: f64,
    /// Largest step [s]; infinite if none is given.
    pub max_step: f64,
    /// Largest change of length of an edge or diagonal in a step, `h max|D|` [-].
    pub largest_strain_increment: f64,
}

/// Options of the implicit integrator, and the unknowns of its systems.
#[derive(Clone, Debug)]
pub struct Implicit {
    /// Time step, unless it has to be cut [s].
    pub step: f64,
    /// The run fails when a step would have to be shorter than this [s].
    pub smallest_step: f64,
    /// Data for equilibrium without mass, with θ = ξ = 1; `None` with mass.
    pub statics: Option<Statics>,
    /// Weight θ of the end velocity in the update of positions [-], ½ … 1.
    pub theta: f64,
    /// Weight ξ of the end forces [-], ½ … 1.
    pub xi: f64,
    /// Whether time is real for viscosity and relaxation; else all has relaxed.
    pub rate_effects: bool,
    /// Whether the mean forces of a step conserve energy and momenta; θ = ξ = ½ then.
    pub energy_momentum: bool,
    /// Largest residual of the momentum, relative to the impulses of the step [-].
    pub tolerance: f64,
    /// Unknowns in the order of elimination.
    pub unknowns: Unknowns,
    /// Size of the linear systems.
    pub systems: SystemSize,
}

impl Implicit {
    /// 1 with mass, 0 without [-].
    pub fn inertia(&self) -> f64 {
        if self.statics.is_some() { 0.0 } else { 1.0 }
    }
}

/// Sizes of the linear systems of implicit steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct SystemSize {
    /// Unknown velocity components (degrees of freedom).
    pub unknowns: usize,
    /// Entries of the lower triangle of the matrix.
    pub matrix_entries: usize,
    /// Entries of the factor.
    pub factor_entries: usize,
    /// Floating-point operations of one factorisation.
    pub factor_flops: f64,
    /// Size of matrix, factor and working memory [bytes].
    pub memory_bytes: u64,
}

impl SystemSize {
    pub(super) fn new(unknowns: &Unknowns) -> Result<Self, SparseError> {
        let matrix = SymmetricMatrix::new(unknowns);
        let factor = Cholesky::new(&matrix)?;
        Ok(Self {
            unknowns: unknowns.count(),
            matrix_entries: matrix.entries(),
            factor_entries: factor.entries(),
            factor_flops: factor.flops(),
            memory_bytes: (matrix.memory() + factor.memory()) as u64,
        })
    }
}
