//! Energies of the branches of relaxation, each on its own: what is stored in a branch, and the work of its forces in the step.
//!
//! The work is that of the nodal forces of the branch on the displacements of the nodes, as the ledger counts it of all branches
//! together. So each element remembers the displacements of its nodes and the forces of its branches there.

use crate::force::block::ElementBlock;
use crate::force::branch_totals::ENERGIES;
use crate::force::first_pass::FirstPass;
use crate::force::packed::InBlocks;
use crate::force::rows::load_corners;
use crate::lanes::{Aligned, Lane, Row};
use crate::material::{ElasticPoint, Inelastic, Law, MAX_BRANCHES, PronySeries, SecantStiffness};
use crate::real::Real;
use crate::tensor::Sym;
use pulp::Simd;

/// History of a batch, and the energies of its branches.
pub(super) struct BranchRows<'a> {
    /// History at t_{n−1}, `None` at rest.
    pub before: Option<&'a [Row]>,
    /// History at t_n, already updated by the step.
    pub after: &'a mut [Row],
    /// Energies of the branches in the step to t_n.
    pub energies: &'a mut [Row],
}

/// Sums over the points of the elements of a register, branch by branch.
pub(super) struct BranchSums<S: Simd, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    /// Stress of each branch as a gradient in local coordinates.
    stress: Aligned<[E::Local<Lane<S>>; MAX_BRANCHES]>,
    /// Stored energy [J over the scale of the element].
    stored: Aligned<[Lane<S>; MAX_BRANCHES]>,
}

impl<S: Simd, E: InBlocks<N, Q>, const N: usize, const Q: usize> BranchSums<S, E, N, Q> {
    #[inline(always)]
    pub fn none(zero: Lane<S>) -> Self {
        Self { stress: Aligned([E::no_stress(zero); MAX_BRANCHES]), stored: Aligned([zero; MAX_BRANCHES]) }
    }

    /// Adds a point after its update, whose history at t_n is in `after`, in one-point elements for all points.
    #[inline(always)]
    pub fn add(
        &mut self,
        (simd, part, q): (S, usize, usize),
        (block, after): (&ElementBlock, &[Row]),
        (elastic, point): (&ElasticPoint<Lane<S>>, &Inelastic<Lane<S>>),
        FirstPass { cof_X, w, .. }: &FirstPass<Lane<S>, Q>,
    ) {
        let prony = &block.parameters.memory.prony;
        let history = q * block.memory_rows() + block.parameters.material.history_len();
        let points = if block.memory_points() == 1 { 0..Q } else { q..q + 1 };
        let count = prony.branches().len();
        if count == 0 {
            return;
        }
        let number = |index: usize| Lane::load(simd, &after[history + index], part);
        let stiffness = SecantStiffness::remembered(elastic, count, number);
        // Damage takes from all branches alike.
        let kept = -point.damage + 1.0;
        for branch in 0..count {
            let first = history + PronySeries::place_of_branch(branch);
            let mut H = Sym([Lane::splat(simd, 0.0); 6]);
            for (i, component) in H.0.iter_mut().enumerate() {
                *component = Lane::load(simd, &after[first + i], part);
            }
            let (S, stored) = prony.of_branch(branch, (elastic, &stiffness), &H);
            let P = elastic.k.F.dot_sym(&S.scaled(kept));
            for q in points.clone() {
                E::add_local_stress(&mut self.stress.0[branch], q, &P, &cof_X.0[q]);
                self.stored.0[branch] = w.0[q].mul_add(stored * kept, self.stored.0[branch]);
            }
        }
    }

    /// Energies of the step at the displacements `u` [m] of its end, which the elements then remember.
    #[inline(always)]
    pub fn finish(
        &self,
        (simd, part): (S, usize),
        block: &ElementBlock,
        u: &[[Row; N]; 3],
        rows: &mut BranchRows,
    ) {
        let count = block.branch_count();
        if count == 0 {
            return;
        }
        let zero = Lane::splat(simd, 0.0);
        let first = block.memory_points() * block.memory_rows();
        let before = |row: usize| rows.before.map_or(zero, |before| Lane::load(simd, &before[row], part));
        // Displacements of the step.
        let mut du = load_corners(simd, u, part);
        for (i, value) in du.as_flattened_mut().iter_mut().enumerate() {
            let now = *value;
            *value = now - before(first + i);
            now.store(&mut rows.after[first + i], part);
        }
        // Work of the forces of each branch at both ends.
        for branch in 0..count {
            let place = first + 3 * N * (branch + 1);
            let f = E::nodal_forces(&self.stress.0[branch]);
            let mut work = [zero; 2];
            for (i, (f, du)) in f.as_flattened().iter().zip(du.as_flattened()).enumerate() {
                work[0] = before(place + i).mul_add(*du, work[0]);
                work[1] = f.mul_add(*du, work[1]);
                f.store(&mut rows.after[place + i], part);
            }
            let energies = &mut rows.energies[ENERGIES * branch..ENERGIES * (branch + 1)];
            (self.stored.0[branch] * E::SCALE).store(&mut energies[0], part);
            work[0].store(&mut energies[1], part);
            work[1].store(&mut energies[2], part);
        }
    }
}
