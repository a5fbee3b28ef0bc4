//! Forces of Prony series, see [`PronySeries`](crate::mechanics::material::PronySeries): explicit steps, after the evaluation, of any split
//! law. Eight-point elements remember at each point, one-point elements at their one.
//!
//! What is stored in a branch is told by the secant of the law: `g ψ |H|²/|S_iso|²`, exact for small strains, and for any law where
//! loading is sudden. The rest of the forces' work is dissipated.

use super::ForceInput;
use super::block::ElementBlock;
use super::chunk::ChunkForces;
use super::first_pass::FirstPass;
use super::packed::{InBlocks, Packed};
use super::reduced::OnePointBatch;
use super::rows::{add, gather, keep_still, load_fibres, store_corners};
use super::totals::BatchTotals;
use crate::mechanics::lanes::{Aligned, BATCH, Lane, Row};
use crate::mechanics::material::{
    BranchStep, Invariants, Kinematics, Law, MAX_BRANCHES, deviator_at, isochoric_stress,
};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::{Sym, Tensor};
use pulp::{Simd, WithSimd};

/// |S_iso|² over G² below which the secant is that at rest [-].
const UNSTRAINED: f64 = 1e-20;

/// The forces of the memory of a chunk, added to its viscous forces; its displacements are gathered.
pub(super) struct Memory<'a, L, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    pub law: L,
    pub elements: &'a Packed<E, N, Q>,
    pub block: &'a ElementBlock,
    pub input: &'a ForceInput<'a>,
    pub chunk: &'a mut ChunkForces,
}

impl<L: Law, E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for Memory<'_, L, E, N, Q> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { law, elements, block, input, chunk } = self;
        let h = if input.inverse_step > 0.0 { 1.0 / input.inverse_step } else { 0.0 };
        let steps = block.parameters.prony.step(h);
        let first = block.chunks[chunk.chunk as usize].batches.start as usize;
        let rows = block.history_rows();
        let before = input.history.get(block.chunk_number(chunk.chunk as usize));
        let (mut x, mut forces) = ([[Row::default(); N]; 3], [[Row::default(); N]; 3]);
        for i in (0..chunk.batches.len()).filter(|i| chunk.awake & (1 << i) != 0) {
            let nodes = &elements.batches[first + i].nodes;
            gather(nodes, &chunk.u, &mut x);
            keep_still(chunk.eroded_lanes(i), &mut x);
            let range = i * rows + block.bulk_rows()..(i + 1) * rows;
            let mut batch = BatchMemory {
                law,
                elements,
                block,
                batch: first + i,
                steps: &steps,
                before: before.map(|before| &before[range.clone()]),
                after: &mut chunk.history[range],
            };
            for part in 0..BATCH / S::F64_LANES {
                batch.eval::<S>(simd, part, &x, &mut forces, &mut chunk.batches[i]);
            }
            add(&forces, nodes, &mut chunk.viscous);
        }
    }
}

/// One batch, one law.
struct BatchMemory<'a, L, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    law: L,
    elements: &'a Packed<E, N, Q>,
    block: &'a ElementBlock,
    batch: usize,
    steps: &'a [BranchStep; MAX_BRANCHES],
    /// History at t_{n−1}, `None` at rest.
    before: Option<&'a [Row]>,
    /// History at t_n.
    after: &'a mut [Row],
}

/// What the memory of a point has to say.
struct PointMemory<R> {
    /// P [Pa].
    P: Tensor<R>,
    /// Energy stored in the branches [J/m³].
    stored: R,
    /// Upper bound of the norm of its tangent [Pa].
    stiffness: R,
}

impl<L: Law, E: InBlocks<N, Q>, const N: usize, const Q: usize> BatchMemory<'_, L, E, N, Q> {
    /// Forces [N], stored energy and critical time step of the elements of a register at displacements `u` [m].
    #[inline(always)]
    fn eval<S: Simd>(
        &mut self,
        simd: S,
        part: usize,
        u: &[[Row; N]; 3],
        forces: &mut [[Row; N]; 3],
        totals: &mut BatchTotals,
    ) {
        let zero = Lane::splat(simd, 0.0);
        let batch = &self.elements.batches[self.batch];
        let mut first_pass = batch.first_pass(simd, part, u);
        let FirstPass { cof_X, w, H, .. } = &mut first_pass;
        let reduced = self.elements.one_point.get(self.batch);
        if let Some(reduced) = reduced {
            // Of one-point elements the mean gradient.
            H.0[0] = reduced.mean_gradient(simd, part, u);
        }

        // The law where it is remembered, in a loop whose length the compiler does not know, so that it stands in the program once.
        let mut P = Aligned([Tensor::diagonal(zero); Q]);
        let (mut density, mut stiffness) = (Aligned([zero; Q]), zero);
        for q in 0..self.block.memory_points() {
            let point = self.eval_point::<S>(simd, part, q, &Kinematics::new(&H.0[q]));
            (P.0[q], density.0[q]) = (point.P, point.stored);
            stiffness = stiffness.max(point.stiffness);
        }

        let mut sums = Aligned(E::no_stress(zero));
        let mut stored = zero;
        for q in 0..Q {
            let of = if reduced.is_some() { 0 } else { q };
            E::add_local_stress(&mut sums.0, q, &P.0[of], &cof_X.0[q]);
            stored = w.0[q].mul_add(density.0[of], stored);
        }
        store_corners(&E::nodal_forces(&sums.0), forces, part);
        (stored * E::SCALE).store(&mut totals.branches, part);
        totals.shorten_step(simd, Lane::load(simd, &batch.frequency_bound, part) * stiffness, zero, part);
    }

    /// One point, whose history it takes on to t_n.
    #[inline(always)]
    fn eval_point<S: Simd>(
        &mut self,
        simd: S,
        part: usize,
        q: usize,
        k: &Kinematics<Lane<S>>,
    ) -> PointMemory<Lane<S>> {
        let zero = Lane::splat(simd, 0.0);
        let families = self.law.family_count();
        let fibres = &self.block.fibres[self.batch * families..(self.batch + 1) * families];
        let (invariants, fibres) = (Invariants::new(k), load_fibres(simd, fibres, part));
        let point = self.law.eval_with_bounds(k, &invariants, &fibres[..families]);
        let S_iso = isochoric_stress(k, &point.response);

        // The history takes a step, tensor by tensor.
        let first = q * self.block.memory_rows();
        let change = S_iso.plus_scaled(zero.constant(-1.0), &self.load_before(simd, part, first));
        store_sym(&S_iso, &mut self.after[first..], part);
        let (mut sum, mut squares, mut total_g) = (Sym([zero; 6]), zero, 0.0);
        for (b, step) in self.steps[..self.block.parameters.prony.branches().len()].iter().enumerate() {
            let place = first + 6 * (b + 1);
            let decayed = self.load_before(simd, part, place).scaled(zero.constant(step.decay));
            let H = decayed.plus_scaled(zero.constant(step.gain), &change);
            store_sym(&H, &mut self.after[place..], part);
            sum = sum.plus_scaled(zero.constant(step.g), &H);
            squares += H.norm_squared() * step.g;
            total_g += step.g;
        }

        // ψ/|S|², at rest 1/(4 G).
        let G = self.block.parameters.material.moduli_at_rest().0;
        let square = S_iso.norm_squared();
        let floor = square.constant(UNSTRAINED * G * G);
        let secant = (square - floor)
            .select_positive(point.response.psi / square.max(floor), square.constant(0.25 / G));
        // δP = δF DEV H + F δ(DEV H): by |H| and the stretches; the law's own tangent by its bound.
        let ratio = invariants.max_C * invariants.max_C_inverse;
        let geometric = sum.norm_squared().sqrt() * ratio.scale_add(4.0 / 3.0, 1.0);
        PointMemory {
            P: k.F.dot_sym(&deviator_at(k, &sum)),
            stored: squares * secant,
            stiffness: point.stiffness_bound * total_g + geometric,
        }
    }

    #[inline(always)]
    fn load_before<S: Simd>(&self, simd: S, part: usize, place: usize) -> Sym<Lane<S>> {
        self.before.map_or(Sym([Lane::splat(simd, 0.0); 6]), |before| load_sym(simd, &before[place..], part))
    }
}

/// A symmetric tensor of history, of the elements of a register.
#[inline(always)]
pub(super) fn load_sym<S: Simd>(simd: S, rows: &[Row], part: usize) -> Sym<Lane<S>> {
    let mut tensor = Sym([Lane::splat(simd, 0.0); 6]);
    for (component, row) in tensor.0.iter_mut().zip(rows) {
        *component = Lane::load(simd, row, part);
    }
    tensor
}

#[inline(always)]
fn store_sym<S: Simd>(tensor: &Sym<Lane<S>>, rows: &mut [Row], part: usize) {
    for (component, row) in tensor.0.iter().zip(rows) {
        component.store(row, part);
    }
}
