//! The linear systems of Newton's methods, dense, or sparse where few entries are non-zero.

use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::sparse::linalg::solvers::Lu;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Col, Mat};

/// Number of unknowns from which a sparse factorisation is faster.
const SPARSE_FROM: usize = 120;
/// Largest fraction of non-zero entries for which it is.
const SPARSE_DENSITY: f64 = 0.1;

/// A square system, assembled entry by entry.
#[derive(Debug)]
pub(super) struct LinearSystem {
    size: usize,
    entries: Vec<Triplet<usize, usize, f64>>,
}

/// LU factors of a dense or a sparse system.
#[derive(Debug)]
pub(super) enum Factors {
    Dense(PartialPivLu<f64>),
    Sparse(Lu<usize, f64>),
}

impl LinearSystem {
    /// An empty system of so many unknowns.
    pub fn new(size: usize) -> Self {
        Self { size, entries: Vec::new() }
    }

    /// Adds `value` to an entry.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.entries.push(Triplet::new(row, column, value));
    }

    /// LU factors; `None` if the matrix is singular.
    pub fn factorise(&self) -> Option<Factors> {
        let n = self.size;
        let density = self.entries.len() as f64 / (n * n) as f64;
        if n < SPARSE_FROM || density > SPARSE_DENSITY {
            let mut J = Mat::<f64>::zeros(n, n);
            for entry in &self.entries {
                J[(entry.row, entry.col)] += entry.val;
            }
            return Some(Factors::Dense(J.partial_piv_lu()));
        }
        let J = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &self.entries).ok()?;
        J.sp_lu().ok().map(Factors::Sparse)
    }
}

impl Factors {
    /// Solves in place; returns false if the solution is not finite.
    pub fn solve(&self, b: &mut [f64]) -> bool {
        let mut x = Col::from_fn(b.len(), |i| b[i]);
        match self {
            Self::Dense(lu) => lu.solve_in_place(x.as_mat_mut()),
            Self::Sparse(lu) => lu.solve_in_place(x.as_mat_mut()),
        }
        for (i, b) in b.iter_mut().enumerate() {
            *b = x[i];
        }
        b.iter().all(|x| x.is_finite())
    }
}
