//! Shear viscosity of a part (Kelvin–Voigt): forces after the evaluation, of any law and formulation.
//!
//! ```text
//! l = Ḟ F⁻¹        σ_v = η dev(l + lᵀ) = (η/J) dev(s + sᵀ)        s = Ḟ cof Fᵀ = J l        P_v = σ_v cof F
//! ```
//!
//! with Ḟ of the half step before t_n in explicit steps, and at its end in implicit ones. Everything is taken at the points of the element, of one-point hexahedra at 2×2×2 too: their hourglass modes are
//! damped like any other motion. There and in crushed elements J may come near zero or below, so that 1/J is capped: the
//! stress stays objective and dissipates, whatever J.

use super::block::ElementBlock;
use super::branch_totals::BranchTotals;
use super::chunk::ChunkForces;
use super::first_pass::FirstPass;
use super::memory::Memory;
use super::packed::{Batch, InBlocks, Packed, with_elements};
use super::parameters::BlockParameters;
use super::rows::{add_in, gather_in, load_corners, store_corners};
use super::totals::{BatchTotals, BlockTotals};
use super::{Assembly, ElementForces, ForceInput, Threads};
use crate::element::Element;
use crate::lanes::{Aligned, BATCH, Lane, Row, WithRegisters, dispatch_single};
use crate::material::bound_largest;
use crate::real::{Outlined, Real};
use crate::registers::Registers;
use crate::tensor::{Sym, Tensor, Vec3};
use pulp::{Simd, WithSimd};

/// J below which 1/J grows no further [-].
const LEAST_J: f64 = 0.2;

/// Viscous Cauchy stress over the viscosity, `σ_v/η = dev(s + sᵀ)/J` [1/s], of the rate Ḟ [1/s] at `j = J − 1`.
#[inline(always)]
pub(super) fn stress_over_viscosity<R: Real>(rate: &Tensor<R>, cof_F: &Tensor<R>, j: R) -> Sym<R> {
    let s = rate.dot_transposed(cof_F);
    // Loops, not closures: those would be compiled without the instruction set of the lanes.
    let mut twice = Sym([j; 6]);
    for (sum, (a, b)) in twice.0.iter_mut().zip(Sym::<R>::INDICES) {
        *sum = s.0[a][b] + s.0[b][a];
    }
    twice.deviator().scaled(inverse_J(j))
}

/// First Piola–Kirchhoff stress P_v [Pa] of a viscosity η [Pa s] at the rate Ḟ [1/s] and `j = J − 1`.
#[inline(always)]
pub(super) fn viscous_stress<R: Real>(eta: f64, rate: &Tensor<R>, cof_F: &Tensor<R>, j: R) -> Tensor<R> {
    let zero = j.zero();
    let sigma = stress_over_viscosity(rate, cof_F, j).scaled(zero.constant(eta));
    let mut P = Tensor([[zero; 3]; 3]);
    for a in 0..3 {
        for b in 0..3 {
            for c in 0..3 {
                P.0[a][b] = sigma.at(a, c).mul_add(cof_F.0[c][b], P.0[a][b]);
            }
        }
    }
    P
}

/// 1/J, capped where an element is nearly crushed [-].
#[inline(always)]
fn inverse_J<R: Real>(j: R) -> R {
    j.constant(1.0) / (j + 1.0).max(j.constant(LEAST_J))
}

impl ElementForces {
    /// Adds the forces of viscosity and memory of all blocks that have any, at velocities `v` [m/s], nodes × 3, to what the evaluation of the
    /// same `input` left: forces of their own, see [`ElementForces::viscous_at_node`], history, and a shorter critical time step.
    pub fn add_viscous(
        &mut self,
        threads: &Threads,
        blocks: &[ElementBlock],
        input: &ForceInput,
        v: &[Vec3],
    ) {
        threads.for_each(&mut self.chunks, |chunk| blocks[chunk.block as usize].add_viscous(input, v, chunk));
    }

    /// Sum of the viscous forces [N] at a node.
    #[inline]
    pub fn viscous_at_node(&self, assembly: &Assembly, node: usize) -> Vec3 {
        assembly.sum_at(node, |chunk, i| self.chunks[chunk].viscous.get(i).copied().unwrap_or_default())
    }
}

impl ElementBlock {
    /// [`ElementForces::add_viscous`] of a chunk. Not inlined: the loop over chunks stands in the program twice, for one thread and for several.
    #[inline(never)]
    fn add_viscous(&self, input: &ForceInput, v: &[Vec3], chunk: &mut ChunkForces) {
        let block = self;
        if !block.parameters.is_viscous() || chunk.active == 0 {
            return;
        }
        let arch = pulp::Arch::new();
        if !chunk.has_shear_viscosity {
            for (u, node) in chunk.u.iter_mut().zip(block.nodes_of_chunk(chunk.chunk as usize)) {
                *u = input.u[*node as usize];
            }
            chunk.begin_viscous(block, v);
            if block.parameters.shear_viscosity > 0.0 {
                with_elements!(&block.packed, elements => eval_viscous(Viscous { elements, block, chunk }));
            }
        }
        if !block.parameters.memory.is_empty() {
            with_elements!(&block.packed, elements => arch.dispatch(Memory { elements, block, input, chunk }));
            chunk.branch_totals = BranchTotals::of_batches(block.branch_count(), &chunk.branches);
        }
        let first = block.chunks[chunk.chunk as usize].batches.start as usize;
        chunk.totals = BlockTotals::of_batches(first * BATCH, &chunk.batches);
    }
}

/// The viscous forces of a chunk, from its displacements and velocities.
struct Viscous<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    elements: &'a Packed<E, N, Q>,
    block: &'a ElementBlock,
    chunk: &'a mut ChunkForces,
}

/// Evaluates them in the precision of the block.
fn eval_viscous<E: InBlocks<N, Q>, const N: usize, const Q: usize>(pass: Viscous<E, N, Q>) {
    let has_single = const { BlockParameters::may_be_single(E::KIND) }
        && pass.block.parameters.has_single_precision(E::KIND);
    if !has_single {
        return pulp::Arch::new().dispatch(pass);
    }
    if let Err(pass) = dispatch_single(pass) {
        pulp::Arch::new().dispatch(pass);
    }
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for Viscous<'_, E, N, Q> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.with_registers(simd);
    }
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithRegisters for Viscous<'_, E, N, Q> {
    #[inline(always)]
    fn with_registers<S: Registers>(self, simd: S) {
        let Self { elements, block, chunk } = self;
        let first = block.chunks[chunk.chunk as usize].batches.start as usize;
        let (mut x, mut rates) = ([[Row::default(); N]; 3], [[Row::default(); N]; 3]);
        let mut first_pass = FirstPass::new(Lane::splat(simd, 0.0));
        for i in (0..chunk.batches.len()).filter(|i| chunk.active & (1 << i) != 0) {
            let batch = &elements.batches[first + i];
            gather_in::<S, N>(&batch.nodes, &chunk.u, chunk.eroded_lanes(i), &mut x);
            gather_in::<S, N>(&batch.nodes, &chunk.v, chunk.eroded_lanes(i), &mut rates);
            for part in 0..BATCH / S::LANES {
                let eta = block.parameters.shear_viscosity;
                batch.first_pass_to(simd, part, &x, &mut first_pass);
                batch.viscous_forces::<S>(simd, part, eta, &first_pass, &mut rates, &mut chunk.batches[i]);
            }
            add_in::<S, N>(&mut rates, &batch.nodes, &mut chunk.viscous);
        }
    }
}

impl ChunkForces {
    /// Takes the velocities [m/s] of its nodes, and sets the forces of viscosity and memory to zero.
    pub(super) fn begin_viscous(&mut self, block: &ElementBlock, v: &[Vec3]) {
        self.viscous.fill(Vec3::zeros());
        for (of_chunk, node) in self.v.iter_mut().zip(block.nodes_of_chunk(self.chunk as usize)) {
            *of_chunk = v[*node as usize];
        }
    }
}

/// Shear viscosity of the elements of a register, within the pass of the internal forces: one copy for all laws.
pub(super) struct ShearViscosity<'a, S: Registers, E: Element<N, Q>, const N: usize, const Q: usize> {
    pub simd: S,
    pub batch: &'a Batch<E, N, Q>,
    pub part: usize,
    /// Viscosity η [Pa s].
    pub eta: f64,
    pub first: &'a FirstPass<Lane<S>, Q>,
    /// Velocities on entry [m/s], viscous forces on return [N]: `[component][node]`.
    pub rates: &'a mut [[Row; N]; 3],
    pub totals: &'a mut BatchTotals,
}

impl<S: Registers, E: Element<N, Q>, const N: usize, const Q: usize> Outlined
    for ShearViscosity<'_, S, E, N, Q>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { simd, batch, part, eta, first, rates, totals } = self;
        batch.viscous_forces::<S>(simd, part, eta, first, rates, totals);
    }
}

impl<E: Element<N, Q>, const N: usize, const Q: usize> Batch<E, N, Q> {
    /// Replaces the velocities [m/s] of the elements of a register by their viscous forces [N].
    #[inline(always)]
    fn viscous_forces<S: Registers>(
        &self,
        simd: S,
        part: usize,
        eta: f64,
        first: &FirstPass<Lane<S>, Q>,
        rates: &mut [[Row; N]; 3],
        totals: &mut BatchTotals,
    ) {
        let zero = Lane::splat(simd, 0.0);
        let identity = Tensor::diagonal(zero.constant(1.0));
        let local_v = Aligned(E::local_gradients(&load_corners(simd, rates, part)));
        let mut sums = Aligned(E::no_stress(zero));
        let mut largest = zero;
        for q in 0..Q {
            let (cof_X, j) = (&first.cof_X.0[q], first.j.0[q]);
            let rate = self.gradient_at(simd, part, &local_v.0, (q, cof_X));
            let cof_F = first.H.0[q].plus(&identity).cofactor();

            let P = viscous_stress(eta, &rate, &cof_F, j);
            E::add_local_stress(&mut sums.0, q, &P, cof_X);

            // |P_v| ≤ 2 η/J |cof F|² |Ḟ|, by the largest eigenvalue of cof Fᵀ cof F.
            let mut square = Sym([zero; 6]);
            for (sum, (a, b)) in square.0.iter_mut().zip(Sym::<Lane<S>>::INDICES) {
                for c in 0..3 {
                    *sum = cof_F.0[c][a].mul_add(cof_F.0[c][b], *sum);
                }
            }
            let norm = bound_largest(square.trace() * (1.0 / 3.0), square.deviator().norm_squared());
            largest = largest.max(norm * inverse_J(j) * (2.0 * eta));
        }
        store_corners(&E::nodal_forces(&sums.0), rates, part);

        let half = Lane::load(simd, &self.frequency_bound, part) * largest * 0.5;
        totals.shorten_step(simd, zero, half, part);
    }
}

#[cfg(test)]
mod tests;
