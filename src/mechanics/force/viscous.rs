//! Forces of viscosity and memory after the evaluation of internal forces: a pass over elements of its own for shear viscosity, where the
//! pass of the internal forces has not evaluated it (`shear_viscosity.rs`), and one for memory.

use super::block::ElementBlock;
use super::branch_totals::BranchTotals;
use super::chunk::ChunkForces;
use super::first_pass::FirstPass;
use super::memory::Memory;
use super::packed::{InBlocks, Packed, with_elements};
use super::rows::{add_in, gather_in};
use super::totals::BlockTotals;
use super::{Assembly, ElementForces, ForceInput, Threads};
use crate::lanes::{BATCH, Lane, Row, WithRegisters, dispatch_single};
use crate::registers::Registers;
use crate::tensor::Vec3;
use pulp::{Simd, WithSimd};

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
        if block.parameters.has_memory() {
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
    let has_single =
        const { E::KIND.has_single_precision() } && pass.block.parameters.has_single_precision(E::KIND);
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

#[cfg(test)]
mod tests;
