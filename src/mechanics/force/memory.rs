//! Forces of stresses with a history, after the evaluation: of a law's internal variables, and of each [`Memory`](crate::material::Memory).
//! Eight-point elements remember at each point, one-point elements at their one.

mod branches;
mod softening;

pub(super) use softening::Tension;

use super::ForceInput;
use super::block::ElementBlock;
use super::chunk::ChunkForces;
use super::first_pass::FirstPass;
use super::packed::{InBlocks, Packed};
use super::parameters::{BlockParameters, Formulation};
use super::reduced::OnePointBatch;
use super::rows::{add, gather, keep_still, load_fibres, store_corners};
use super::totals::BatchTotals;
use crate::dual::Dual;
use crate::lanes::{Aligned, BATCH, Lane, Row};
use crate::material::{
    ElasticPoint, History, Inelastic, Invariants, Kinematics, Law, MAX_FAMILIES, MemorySteps,
    isochoric_stress, volume_change,
};
use crate::real::{Outlined, Real, inverse_cbrt_m1};
use crate::tensor::Tensor;
use branches::{BranchRows, BranchSums};
use pulp::{Simd, WithSimd};
use softening::{Lost, LostAtPoints};

/// The forces of the history of a chunk, whose displacements are gathered: of internal variables and relaxation added to its viscous
/// forces, of softening to its internal forces.
pub(super) struct Memory<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    pub elements: &'a Packed<E, N, Q>,
    pub block: &'a ElementBlock,
    pub input: &'a ForceInput<'a>,
    pub chunk: &'a mut ChunkForces,
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for Memory<'_, E, N, Q> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { elements, block, input, chunk } = self;
        let h = if input.inverse_step > 0.0 { 1.0 / input.inverse_step } else { 0.0 };
        let (steps, softens) = (block.parameters.memory.step(h), block.parameters.memory.softens());
        let first = block.chunks[chunk.chunk as usize].batches.start as usize;
        let rows = block.history_rows();
        let before = input.history.get(block.chunk_number(chunk.chunk as usize));
        let branch_rows = block.branch_rows();
        let none = [[Row::default(); N]; 3];
        let mut first_pass = FirstPass::new(Lane::splat(simd, 0.0));
        let (mut x, mut forces) = (none, MemoryForces { relaxing: none, lost: none });
        for i in (0..chunk.batches.len()).filter(|i| chunk.active & (1 << i) != 0) {
            let nodes = &elements.batches[first + i].nodes;
            gather(nodes, &chunk.u, &mut x);
            keep_still(chunk.eroded_lanes(i), &mut x);
            let range = i * rows + block.bulk_rows()..(i + 1) * rows;
            let mut batch = BatchMemory {
                elements,
                block,
                batch: first + i,
                steps: &steps,
                // Of no interest to relaxation.
                size: if softens { sizes(&elements.batches[first + i].volume) } else { Row([1.0; BATCH]) },
                before: before.map(|before| &before[range.clone()]),
                after: &mut chunk.history[range],
                branches: &mut chunk.branches[i * branch_rows..(i + 1) * branch_rows],
            };
            for part in 0..BATCH / S::F64_LANES {
                batch.eval::<S>(simd, part, (&x, &mut first_pass), &mut forces, &mut chunk.batches[i]);
            }
            add(&forces.relaxing, nodes, &mut chunk.viscous);
            if softens {
                add(&forces.lost, nodes, &mut chunk.force);
            }
        }
    }
}

/// Forces of a batch [N], `[component][node]`.
struct MemoryForces<const N: usize> {
    /// Forces of [`Inelastic::S`].
    relaxing: [[Row; N]; 3],
    /// Forces of the stress removed by damage; not set without softening.
    lost: [[Row; N]; 3],
}

/// A batch in a step, with its history.
struct BatchMemory<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    elements: &'a Packed<E, N, Q>,
    block: &'a ElementBlock,
    batch: usize,
    steps: &'a MemorySteps,
    /// Edges of cubes of the volumes of the elements [m].
    size: Row,
    /// History at t_{n−1}, `None` at rest.
    before: Option<&'a [Row]>,
    /// History at t_n, which the pass writes.
    after: &'a mut [Row],
    /// Energies of the branches of relaxation in the step to t_n, see [`BranchTotals`](super::BranchTotals).
    branches: &'a mut [Row],
}

/// The history of one point, in lanes.
struct LaneHistory<'a, S> {
    simd: S,
    part: usize,
    before: Option<&'a [Row]>,
    after: &'a mut [Row],
}

impl<S: Simd> History<Lane<S>> for LaneHistory<'_, S> {
    #[inline(always)]
    fn before(&self, index: usize) -> Lane<S> {
        match self.before {
            Some(before) => Lane::load(self.simd, &before[index], self.part),
            None => Lane::splat(self.simd, 0.0),
        }
    }
    #[inline(always)]
    fn set(&mut self, index: usize, value: Lane<S>) {
        value.store(&mut self.after[index], self.part);
    }
}

/// The history of a point at a time of which the stress is requested: it stays as it is.
pub(super) struct Past<'a, S> {
    pub simd: S,
    pub part: usize,
    pub rows: &'a [Row],
}

impl<S: Simd> History<Lane<S>> for Past<'_, S> {
    #[inline(always)]
    fn before(&self, index: usize) -> Lane<S> {
        Lane::load(self.simd, &self.rows[index], self.part)
    }
    #[inline(always)]
    fn set(&mut self, _: usize, _: Lane<S>) {}
}

/// History without derivative: the past does not depend on the end of the step.
impl<S: Simd> History<Dual<Lane<S>>> for Past<'_, S> {
    #[inline(always)]
    fn before(&self, index: usize) -> Dual<Lane<S>> {
        let value = Lane::load(self.simd, &self.rows[index], self.part);
        Dual { value, slope: value.zero() }
    }
    #[inline(always)]
    fn set(&mut self, _: usize, _: Dual<Lane<S>>) {}
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> BatchMemory<'_, E, N, Q> {
    /// Forces [N], stored energy and critical time step of the elements of a register at displacements `u` [m].
    #[inline(always)]
    fn eval<S: Simd>(
        &mut self,
        simd: S,
        part: usize,
        (u, first_pass): (&[[Row; N]; 3], &mut FirstPass<Lane<S>, Q>),
        forces: &mut MemoryForces<N>,
        totals: &mut BatchTotals,
    ) {
        let zero = Lane::splat(simd, 0.0);
        let batch = &self.elements.batches[self.batch];
        batch.first_pass_to(simd, part, u, first_pass);
        let tension = Tension::new(self.block, first_pass.mean);
        let reduced = self.elements.one_point.get(self.batch);
        if let Some(reduced) = reduced {
            // One-point elements use the mean gradient.
            first_pass.H.0[0] = reduced.mean_gradient(simd, part, u);
            first_pass.j.0[0] = volume_change(&first_pass.H.0[0]);
        }
        let FirstPass { cof_X, w, H, j, .. } = &*first_pass;
        // The iteration of a root is one long chain of operations: alone in a loop, those of several points overlap.
        let mut a = Aligned([zero; Q]);
        for q in 0..self.block.memory_points() {
            a.0[q] = inverse_cbrt_m1(j.0[q]);
        }

        // The law where it is remembered.
        let mut P = Aligned([Tensor::diagonal(zero); Q]);
        let mut lost = Aligned([Lost::none(zero); Q]);
        let (mut density, mut stiffness) = (Aligned([zero; Q]), zero);
        let fibres = load_fibres(simd, self.block.fibres_of(self.batch), part);
        let mut branches = BranchSums::<S, E, N, Q>::none(zero);
        for q in 0..self.block.memory_points() {
            let k = Kinematics::with_volume_change(&H.0[q], j.0[q], a.0[q]);
            let (elastic, point) = zero.outlined(PointInStep {
                block: self.block,
                steps: self.steps,
                k: &k,
                fibres: &fibres,
                tension: tension.energy(&k),
                size: Lane::load(simd, &self.size, part),
                history: self.history_of(simd, part, q),
            });
            (P.0[q], density.0[q]) = (k.F.dot_sym(&point.S), point.stored);
            stiffness = stiffness.max(point.stiffness);
            branches.add((simd, part, q), (self.block, self.after), (&elastic, &point), first_pass);
            lost.0[q] = Lost::new(&elastic, &point, tension.pressure(&k));
        }
        if self.block.parameters.memory.softens() {
            let lost = LostAtPoints {
                points: &lost.0,
                is_one_point: reduced.is_some(),
                has_mean_dilatation: self.block.parameters.formulation == Formulation::MeanDilatation,
            };
            batch.soften((simd, part), first_pass, &lost, &mut forces.lost, totals);
        }

        let mut sums = Aligned(E::no_stress(zero));
        let mut stored = zero;
        for q in 0..Q {
            let of = if reduced.is_some() { 0 } else { q };
            E::add_local_stress(&mut sums.0, q, &P.0[of], &cof_X.0[q]);
            stored = w.0[q].mul_add(density.0[of], stored);
        }
        store_corners(&E::nodal_forces(&sums.0), &mut forces.relaxing, part);
        let mut rows = BranchRows { before: self.before, after: self.after, energies: self.branches };
        branches.finish((simd, part), self.block, u, &mut rows);
        (stored * E::SCALE).store(&mut totals.branches, part);
        totals.shorten_step(simd, Lane::load(simd, &batch.frequency_bound, part) * stiffness, zero, part);
    }

    /// History of a point.
    #[inline(always)]
    fn history_of<S: Simd>(&mut self, simd: S, part: usize, q: usize) -> LaneHistory<'_, S> {
        let rows = self.block.memory_rows();
        let range = q * rows..(q + 1) * rows;
        let before = self.before.map(|before| &before[range.clone()]);
        LaneHistory { simd, part, before, after: &mut self.after[range] }
    }
}

/// A point whose history is taken on to t_n.
struct PointInStep<'a, 'k, S: Simd> {
    block: &'a ElementBlock,
    steps: &'a MemorySteps,
    k: &'k Kinematics<Lane<S>>,
    fibres: &'a [[Lane<S>; 3]; MAX_FAMILIES],
    /// U(J) in tension [J/m³].
    tension: Lane<S>,
    /// Edge of a cube of the volume of the element [m].
    size: Lane<S>,
    history: LaneHistory<'a, S>,
}

impl<'k, S: Simd> Outlined for PointInStep<'_, 'k, S> {
    type Output = (ElasticPoint<'k, Lane<S>>, Inelastic<Lane<S>>);

    #[inline(always)]
    fn run(mut self) -> Self::Output {
        let parameters = &self.block.parameters;
        let fibres = &self.fibres[..parameters.material.family_count()];
        let of_element = (self.tension, self.size);
        take_over_step(parameters, self.steps, (self.k, fibres), of_element, &mut self.history)
    }
}

/// Takes the history of a point over a step; the elastic response there, and what the history adds to it. With U in tension [J/m³] and the
/// size of the element [m].
#[inline(always)]
pub(super) fn take_over_step<'a, R: Real>(
    parameters: &BlockParameters,
    steps: &MemorySteps,
    (k, fibres): (&'a Kinematics<R>, &[[R; 3]]),
    (tension, size): (R, R),
    history: &mut impl History<R>,
) -> (ElasticPoint<'a, R>, Inelastic<R>) {
    let law = &parameters.material;
    let invariants = Invariants::new(k);
    let point = law.eval_with_bounds(k, &invariants, fibres);
    let elastic = ElasticPoint {
        k,
        psi: point.response.psi,
        tension,
        S_iso: isochoric_stress(k, &point.response),
        stiffness_bound: point.stiffness_bound,
        condition: invariants.max_C * invariants.max_C_inverse,
        size,
        shear_modulus: law.moduli_at_rest().0,
    };
    let inelastic = parameters.memory.update(law, steps, (&elastic, fibres), history);
    (elastic, inelastic)
}

/// Edges of cubes of the volumes of a batch [m]; 1 in padding.
pub(super) fn sizes(volume: &Row) -> Row {
    Row(volume.0.map(|V| if V > 0.0 { V.cbrt() } else { 1.0 }))
}

#[cfg(test)]
mod tests;
