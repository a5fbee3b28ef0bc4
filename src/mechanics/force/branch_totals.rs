//! Energies of one branch of relaxation of many elements.

use crate::lanes::{BATCH, Row};
use crate::material::MAX_BRANCHES;

/// Rows of the energies of a branch of a batch.
pub(super) const ENERGIES: usize = 3;

/// Energies of a branch of elements in a step [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BranchTotals {
    /// Stored at its end.
    pub stored: f64,
    /// Work of the forces at its start, and of those at its end, on the displacement of the step.
    pub work: [f64; 2],
}

impl BranchTotals {
    /// Adds those of other elements.
    pub fn add(&mut self, other: &Self) {
        self.stored += other.stored;
        self.work[0] += other.work[0];
        self.work[1] += other.work[1];
    }

    /// Sums over batches in order, each with the energies of `count` branches; one entry per branch.
    pub(super) fn of_batches(count: usize, batches: &[Row]) -> [Self; MAX_BRANCHES] {
        let mut sums = [Self::default(); MAX_BRANCHES];
        if count == 0 {
            return sums;
        }
        for batch in batches.chunks_exact(ENERGIES * count) {
            for (sum, rows) in sums.iter_mut().zip(batch.chunks_exact(ENERGIES)) {
                for lane in 0..BATCH {
                    let of_lane = Self { stored: rows[0].0[lane], work: [rows[1].0[lane], rows[2].0[lane]] };
                    sum.add(&of_lane);
                }
            }
        }
        sums
    }

    /// Energies of the branches of one element of a batch.
    pub(super) fn of_lane(batch: &[Row], lane: usize) -> [Self; MAX_BRANCHES] {
        let mut branches = [Self::default(); MAX_BRANCHES];
        for (branch, rows) in branches.iter_mut().zip(batch.chunks_exact(ENERGIES)) {
            *branch = Self { stored: rows[0].0[lane], work: [rows[1].0[lane], rows[2].0[lane]] };
        }
        branches
    }
}
