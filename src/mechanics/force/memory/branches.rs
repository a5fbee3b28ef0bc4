//! Energies of the branches of relaxation, each on its own: what is stored in a branch, and the work of its forces in the step.
//!
//! The work is that of the nodal forces of the branch on the displacements of the nodes, as the ledger counts it of all branches
//! together. So each element remembers the displacements of its nodes and the forces of its branches there.

use super::BatchMemory;
use crate::mechanics::force::block::ElementBlock;
use crate::mechanics::force::first_pass::FirstPass;
use crate::mechanics::force::packed::InBlocks;
use crate::mechanics::force::rows::load_corners;
use crate::mechanics::lanes::{Aligned, BATCH, Lane, Row};
use crate::mechanics::material::{ElasticPoint, Inelastic, MAX_BRANCHES, PronySeries};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::Sym;
use pulp::Simd;

/// Rows of the energies of a branch of a batch.
const ENERGIES: usize = 3;

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

    /// Of batches in order, each with the energies of `count` branches: branch by branch.
    pub(in crate::mechanics::force) fn of_batches(count: usize, batches: &[Row]) -> [Self; MAX_BRANCHES] {
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
    pub(in crate::mechanics::force) fn of_lane(batch: &[Row], lane: usize) -> [Self; MAX_BRANCHES] {
        let mut branches = [Self::default(); MAX_BRANCHES];
        for (branch, rows) in branches.iter_mut().zip(batch.chunks_exact(ENERGIES)) {
            *branch = Self { stored: rows[0].0[lane], work: [rows[1].0[lane], rows[2].0[lane]] };
        }
        branches
    }
}

impl ElementBlock {
    /// Branches of relaxation.
    pub fn branch_count(&self) -> usize {
        self.parameters.memory.prony.branches().len()
    }

    /// Rows of the energies of the branches of a batch.
    pub(in crate::mechanics::force) fn branch_rows(&self) -> usize {
        ENERGIES * self.branch_count()
    }
}

/// Sums over the points of the elements of a register, branch by branch.
pub(super) struct BranchSums<S: Simd, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    /// Local stress.
    stress: Aligned<[E::Local<Lane<S>>; MAX_BRANCHES]>,
    /// Stored energy [J over the scale of the element].
    stored: Aligned<[Lane<S>; MAX_BRANCHES]>,
}

impl<S: Simd, E: InBlocks<N, Q>, const N: usize, const Q: usize> BranchSums<S, E, N, Q> {
    #[inline(always)]
    pub fn none(zero: Lane<S>) -> Self {
        Self { stress: Aligned([E::no_stress(zero); MAX_BRANCHES]), stored: Aligned([zero; MAX_BRANCHES]) }
    }
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> BatchMemory<'_, E, N, Q> {
    /// Adds a point after its update, in one-point elements for all points.
    #[inline(always)]
    pub(super) fn add_branches<S: Simd>(
        &self,
        (simd, part, q): (S, usize, usize),
        elastic: &ElasticPoint<Lane<S>>,
        point: &Inelastic<Lane<S>>,
        FirstPass { cof_X, w, .. }: &FirstPass<Lane<S>, Q>,
        sums: &mut BranchSums<S, E, N, Q>,
    ) {
        let prony = &self.block.parameters.memory.prony;
        let history = q * self.block.memory_rows();
        let points = if self.block.memory_points() == 1 { 0..Q } else { q..q + 1 };
        // Damage takes from all branches alike.
        let kept = -point.damage + 1.0;
        for branch in 0..prony.branches().len() {
            let first = history + PronySeries::place_of_branch(branch);
            let mut H = Sym([Lane::splat(simd, 0.0); 6]);
            for (i, component) in H.0.iter_mut().enumerate() {
                *component = Lane::load(simd, &self.after[first + i], part);
            }
            let (S, stored) = prony.of_branch(branch, elastic, &H);
            let P = elastic.k.F.dot_sym(&S.scaled(kept));
            for q in points.clone() {
                E::add_local_stress(&mut sums.stress.0[branch], q, &P, &cof_X.0[q]);
                sums.stored.0[branch] = w.0[q].mul_add(stored * kept, sums.stored.0[branch]);
            }
        }
    }

    /// Energies of the step at the displacements `u` [m] of its end, which the elements then remember.
    #[inline(always)]
    pub(super) fn finish_branches<S: Simd>(
        &mut self,
        (simd, part): (S, usize),
        u: &[[Row; N]; 3],
        sums: &BranchSums<S, E, N, Q>,
    ) {
        let count = self.block.branch_count();
        if count == 0 {
            return;
        }
        let zero = Lane::splat(simd, 0.0);
        let first = self.block.memory_points() * self.block.memory_rows();
        let before = |row: usize| self.before.map_or(zero, |before| Lane::load(simd, &before[row], part));
        // Displacements of the step.
        let mut du = load_corners(simd, u, part);
        for (i, value) in du.as_flattened_mut().iter_mut().enumerate() {
            let now = *value;
            *value = now - before(first + i);
            now.store(&mut self.after[first + i], part);
        }
        // Work of the forces of each branch at both ends.
        for branch in 0..count {
            let place = first + 3 * N * (branch + 1);
            let f = E::nodal_forces(&sums.stress.0[branch]);
            let mut work = [zero; 2];
            for (i, (f, du)) in f.as_flattened().iter().zip(du.as_flattened()).enumerate() {
                work[0] = before(place + i).mul_add(*du, work[0]);
                work[1] = f.mul_add(*du, work[1]);
                f.store(&mut self.after[place + i], part);
            }
            let energies = &mut self.branches[ENERGIES * branch..ENERGIES * (branch + 1)];
            (sums.stored.0[branch] * E::SCALE).store(&mut energies[0], part);
            work[0].store(&mut energies[1], part);
            work[1].store(&mut energies[2], part);
        }
    }
}
