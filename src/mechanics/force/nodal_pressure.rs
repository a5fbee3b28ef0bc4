//! Averaged nodal pressure of linear tetrahedra: what keeps them from locking where they are nearly incompressible.
//!
//! One pressure a tetrahedron sets more conditions than its mesh has freedoms. So most of the volumetric energy is that of the volumes
//! around the nodes (Bonet & Burton 1998), averaged once more over the neighbours, without which the pressure still alternates; and a
//! small fraction is that of the elements themselves, which keeps their volumes together (Puso & Solberg 2006; Gee, Dohrmann, Key & Wall
//! 2009):
//!
//! ```text
//! W = Σ_e V_e [ψ_iso(F_e) + s U(J_e)] + (1 − s) Σ_a V_a U(J̃_a)      V_a = Σ_e ¼ V_e
//! J̃_a = Σ_b R_ab J_b      J_b = Σ_e ¼ V_e J_e / V_b      R_ab = Σ_e 1/16 V_e / V_a
//! ```
//!
//! over the elements e of the block at node a, or at a and b, with `s K = min(K, c G)`. R is symmetric by the weights V_a, so the exact
//! gradient is the force of an element with the pressure `s U′(J_e) + (1 − s) ¼ Σ_a p̃_a`, where `p̃_a = Σ_b R_ab U′(J̃_b)`. The energy is
//! shared out to the elements by the same means.
//!
//! The critical time step needs a bound by elements. J̃_a is a mean of the J_e, `J̃_a = Σ_e w_ae J_e`, so `(dJ̃_a)² ≤ Σ_e w_ae (dJ_e)²`
//! (Jensen), and the Hessian of the second sum is at most that of elements with a modulus that is the same mean as their pressure, of
//! `max(U″(J̃_a), 0)` in place of U′.

use super::block::ElementBlock;
use super::chunk::Chunk;
use super::nodal_volumes::{NodalState, NodalVolumes};
use super::packed::{InBlocks, Packed, with_elements};
use super::parameters::Formulation;
use super::rows::gather;
use super::{ElementForces, Threads};
use crate::lanes::{BATCH, Lane, Row};
use crate::material::Volumetric;
use crate::tensor::Vec3;
use pulp::{Simd, WithSimd};

impl ElementForces {
    /// Responses at the nodes to displacements `u` [m], of the blocks that average pressure over them.
    pub(super) fn respond_at_nodes(&mut self, threads: &Threads, blocks: &[ElementBlock], u: &[Vec3]) {
        let Self { chunks, nodal } = self;
        if nodal.iter().all(|state| state.response.is_empty()) {
            return;
        }
        threads.for_each(chunks, |chunk| {
            let block = &blocks[chunk.block as usize];
            if block.nodal_volumes.is_some() {
                block.sum_dilatations(chunk.chunk as usize, u, (&mut chunk.u, &mut chunk.dilatation));
            }
        });
        for ((index, block), state) in blocks.iter().enumerate().zip(nodal) {
            let Some((volumes, U)) = block.averaged() else { continue };
            let first = chunks.partition_point(|chunk| (chunk.block as usize) < index);
            let chunks = &chunks[first..];
            volumes.respond(threads, U, state, |chunk| &chunks[chunk].dilatation);
        }
    }
}

impl ElementBlock {
    /// Dilatations and responses at the nodes of the block to displacements `u` [m]; empty in other formulations.
    pub(super) fn nodal_state(&self, u: &[Vec3]) -> NodalState {
        let mut state = NodalState::of(self.nodal_volumes.as_ref());
        let Some((volumes, U)) = self.averaged() else { return state };
        let of_chunk = |chunk: usize| {
            let count = self.nodes_of_chunk(chunk).len();
            let (mut local, mut sums) = (vec![Vec3::zeros(); count], vec![0.0; count]);
            self.sum_dilatations(chunk, u, (&mut local, &mut sums));
            sums
        };
        let sums: Vec<Vec<f64>> = (0..self.chunk_count()).map(of_chunk).collect();
        volumes.respond(&Threads::ONE, U, &mut state, |chunk| &sums[chunk]);
        state
    }

    /// The volumes around its nodes with U(J), where pressure is averaged over nodes.
    pub(super) fn averaged(&self) -> Option<(&NodalVolumes, Volumetric)> {
        Some((self.nodal_volumes.as_ref()?, self.parameters.material.volumetric()?))
    }

    /// Gathers the displacements of a chunk [m] and sums ¼ V_e (J_e − 1) [m³] at its nodes.
    fn sum_dilatations(&self, chunk: usize, u: &[Vec3], (local, sums): (&mut [Vec3], &mut [f64])) {
        for (local, node) in local.iter_mut().zip(self.nodes_of_chunk(chunk)) {
            *local = u[*node as usize];
        }
        sums.fill(0.0);
        let (chunk, u) = (&self.chunks[chunk], &*local);
        with_elements!(&self.packed, elements => pulp::Arch::new().dispatch(Dilatations { elements, chunk, u, sums }));
    }
}

/// The sums of a chunk.
struct Dilatations<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    elements: &'a Packed<E, N, Q>,
    chunk: &'a Chunk,
    /// Displacements of its nodes [m].
    u: &'a [Vec3],
    sums: &'a mut [f64],
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for Dilatations<'_, E, N, Q> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // The condition is a constant: nothing is compiled for elements without the formulation.
        if !const { Formulation::NodalPressure.is_of(E::KIND) } {
            return;
        }
        let mut u = [[Row::default(); N]; 3];
        let mut part_of_node = Row::default();
        let range = &self.chunk.batches;
        for batch in &self.elements.batches[range.start as usize..range.end as usize] {
            gather(&batch.nodes, self.u, &mut u);
            for part in 0..BATCH / S::F64_LANES {
                let mean = batch.first_pass(simd, part, &u).mean;
                let volume = Lane::load(simd, &batch.volume, part) * const { 1.0 / N as f64 };
                (volume * mean).store(&mut part_of_node, part);
            }
            for nodes in &batch.nodes {
                for (lane, node) in nodes.iter().enumerate() {
                    self.sums[*node as usize] += part_of_node.0[lane];
                }
            }
        }
    }
}
