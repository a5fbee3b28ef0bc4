//! The linear systems of Newton's methods, of 3×3 blocks: dense, or sparse where few blocks are there.

use crate::mechanics::contact::delassus::Block;
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::sparse::linalg::solvers::Lu;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Col, Mat};

/// Unknowns from which a sparse factorisation pays.
const SPARSE_FROM: usize = 120;
/// The largest share of blocks that are there with which it pays.
const SPARSE_SHARE: f64 = 0.1;

/// A square system of blocks, gathered block by block.
#[derive(Debug)]
pub(super) struct BlockSystem {
    size: usize,
    blocks: Vec<(u32, u32, Block)>,
}

/// A factorised system.
#[derive(Debug)]
pub(super) enum Factors {
    Dense(PartialPivLu<f64>),
    Sparse(Lu<usize, f64>),
}

impl BlockSystem {
    /// With so many rows of blocks.
    pub fn new(rows: usize) -> Self {
        Self { size: 3 * rows, blocks: Vec::new() }
    }

    /// Adds to a block.
    pub fn add(&mut self, row: usize, column: usize, block: Block) {
        self.blocks.push((row as u32, column as u32, block));
    }

    /// LU factors; `None` if the matrix has no pivots left.
    pub fn factorise(&self) -> Option<Factors> {
        let n = self.size;
        let share = (9 * self.blocks.len()) as f64 / (n * n) as f64;
        if n < SPARSE_FROM || share > SPARSE_SHARE {
            let mut J = Mat::<f64>::zeros(n, n);
            self.for_each(|i, j, x| J[(i, j)] += x);
            return Some(Factors::Dense(J.partial_piv_lu()));
        }
        let mut triplets = Vec::with_capacity(9 * self.blocks.len());
        self.for_each(|i, j, x| triplets.push(Triplet::new(i, j, x)));
        let J = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets).ok()?;
        J.sp_lu().ok().map(Factors::Sparse)
    }

    fn for_each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for &(row, column, ref block) in &self.blocks {
            for (i, values) in block.iter().enumerate() {
                for (j, &x) in values.iter().enumerate() {
                    visit(3 * row as usize + i, 3 * column as usize + j, x);
                }
            }
        }
    }
}

impl Factors {
    /// Solves in place; false if the solution is not finite.
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
