//! Cost of time steps, from a fixed table rather than timing, so that a scene always gets the same plan.
//!
//! Measured on one core of a virtual Intel Xeon (Sapphire Rapids family, AVX-512) with `cargo bench`: `element_kernels` for
//! the elements, `scenes` for the rest of an explicit step, `implicit` for implicit ones.

use crate::mechanics::element::ElementKind;
use crate::mechanics::followers::Followers;
use crate::mechanics::force::Formulation;
use crate::mechanics::material::Material;
use crate::mechanics::sparse::{Cholesky, SparseError, SymmetricMatrix, Unknowns};
use crate::mesh::Mesh;
use std::sync::Arc;

/// Cost of a step apart from the elements [ns]: sums, ledger and measures for each node, contact for each node of a slave
/// surface; estimated split of what whole runs of `ball_on_block` and `flashball_thigh` take beyond their elements.
const NODE: f64 = 70.0;
const SLAVE_NODE: f64 = 350.0;

/// Approximate numbers of iterations and matrices of an implicit step. Steps of `ball_on_block` (0.6 GFLOP per factor) took
/// 60 ms at the length of explicit ones, 187 ms at five times that and 327 ms at ten times, with cuts and retries; these
/// numbers are for steps in between.
const ITERATIONS: f64 = 8.0;
const MATRICES: f64 = 2.0;
/// Stiffness of an element and its assembly [ns], speed of a factorisation [GFLOP/s] (20 to 23 measured on blocks of 12³ to
/// 20³ elements), an entry of the factor in one solution [ns] (1.3 in the cache, 1.75 to 1.95 beyond it), and in one of
/// many simultaneous solutions as a fraction of that.
const STIFFNESS: f64 = 4000.0;
const FACTOR_GFLOPS: f64 = 20.0;
const FACTOR_ENTRY: f64 = 1.9;
const COLUMN: f64 = 0.03;
/// Fraction of the slave nodes that are contact candidates at a time, with as many master nodes.
const TOUCHED: f64 = 0.1;

/// Cost of shear viscosity in addition to any law [ns]: with the element data in the cache, and beyond it.
const VISCOUS: [f64; 2] = [130.0, 200.0];

/// Cost of stress relaxation with two branches in addition to a neo-Hookean law [ns], likewise.
const RELAXING: [f64; 2] = [250.0, 520.0];

/// Largest size of the element data that fits in the cache [bytes].
const CACHE_BYTES: usize = 4_000_000;

/// Time of one element for one step on one core [s], if the force evaluation reads `evaluated_bytes`; `viscous`: whether it has
/// a shear viscosity, and a Prony series.
pub fn element_s(
    material: &Material,
    (kind, formulation): (ElementKind, Formulation),
    viscous: [bool; 2],
    evaluated_bytes: usize,
) -> f64 {
    let time = material.element_time();
    let matrix = match formulation {
        Formulation::MeanDilatation | Formulation::NodalPressure => time.mean_dilatation,
        Formulation::Full => time.full,
        Formulation::Reduced => time.reduced,
    };
    let place = usize::from(evaluated_bytes > CACHE_BYTES);
    let viscous: f64 =
        [VISCOUS, RELAXING].iter().zip(viscous).filter(|(_, is)| *is).map(|(time, _)| time[place]).sum();
    let of_hexahedron = viscous + matrix[place] + material.family_count() as f64 * time.family[place];
    1e-9 * kind.relative_cost() * of_hexahedron
}

/// Amount of work in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepLoad {
    /// Elements of all meshes.
    pub elements: usize,
    /// One evaluation of all internal forces on one core [s].
    pub forces_s: f64,
    /// Nodes of all meshes.
    pub nodes: usize,
    /// Number of slave nodes of all contact pairs.
    pub slaves: usize,
}

impl StepLoad {
    /// Time of an explicit step on one core [s], if every element is active.
    pub fn explicit_step_s(&self) -> f64 {
        self.forces_s + 1e-9 * (NODE * self.nodes as f64 + SLAVE_NODE * self.slaves as f64)
    }

    /// Time of an implicit step on one core [s]: force evaluations and solutions of every iteration, and a fraction of the
    /// cost of a matrix with factor and compliances.
    pub fn implicit_step_s(&self, factor: &FactorSize) -> f64 {
        let solution = 1e-9 * FACTOR_ENTRY * factor.entries;
        let columns = 3.0 * TOUCHED * self.slaves as f64;
        let matrix = 1e-9 * (STIFFNESS * self.elements as f64 + factor.flops / FACTOR_GFLOPS)
            + columns * solution * COLUMN;
        ITERATIONS * (self.forces_s + 2.0 * solution) + MATRICES * matrix
    }
}

/// Size of the factor of the system matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FactorSize {
    /// Non-zero entries of the factor.
    pub entries: f64,
    /// Floating-point operations of one factorisation.
    pub flops: f64,
}

impl FactorSize {
    /// The size for a body whose nodes are all free, except hanging ones; only analyses, factors nothing.
    ///
    /// # Errors
    /// As [`Cholesky::new`].
    pub fn of(mesh: &Mesh) -> Result<Self, SparseError> {
        let nodes = mesh.nodes.len();
        // Nodes that cannot follow are reported when the scene is compiled.
        let followers = Arc::new(Followers::new(nodes, &mesh.hanging.ties()).unwrap_or_default());
        let unknowns = Unknowns::with_followers(
            nodes,
            |_, _| true,
            mesh.cells.iter().map(|cell| cell.nodes),
            followers,
        )?;
        let factor = Cholesky::new(&SymmetricMatrix::new(&unknowns))?;
        Ok(Self { entries: factor.entries() as f64, flops: factor.flops() })
    }
}

impl std::iter::Sum for FactorSize {
    fn sum<I: Iterator<Item = Self>>(sizes: I) -> Self {
        let add = |a: Self, b: Self| Self { entries: a.entries + b.entries, flops: a.flops + b.flops };
        sizes.fold(Self::default(), add)
    }
}
