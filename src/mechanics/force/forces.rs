//! The internal forces of all blocks: chunks evaluated one by one or on several threads, with the same bits.

use super::block::ElementBlock;
use super::branch_totals::BranchTotals;
use super::chunk::{Chunk, ChunkForces};
use super::internal::{Evaluation, ForceInput, GaussPoints};
use super::nodal_volumes::NodalState;
use super::one_point::{OnePoint, OnePointEvaluation};
use super::packed::{InBlocks, Packed, with_elements};
use super::parameters::Formulation;
use super::totals::{BatchTotals, BlockTotals};
use super::{Assembly, Threads};
use crate::lanes::{BATCH, Row, dispatch_single, dispatch_wide};
use crate::material::{Law, MAX_BRANCHES};
use crate::tensor::Vec3;

/// Output of an internal force evaluation of all blocks, chunk by chunk.
#[derive(Debug)]
pub struct ElementForces {
    pub(super) chunks: Vec<ChunkForces>,
    /// Averaged pressure at the nodes of each block.
    pub(super) nodal: Vec<NodalState>,
}

impl ElementForces {
    /// Buffers of all blocks.
    pub fn new(blocks: &[ElementBlock]) -> Self {
        let of_block = |(index, block)| {
            let block: &ElementBlock = block;
            (0..block.chunk_count()).map(move |chunk| forces_of_chunk(index, block, chunk))
        };
        Self {
            chunks: blocks.iter().enumerate().flat_map(of_block).collect(),
            nodal: blocks.iter().map(|block| NodalState::of(block.nodal_volumes.as_ref())).collect(),
        }
    }

    /// Evaluates every batch that is active.
    pub fn evaluate(&mut self, threads: &Threads, blocks: &[ElementBlock], input: &ForceInput) {
        self.respond_at_nodes(threads, blocks, input.u);
        let nodal = &self.nodal;
        threads.for_each(&mut self.chunks, |chunk| {
            let block = &blocks[chunk.block as usize];
            if let Some(volumes) = &block.nodal_volumes {
                let at_nodes = &nodal[chunk.block as usize].response;
                volumes.gather(&block.chunks[chunk.chunk as usize], at_nodes, &mut chunk.nodal);
            }
            if chunk.active != 0 {
                with_elements!(&block.packed, block.parameters.material; elements, law => {
                    evaluate_chunk(law, elements, block, input, chunk);
                });
            }
        });
    }

    /// Energies and extremes of one block after an evaluation.
    pub fn totals(&self, block: usize) -> BlockTotals {
        let first = self.chunks.partition_point(|chunk| (chunk.block as usize) < block);
        let mut sum = BlockTotals::NONE;
        for chunk in self.chunks[first..].iter().take_while(|chunk| chunk.block as usize == block) {
            sum.add(&chunk.totals);
        }
        sum
    }

    /// Energies of a branch of relaxation of one block in the last step, after [`ElementForces::add_viscous`].
    pub fn branch_totals(&self, block: usize, branch: usize) -> BranchTotals {
        let mut sum = BranchTotals::default();
        for chunk in self.chunks.iter().filter(|chunk| chunk.block as usize == block) {
            sum.add(&chunk.branch_totals[branch]);
        }
        sum
    }

    /// Critical time step [s] of every slot of a block, padding included, as of the last evaluation.
    pub fn stable_steps(&self, block: usize) -> impl Iterator<Item = f64> {
        let chunks = self.chunks.iter().filter(move |chunk| chunk.block as usize == block);
        chunks.flat_map(|chunk| &chunk.batches).flat_map(|batch| batch.stable_step.0)
    }

    /// Sum of the element forces [N] at a node.
    #[inline]
    pub fn at_node(&self, assembly: &Assembly, node: usize) -> Vec3 {
        assembly.sum_at(node, |chunk, i| self.chunks[chunk].force[i])
    }

    /// The history at the start of a run: at rest, and relaxed; empty where no block has any.
    pub fn no_history(blocks: &[ElementBlock]) -> Vec<Vec<Row>> {
        if blocks.iter().all(|block| block.history_rows() == 0) {
            return Vec::new();
        }
        let of_block = |block: &ElementBlock| {
            let rows = block.history_rows();
            let of_chunk = move |chunk: &Chunk| vec![Row::default(); chunk.batches.len() * rows];
            block.chunks.iter().map(of_chunk).collect::<Vec<_>>()
        };
        blocks.iter().flat_map(of_block).collect()
    }

    /// Takes the history of the last evaluation for that of its beginning: inactive elements have none.
    pub fn swap_history(&mut self, history: &mut [Vec<Row>]) {
        for (chunk, history) in self.chunks.iter_mut().zip(history) {
            std::mem::swap(&mut chunk.history, history);
        }
    }

    /// Copies the history of the last evaluation to as much as there is room for.
    pub fn copy_history(&self, history: &mut [Vec<Row>]) {
        for (chunk, history) in self.chunks.iter().zip(history) {
            history.copy_from_slice(&chunk.history);
        }
    }

    /// Number of elements that an evaluation covers.
    pub fn active_elements(&self, blocks: &[ElementBlock]) -> usize {
        let of_chunk = |chunk: &ChunkForces| {
            let block = &blocks[chunk.block as usize];
            let batches = &block.chunks[chunk.chunk as usize].batches;
            let all = chunk.active.count_ones() as usize * BATCH;
            let has_padding = batches.end as usize == block.batch_count();
            let last_is_active = chunk.active & (1 << (batches.len() - 1)) != 0;
            all - if has_padding && last_is_active { block.slot_count() - block.elements.len() } else { 0 }
        };
        self.chunks.iter().map(of_chunk).sum()
    }

    /// Memory of all buffers of the evaluation [bytes].
    pub fn memory(&self) -> usize {
        let of_chunk = |chunk: &ChunkForces| {
            size_of::<ChunkForces>()
                + size_of_val(&chunk.force[..])
                + size_of_val(&chunk.viscous[..])
                + size_of_val(&chunk.u[..])
                + size_of_val(&chunk.v[..])
                + size_of_val(&chunk.history[..])
                + size_of_val(&chunk.dilatation[..])
                + size_of_val(&chunk.nodal[..])
                + size_of_val(&chunk.batches[..])
                + size_of_val(&chunk.branches[..])
        };
        self.chunks.iter().map(of_chunk).sum::<usize>()
            + self.nodal.iter().map(NodalState::memory).sum::<usize>()
    }
}

/// Empty output for a chunk whose elements are all active.
fn forces_of_chunk(block_index: usize, block: &ElementBlock, chunk: usize) -> ChunkForces {
    let batches = block.chunks[chunk].batches.len();
    let nodes = block.nodes_of_chunk(chunk).len();
    let averaged = if block.nodal_volumes.is_some() { nodes } else { 0 };
    ChunkForces {
        block: block_index as u32,
        chunk: chunk as u32,
        active: ChunkForces::all(batches),
        force: vec![Vec3::zeros(); nodes],
        viscous: vec![Vec3::zeros(); if block.parameters.is_viscous() { nodes } else { 0 }],
        has_shear_viscosity: false,
        u: vec![Vec3::zeros(); nodes],
        v: vec![Vec3::zeros(); nodes],
        dilatation: vec![0.0; averaged],
        nodal: vec![[0.0; 3]; averaged],
        stretch_rate: 0.0,
        shortest: 0.0,
        history: vec![Row::default(); batches * block.history_rows()],
        eroded: Vec::new(),
        eroding: Vec::new(),
        batches: vec![BatchTotals::default(); batches],
        totals: BlockTotals::NONE,
        branches: vec![Row::default(); batches * block.branch_rows()],
        branch_totals: [BranchTotals::default(); MAX_BRANCHES],
    }
}

/// Evaluates the batches of a chunk that are active: element forces, energies, critical time steps.
fn evaluate_chunk<L: Law, E: InBlocks<N, Q>, const N: usize, const Q: usize>(
    law: L,
    elements: &Packed<E, N, Q>,
    block: &ElementBlock,
    input: &ForceInput,
    forces: &mut ChunkForces,
) where
    E::OnePoint: OnePointEvaluation<E, N, Q>,
{
    macro_rules! evaluate {
        ($law:expr, $formulation:expr) => {
            if let Err(evaluation) = dispatch_wide(Evaluation {
                law: $law,
                formulation: $formulation,
                elements,
                block,
                input,
                forces,
            }) {
                evaluation.without_wide_registers();
            }
        };
    }
    let formulation = block.parameters.formulation;
    if const { E::KIND.has_single_precision() } && block.parameters.has_single_precision(E::KIND) {
        let (formulation, forces) = (GaussPoints::<true, false>, &mut *forces);
        if dispatch_single(Evaluation { law, formulation, elements, block, input, forces }).is_ok() {
            return;
        }
    }
    // Constants stand first, so that no kernel is compiled for an element that has no use for it.
    if const { Formulation::MeanDilatation.is_of(E::KIND) } && block.parameters.has_mean_dilatation() {
        evaluate!(law, GaussPoints::<true, false>);
    } else if const { Formulation::NodalPressure.is_of(E::KIND) } && formulation == Formulation::NodalPressure
    {
        evaluate!(law, GaussPoints::<true, true>);
    } else if const { Formulation::Reduced.is_of(E::KIND) } && formulation == Formulation::Reduced {
        evaluate!(law, OnePoint);
    } else {
        // One kernel for all laws: coupled ones have none of their own, and others run in mean dilatation unless a scene says otherwise.
        evaluate!(block.parameters.material, GaussPoints::<false, false>);
    }
}
