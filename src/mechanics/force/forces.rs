//! The internal forces of all blocks: chunks swept one by one or on several threads, with the same bits.

use super::block::ElementBlock;
use super::chunk::{Chunk, ChunkForces};
use super::totals::BlockTotals;
use super::{Assembly, SweepInput, Threads};
use crate::mechanics::lanes::BATCH;
use crate::mechanics::tensor::Vec3;

/// What a sweep over all blocks writes, chunk by chunk.
#[derive(Debug)]
pub struct ElementForces {
    pub(super) chunks: Vec<ChunkForces>,
}

impl ElementForces {
    /// Buffers of all blocks.
    pub fn new(blocks: &[ElementBlock]) -> Self {
        let of_block = |(index, block)| {
            let block: &ElementBlock = block;
            (0..block.chunk_count()).map(move |chunk| ChunkForces::new(index, block, chunk))
        };
        Self { chunks: blocks.iter().enumerate().flat_map(of_block).collect() }
    }

    /// Sweeps every batch that is awake.
    pub fn sweep(&mut self, threads: &Threads, blocks: &[ElementBlock], input: &SweepInput) {
        threads.for_each(&mut self.chunks, |chunk| {
            if chunk.awake != 0 {
                blocks[chunk.block as usize].sweep(input, chunk);
            }
        });
    }

    /// Energies and extremes of one block after a sweep.
    pub fn totals(&self, block: usize) -> BlockTotals {
        let first = self.chunks.partition_point(|chunk| (chunk.block as usize) < block);
        let mut sum = BlockTotals::NONE;
        for chunk in self.chunks[first..].iter().take_while(|chunk| chunk.block as usize == block) {
            sum.add(&chunk.totals);
        }
        sum
    }

    /// Stable step [s] of every slot of a block, padding included, as of the last sweep.
    pub fn stable_steps(&self, block: usize) -> impl Iterator<Item = f64> {
        let chunks = self.chunks.iter().filter(move |chunk| chunk.block as usize == block);
        chunks.flat_map(|chunk| &chunk.batches).flat_map(|batch| batch.stable_step.0)
    }

    /// Sum of the element forces [N] at a node.
    #[inline]
    pub fn at_node(&self, assembly: &Assembly, node: usize) -> Vec3 {
        assembly.sum_at(node, &self.chunks)
    }

    /// Copies J̄ − 1 [-] and viscous pressure [Pa] of the last sweep to the arrays over all slots.
    pub fn copy_history(&self, threads: &Threads, dilatation: &mut [f64], viscous_pressure: &mut [f64]) {
        threads.for_each_run(
            Chunk::SLOTS,
            (dilatation, viscous_pressure),
            |c, dilatation, viscous_pressure| {
                let chunk = &self.chunks[c];
                if chunk.awake != 0 {
                    let rows =
                        dilatation.chunks_exact_mut(BATCH).zip(viscous_pressure.chunks_exact_mut(BATCH));
                    for ([mean, viscous], (dilatation, viscous_pressure)) in chunk.after.iter().zip(rows) {
                        dilatation.copy_from_slice(&mean.0);
                        viscous_pressure.copy_from_slice(&viscous.0);
                    }
                }
            },
        );
    }

    /// Number of elements that a sweep covers.
    pub fn awake_elements(&self, blocks: &[ElementBlock]) -> usize {
        let of_chunk = |chunk: &ChunkForces| {
            let block = &blocks[chunk.block as usize];
            let batches = &block.chunks[chunk.chunk as usize].batches;
            let all = chunk.awake.count_ones() as usize * BATCH;
            let has_padding = batches.end as usize == block.batch_count();
            let last_is_awake = chunk.awake & (1 << (batches.len() - 1)) != 0;
            all - if has_padding && last_is_awake { block.slot_count() - block.elements.len() } else { 0 }
        };
        self.chunks.iter().map(of_chunk).sum()
    }

    /// Bytes in memory.
    pub fn memory(&self) -> usize {
        let of_chunk = |chunk: &ChunkForces| {
            size_of::<ChunkForces>()
                + size_of_val(&chunk.force[..])
                + size_of_val(&chunk.viscous[..])
                + size_of_val(&chunk.u[..])
                + size_of_val(&chunk.v[..])
                + size_of_val(&chunk.after[..])
                + size_of_val(&chunk.batches[..])
        };
        self.chunks.iter().map(of_chunk).sum()
    }
}
