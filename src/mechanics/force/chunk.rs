//! Chunks: a few hundred elements that are evaluated as one task, with the forces on their nodes.
//!
//! A chunk numbers its own nodes and sums the element forces on them itself, batch after batch; each node then adds up its
//! few chunks in a fixed order. So the forces between elements and nodes stay in the first-level cache, no two threads
//! write to one place, and the bits do not depend on how many threads there are.

use super::branch_totals::BranchTotals;
use super::parameters::BlockInput;
use super::totals::{BatchTotals, BlockTotals};
use crate::lanes::{BATCH, Row};
use crate::material::MAX_BRANCHES;
use crate::tensor::Vec3;
use std::ops::Range;

/// U [J/m³], U′ [Pa] and U″ [Pa], the latter not negative, at a node; or means of them.
pub(super) type NodalResponse = [f64; 3];

/// A run of consecutive batches of a block.
#[derive(Clone, Debug)]
pub(super) struct Chunk {
    /// Its batches in the block.
    pub batches: Range<u32>,
    /// Where its global nodes are listed.
    pub nodes: Range<u32>,
}

impl Chunk {
    /// Batches of a chunk: as many as a mask has bits.
    pub const BATCHES: usize = u32::BITS as usize;
    /// Slots of a chunk in arrays over all slots, whether they are used or not.
    pub const SLOTS: usize = Self::BATCHES * BATCH;
}

/// Cuts a block into chunks and numbers the nodes of its batches, `[node][lane]` each, within them, in the order of their first use.
pub(super) fn cut_chunks<const N: usize>(
    batches: &mut [&mut [[u16; BATCH]; N]],
    inputs: &[BlockInput],
) -> (Vec<Chunk>, Vec<u32>) {
    let (mut chunks, mut chunk_nodes) = (Vec::new(), Vec::new());
    let highest = inputs.iter().flat_map(|input| &input.nodes).max().map_or(0, |node| *node as usize + 1);
    let mut number = vec![u16::MAX; highest];
    let first_batches = (0..).step_by(Chunk::BATCHES);
    for ((first, batches), inputs) in
        first_batches.zip(batches.chunks_mut(Chunk::BATCHES)).zip(inputs.chunks(Chunk::BATCHES * BATCH))
    {
        let first_node = chunk_nodes.len();
        for (batch, lanes) in batches.iter_mut().zip(inputs.chunks(BATCH)) {
            for corner in 0..N {
                for lane in 0..BATCH {
                    let node = lanes[lane.min(lanes.len() - 1)].nodes[corner];
                    let number = &mut number[node as usize];
                    if *number == u16::MAX {
                        *number = (chunk_nodes.len() - first_node) as u16;
                        chunk_nodes.push(node);
                    }
                    batch[corner][lane] = *number;
                }
            }
        }
        for node in &chunk_nodes[first_node..] {
            number[*node as usize] = u16::MAX;
        }
        chunks.push(Chunk {
            batches: first as u32..(first + batches.len()) as u32,
            nodes: first_node as u32..chunk_nodes.len() as u32,
        });
    }
    (chunks, chunk_nodes)
}

/// Output of the evaluation of one chunk.
#[derive(Debug)]
pub struct ChunkForces {
    /// Block and chunk in the block.
    pub(super) block: u32,
    pub(super) chunk: u32,
    /// Which batches are evaluated, a bit each. An inactive batch keeps what its last evaluation wrote.
    pub(super) active: u32,
    /// Internal force on each node of the chunk [N].
    pub(super) force: Vec<Vec3>,
    /// Force of viscosity and memory on each node of the chunk [N]; empty without.
    pub(super) viscous: Vec<Vec3>,
    /// Whether the last evaluation of internal forces has put those of shear viscosity there.
    pub(super) has_shear_viscosity: bool,
    /// Displacements of the nodes of the chunk, gathered [m].
    pub(super) u: Vec<Vec3>,
    /// Velocities of the nodes of the chunk, gathered [m/s].
    pub(super) v: Vec<Vec3>,
    /// ¼ V_e (J_e − 1) summed at the nodes of the chunk [m³], and the responses there; empty where pressure is not averaged over nodes.
    pub(super) dilatation: Vec<f64>,
    pub(super) nodal: Vec<NodalResponse>,
    /// Largest stretch rate [1/s]; 0 when it is certain not to matter.
    pub(super) stretch_rate: f64,
    /// No edge or diagonal is shorter than this [m]; 0 when nothing is known.
    pub(super) shortest: f64,
    /// History at t_n, [`ElementBlock::history_rows`](super::ElementBlock::history_rows) a batch.
    pub(super) history: Vec<Row>,
    /// Bit mask of eroded elements of each batch, one bit per lane; empty while there are none.
    pub(super) eroded: Vec<u8>,
    /// Elements beyond the erosion limits, where these were checked.
    pub(super) eroding: Vec<u8>,
    /// Sums and extremes of each batch.
    pub(super) batches: Vec<BatchTotals>,
    /// Sums over the whole chunk.
    pub(super) totals: BlockTotals,
    /// Energies of the branches of relaxation of each batch in the last step, three rows a branch; empty without.
    pub(super) branches: Vec<Row>,
    /// Sums over the whole chunk, one entry per branch.
    pub(super) branch_totals: [BranchTotals; MAX_BRANCHES],
}

impl ChunkForces {
    /// The mask of `count` batches.
    pub(super) fn all(count: usize) -> u32 {
        u32::MAX >> (Chunk::BATCHES - count)
    }

    /// Bit mask of eroded elements of the i-th batch, one bit per lane.
    #[inline]
    pub(super) fn eroded_lanes(&self, i: usize) -> u8 {
        self.eroded.get(i).copied().unwrap_or(0)
    }

    /// Whether every batch is evaluated.
    pub(super) fn is_wholly_active(&self) -> bool {
        self.active == Self::all(self.batches.len())
    }
}
