//! Erosion: elements are deleted beyond limits of strain or damage. Their forces, stress and strain energy are removed; their mass stays at
//! the nodes.
//!
//! An element is looked at as a whole, by its mean deformation gradient `F̄ = (1/V) ∫ F dV` and its mean volume ratio. An eroded one is
//! evaluated as if nothing had moved it, so that kernels of every law and formulation know nothing of it.

use super::block::ElementBlock;
use super::branch_totals::BranchTotals;
use super::chunk::{Chunk, ChunkForces};
use super::packed::{Batch, InBlocks, Packed, with_elements};
use super::parameters::ErosionLimits;
use super::rows::{clear, gather, keep_still};
use super::{ElementForces, Threads};
use crate::element::Element;
use crate::lanes::{BATCH, Lane, Row, dispatch_rare};
use crate::material::MAX_BRANCHES;
use crate::real::Real;
use crate::tensor::{Sym, Tensor};
use pulp::{Simd, WithSimd};

/// The elements that a run has deleted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Erosion {
    /// Their global numbers, ascending.
    elements: Vec<u32>,
    /// Their lanes, a bit each: `[chunk of all blocks][batch]`; empty as long as there are none.
    lanes: Vec<Vec<u8>>,
}

/// An element beyond the limits of its part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eroding {
    /// Global number of the element.
    pub element: u32,
    /// Index of its body in the plan.
    pub body: usize,
    /// Strain energy that goes with it, that in branches of Prony series included [J].
    pub energy: f64,
    /// Energy stored in the branches of Prony series [J].
    pub in_branches: f64,
    /// Energies of each branch of relaxation.
    pub branches: [BranchTotals; MAX_BRANCHES],
    /// Block of the element.
    pub block: usize,
    chunk: usize,
    batch: usize,
    lane: usize,
}

impl Erosion {
    /// No element is eroded, as at the start.
    pub fn none() -> &'static Self {
        static NONE: Erosion = Erosion { elements: Vec::new(), lanes: Vec::new() };
        &NONE
    }

    /// Global numbers of the elements, ascending.
    pub fn elements(&self) -> &[u32] {
        &self.elements
    }

    /// Whether an element is eroded.
    pub fn contains(&self, element: u32) -> bool {
        self.elements.binary_search(&element).is_ok()
    }

    /// Gives up one more.
    pub fn add(&mut self, eroding: &Eroding, blocks: &[ElementBlock]) {
        if let Err(place) = self.elements.binary_search(&eroding.element) {
            self.elements.insert(place, eroding.element);
        }
        if self.lanes.is_empty() {
            let of_block = |block: &ElementBlock| {
                block.chunks.iter().map(|chunk| vec![0; chunk.batches.len()]).collect::<Vec<_>>()
            };
            self.lanes = blocks.iter().flat_map(of_block).collect();
        }
        self.lanes[eroding.chunk][eroding.batch] |= 1 << eroding.lane;
    }

    /// Eroding elements of a batch of a block: bit mask, one bit per lane.
    pub(super) fn of_batch(&self, block: &ElementBlock, b: usize) -> u8 {
        let lanes = self.lanes.get(block.chunk_number(b / Chunk::BATCHES));
        lanes.map_or(0, |lanes| lanes[b % Chunk::BATCHES])
    }

    /// Takes their past from the history of the elements.
    pub fn forget(&self, blocks: &[ElementBlock], history: &mut [Vec<Row>]) {
        for block in blocks.iter().filter(|block| block.history_rows() > 0) {
            for (chunk, lanes) in
                self.lanes.iter().enumerate().skip(block.chunk_number(0)).take(block.chunks.len())
            {
                for (batch, mask) in lanes.iter().enumerate().filter(|(_, mask)| **mask != 0) {
                    let rows = block.history_rows();
                    history[chunk][batch * rows..(batch + 1) * rows]
                        .iter_mut()
                        .for_each(|row| clear(*mask, row));
                }
            }
        }
    }
}

impl ElementForces {
    /// From now on these elements are deleted.
    pub fn take_out(&mut self, erosion: &Erosion) {
        for (chunk, lanes) in self.chunks.iter_mut().zip(&erosion.lanes) {
            chunk.eroded.clone_from(lanes);
            // The known lengths include those of eroded elements.
            chunk.shortest = 0.0;
        }
    }

    /// The elements that the last evaluation has found beyond the limits of their parts, and that are not deleted yet, by slot.
    pub fn find_eroding(&mut self, threads: &Threads, blocks: &[ElementBlock]) -> Vec<Eroding> {
        threads.for_each(&mut self.chunks, |chunk| blocks[chunk.block as usize].find_eroding(chunk));
        let mut found = Vec::new();
        for (number, chunk) in self.chunks.iter().enumerate() {
            let block = &blocks[chunk.block as usize];
            let rows = block.branch_rows();
            for (batch, mask) in chunk.eroding.iter().enumerate().filter(|(_, mask)| **mask != 0) {
                let first = (chunk.chunk as usize * Chunk::BATCHES + batch) * BATCH;
                let totals = &chunk.batches[batch];
                found.extend((0..BATCH).filter(|lane| mask >> lane & 1 == 1).map(|lane| Eroding {
                    element: block.elements[first + lane],
                    body: block.body,
                    energy: totals.strain.0[lane] + totals.branches.0[lane],
                    in_branches: totals.branches.0[lane],
                    branches: BranchTotals::of_lane(&chunk.branches[batch * rows..(batch + 1) * rows], lane),
                    block: chunk.block as usize,
                    chunk: number,
                    batch,
                    lane,
                }));
            }
        }
        found
    }
}

impl ElementBlock {
    /// Not inlined: the loop over chunks stands in the program twice, for one thread and for several.
    #[inline(never)]
    fn find_eroding(&self, chunk: &mut ChunkForces) {
        let block = self;
        if let Some(limits) = block.parameters.erosion {
            with_elements!(&block.packed, elements => dispatch_rare(ErosionCheck { elements, block, limits, chunk }));
        }
    }
}

/// Checks the elements of a chunk that are active and not eroded, at the displacements of its last evaluation.
struct ErosionCheck<'a, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    elements: &'a Packed<E, N, Q>,
    block: &'a ElementBlock,
    limits: ErosionLimits,
    chunk: &'a mut ChunkForces,
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd for ErosionCheck<'_, E, N, Q> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { elements, block, limits, chunk } = self;
        let first = block.chunks[chunk.chunk as usize].batches.start as usize;
        let mut u = [[Row::default(); N]; 3];
        let (mut stretch, mut ratio) = (Row::default(), Row::default());
        chunk.eroding.resize(chunk.batches.len(), 0);
        for i in 0..chunk.batches.len() {
            chunk.eroding[i] = 0;
            if chunk.active & (1 << i) == 0 {
                continue;
            }
            let batch = &elements.batches[first + i];
            gather(&batch.nodes, &chunk.u, &mut u);
            keep_still(chunk.eroded_lanes(i), &mut u);
            for part in 0..BATCH / S::F64_LANES {
                let [largest, change] = batch.mean_deformation::<S>(simd, part, &u);
                largest.store(&mut stretch, part);
                change.store(&mut ratio, part);
            }
            for lane in 0..BATCH {
                let is_beyond = stretch.0[lane] > limits.stretch * limits.stretch - 1.0
                    || ratio.0[lane] < limits.volume_ratio - 1.0
                    || chunk.batches[i].damage.0[lane] > limits.damage;
                chunk.eroding[i] |= u8::from(is_beyond) << lane;
            }
        }
    }
}

impl<E: Element<N, Q>, const N: usize, const Q: usize> Batch<E, N, Q> {
    /// Largest eigenvalue of F̄ᵀF̄, less 1, and mean volume ratio, less 1, of the elements of a register [-]; zero in padding.
    #[inline(always)]
    pub(super) fn mean_deformation<S: Simd>(&self, simd: S, part: usize, u: &[[Row; N]; 3]) -> [Lane<S>; 2] {
        let zero = Lane::splat(simd, 0.0);
        let first = self.first_pass(simd, part, u);
        let mut sum = Tensor::diagonal(zero);
        for (H, w) in first.H.0.iter().zip(&first.w.0) {
            sum = sum.plus_scaled(*w, H);
        }
        let H = sum.scaled(Lane::load(simd, &self.scaled_inverse_volume, part));
        // No closure: that would be compiled without the instruction set of the lanes.
        let mut C_minus_I = Sym([zero; 6]);
        for (sum, (a, b)) in C_minus_I.0.iter_mut().zip(Sym::<Lane<S>>::INDICES) {
            let mut product = zero;
            for c in 0..3 {
                product = H.0[c][a].mul_add(H.0[c][b], product);
            }
            *sum = H.0[a][b] + H.0[b][a] + product;
        }
        [C_minus_I.largest_principal(), first.mean]
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exactly is what is meant
mod tests;
