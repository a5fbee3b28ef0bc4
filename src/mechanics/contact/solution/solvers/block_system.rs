//! The linear systems of Newton's methods in blocks of three unknowns: dense, or sparse where few blocks are not zero.

use super::block_lu::{BlockLu, Elimination, Entry};
use super::linear_system::{Factors, LinearSystem};
use crate::contact::solution::delassus::{Block, times};
use std::sync::Arc;

/// Number of unknowns from which a sparse factorisation is faster.
const SPARSE_FROM: usize = 120;
/// Largest fraction of blocks that are not zero for which it is.
const SPARSE_DENSITY: f64 = 0.1;
/// Residual relative to the right side above which a solution is refined, and above which pivots are sought in the whole matrix.
const REFINE: f64 = 1e-12;
const WRONG: f64 = 1e-6;

/// A square system, assembled block by block, again and again with nearly the same pattern.
#[derive(Debug, Default)]
pub(super) struct BlockSystem {
    blocks: usize,
    entries: Vec<Entry>,
    /// The order of elimination of the last pattern.
    elimination: Option<Arc<Elimination>>,
}

/// The factors of a system.
#[derive(Debug)]
pub(super) enum BlockFactors {
    Dense(Box<Factors>),
    Sparse { lu: BlockLu, blocks: usize, entries: Vec<Entry> },
}

impl BlockSystem {
    /// Begins a system of so many blocks of rows and columns.
    pub fn begin(&mut self, blocks: usize) {
        (self.blocks, self.entries) = (blocks, Vec::with_capacity(self.entries.len()));
    }

    /// Adds a block.
    pub fn add(&mut self, row: usize, column: usize, block: &Block) {
        self.entries.push((row as u32, column as u32, *block));
    }

    /// Factors of the system, which ends with it; `None` if the matrix is singular.
    pub fn factorise(&mut self) -> Option<BlockFactors> {
        let (blocks, entries) = (self.blocks, std::mem::take(&mut self.entries));
        let density = entries.len() as f64 / (blocks * blocks) as f64;
        if 3 * blocks < SPARSE_FROM || density > SPARSE_DENSITY {
            return whole(blocks, &entries).factorise().map(|factors| BlockFactors::Dense(Box::new(factors)));
        }
        let known = self.elimination.take().filter(|known| known.fits(blocks, &entries));
        let elimination = match known {
            Some(known) => known,
            None => Arc::new(Elimination::new(blocks, &entries).ok()?),
        };
        let lu = elimination.clone().factorise(&entries);
        self.elimination = Some(elimination);
        Some(BlockFactors::Sparse { lu, blocks, entries })
    }
}

impl BlockFactors {
    /// Solves in place; returns false if the solution is not finite.
    pub fn solve(&self, b: &mut [f64]) -> bool {
        let Self::Sparse { lu, blocks, entries } = self else {
            let Self::Dense(factors) = self else { return false };
            return factors.solve(b);
        };
        let size = norm(b);
        let mut x = b.to_vec();
        lu.solve(&mut x);
        let mut left = residual(entries, &x, b);
        if norm(&left) > REFINE * size {
            lu.solve(&mut left);
            x.iter_mut().zip(&left).for_each(|(x, more)| *x += more);
            left = residual(entries, &x, b);
        }
        if norm(&left) <= WRONG * size {
            b.copy_from_slice(&x);
            return b.iter().all(|x| x.is_finite());
        }
        whole(*blocks, entries).factorise().is_some_and(|factors| factors.solve(b))
    }
}

/// The system entry by entry.
fn whole(blocks: usize, entries: &[Entry]) -> LinearSystem {
    let mut system = LinearSystem::new(3 * blocks);
    for (row, column, block) in entries {
        for (i, values) in block.iter().enumerate() {
            for (j, &value) in values.iter().enumerate() {
                system.add(3 * *row as usize + i, 3 * *column as usize + j, value);
            }
        }
    }
    system
}

/// `b − A x`.
fn residual(entries: &[Entry], x: &[f64], b: &[f64]) -> Vec<f64> {
    let mut left = b.to_vec();
    for (row, column, block) in entries {
        let at = 3 * *column as usize;
        let product = times(block, [x[at], x[at + 1], x[at + 2]]);
        let at = 3 * *row as usize;
        left[at..at + 3].iter_mut().zip(product).for_each(|(left, product)| *left -= product);
    }
    left
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks of a grid of contacts, each coupled with those beside it; unsymmetric values.
    fn grid(side: usize, system: &mut BlockSystem) {
        system.begin(side * side);
        let value = |i: usize, j: usize, seed: usize| ((i * 31 + j * 17 + seed * 7) % 13) as f64 / 13.0 - 0.5;
        for a in 0..side * side {
            for b in 0..side * side {
                let [dx, dy] = [(a % side).abs_diff(b % side), (a / side).abs_diff(b / side)];
                if dx + dy <= 1 {
                    let own = if a == b { 4.0 } else { 0.0 };
                    let entry = |i: usize, j: usize| {
                        value(3 * a + i, 3 * b + j, a * b) + if i == j { own } else { 0.0 }
                    };
                    system.add(a, b, &[0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j))));
                }
            }
        }
    }

    #[test]
    fn sparse_solutions_are_those_of_the_whole_matrix_also_with_a_kept_order() {
        let (side, mut system) = (12, BlockSystem::default());
        let b: Vec<f64> = (0..3 * side * side).map(|i| (0.3 * i as f64).sin()).collect();
        for _ in 0..2 {
            grid(side, &mut system);
            let entries = system.entries.clone();
            let factors = system.factorise();
            assert!(matches!(factors, Some(BlockFactors::Sparse { .. })));
            let mut x = b.clone();
            assert!(factors.is_some_and(|factors| factors.solve(&mut x)));
            assert!(norm(&residual(&entries, &x, &b)) < 1e-12 * norm(&b));
            let mut other = b.clone();
            assert!(
                whole(side * side, &entries).factorise().is_some_and(|factors| factors.solve(&mut other))
            );
            let difference: Vec<f64> = x.iter().zip(&other).map(|(x, other)| x - other).collect();
            assert!(norm(&difference) < 1e-10 * norm(&other));
        }
    }
}
