//! A block of elements: one body, one law, one formulation.

use super::branch_totals::ENERGIES;
use super::chunk::Chunk;
use super::nodal_volumes::NodalVolumes;
use super::packed::{Elements, with_elements};
use super::parameters::{BlockError, BlockInput, BlockParameters, Formulation};
use crate::element::{ElementKind, MOST_NODES};
use crate::lanes::{BATCH, Row};
use crate::tensor::Vec3;

/// Rows of history of bulk viscosity, where there is any.
pub(super) const BULK_ROWS: usize = 2;

/// A block of elements, ready to be evaluated.
#[derive(Debug)]
pub struct ElementBlock {
    /// Index of the body in the plan.
    pub body: usize,
    /// Law, density, viscosity and formulation of all elements of the block.
    pub parameters: BlockParameters,
    /// Global element of each slot.
    pub elements: Vec<u32>,
    /// First slot of the block in arrays over all slots, at the beginning of a chunk.
    pub first_slot: usize,
    /// Kind of the elements.
    pub kind: ElementKind,
    pub(super) packed: Elements,
    /// Fibre directions in reference axes: `[batch × families][axis][lane]`.
    pub(super) fibres: Vec<[Row; 3]>,
    pub(super) chunks: Vec<Chunk>,
    /// Global nodes of all chunks, see [`Chunk::nodes`].
    pub(super) chunk_nodes: Vec<u32>,
    /// Nodal volumes, where the formulation averages pressure over nodes.
    pub(super) nodal_volumes: Option<NodalVolumes>,
}

impl ElementBlock {
    /// Packs elements into batches. `first_slot` is the [`ElementBlock::end_slot`] of the block before, 0 for the first.
    ///
    /// # Errors
    /// If the elements are not of one kind, the kind does not support the formulation, or the law lacks the volumetric energy that it needs.
    pub fn new(
        body: usize,
        parameters: BlockParameters,
        first_slot: usize,
        inputs: &[BlockInput],
    ) -> Result<Self, BlockError> {
        let kind = inputs.first().ok_or(BlockError::Kinds)?.geometry.kind;
        let is_of_kind = |input: &BlockInput| {
            input.geometry.kind == kind && [input.nodes.len(), input.corners.len()] == [kind.node_count(); 2]
        };
        if !inputs.iter().all(is_of_kind) {
            return Err(BlockError::Kinds);
        }
        let has_energy = parameters.formulation != Formulation::NodalPressure
            || parameters.material.volumetric().is_some();
        if !(has_energy && parameters.formulation.is_of(kind)) {
            return Err(BlockError::Formulation(kind, parameters.formulation));
        }
        let (packed, chunks, chunk_nodes) = Elements::cut(kind, &parameters, inputs);
        let nodal_volumes = NodalVolumes::new(&parameters, inputs, &chunks, &chunk_nodes);
        let elements = inputs.iter().map(|i| i.element).collect();
        let mut block = Self {
            body,
            parameters,
            elements,
            first_slot,
            kind,
            packed,
            fibres: Vec::new(),
            chunks,
            chunk_nodes,
            nodal_volumes,
        };
        for lanes in inputs.chunks(BATCH) {
            block.pack_fibres(lanes);
        }
        Ok(block)
    }

    /// Its slots that hold elements, with these.
    pub fn numbered(&self) -> impl Iterator<Item = (usize, u32)> {
        self.elements.iter().copied().enumerate()
    }

    /// Batches of [`BATCH`] elements, the last one padded.
    pub fn batch_count(&self) -> usize {
        self.elements.len().div_ceil(BATCH)
    }

    /// Rows of history of a batch: with bulk viscosity J̄ − 1 [-] and its pressure [Pa], ≥ 0 in compression; then for each point with a
    /// memory the numbers that it remembers; with branches of relaxation the displacements of the nodes [m], and the forces of each
    /// branch on them [N].
    pub fn history_rows(&self) -> usize {
        let of_nodes = match self.branch_count() {
            0 => 0,
            branches => 3 * self.kind.node_count() * (1 + branches),
        };
        self.bulk_rows() + self.memory_points() * self.memory_rows() + of_nodes
    }

    /// History rows used by bulk viscosity.
    pub(super) fn bulk_rows(&self) -> usize {
        if self.parameters.has_bulk_viscosity() { BULK_ROWS } else { 0 }
    }

    /// Where the numbers that a point of the element in a slot remembers are in the history: chunk, first row, and lane.
    pub fn place_of_history(&self, slot: usize, point: usize) -> (usize, usize, usize) {
        let (batch, lane) = (slot / BATCH, slot % BATCH);
        let first = batch % Chunk::BATCHES * self.history_rows() + self.bulk_rows();
        (self.chunk_number(batch / Chunk::BATCHES), first + point * self.memory_rows(), lane)
    }

    /// Points whose stress has a history.
    pub fn memory_points(&self) -> usize {
        if self.parameters.formulation == Formulation::Reduced { 1 } else { self.kind.point_count() }
    }

    /// Rows of history of a point.
    pub(super) fn memory_rows(&self) -> usize {
        self.parameters.history_len()
    }

    /// Number of branches of the Prony series of its law; 0 without relaxation.
    pub fn branch_count(&self) -> usize {
        self.parameters.memory.branches().len()
    }

    /// Rows of the energies of the branches of a batch.
    pub(super) fn branch_rows(&self) -> usize {
        ENERGIES * self.branch_count()
    }

    /// Number of a chunk of this block among those of all blocks.
    pub(super) fn chunk_number(&self, chunk: usize) -> usize {
        self.first_slot / Chunk::SLOTS + chunk
    }

    /// Number of slots, padding included.
    pub fn slot_count(&self) -> usize {
        self.batch_count() * BATCH
    }

    /// Where the next block begins in arrays over all slots: whole chunks.
    pub fn end_slot(&self) -> usize {
        self.first_slot + self.chunks.len() * Chunk::SLOTS
    }

    /// Chunks of batches, the unit of work of a thread.
    pub fn chunk_count(&self) -> usize {
        self.chunks.len()
    }

    /// Nodes of the element in a slot of this block.
    pub fn nodes_of(&self, slot: usize) -> NodeList {
        let batch = slot / BATCH;
        let (nodes, own) = (self.nodes_of_chunk(batch / Chunk::BATCHES), self.nodes_of_batch(batch));
        let mut list = NodeList { nodes: [0; MOST_NODES], count: own.len() };
        for (node, own) in list.nodes.iter_mut().zip(own) {
            *node = nodes[own[slot % BATCH] as usize];
        }
        list
    }

    /// Global nodes of a chunk, in its own numbering.
    pub(super) fn nodes_of_chunk(&self, chunk: usize) -> &[u32] {
        let range = &self.chunks[chunk].nodes;
        &self.chunk_nodes[range.start as usize..range.end as usize]
    }

    /// Nodes of a batch, in the numbering of its chunk: `[node][lane]`.
    pub(super) fn nodes_of_batch(&self, batch: usize) -> &[[u16; BATCH]] {
        with_elements!(&self.packed, elements => &elements.batches[batch].nodes)
    }

    /// Memory of the constants of its elements [bytes].
    pub fn memory(&self) -> usize {
        with_elements!(&self.packed, elements => size_of_val(&elements.batches[..]) + size_of_val(&elements.one_point[..]))
            + self.fibres.len() * size_of::<[Row; 3]>()
            + 4 * (self.elements.len() + self.chunk_nodes.len())
            + self.chunks.len() * size_of::<Chunk>()
            + self.nodal_volumes.as_ref().map_or(0, NodalVolumes::memory)
    }

    /// Fibre directions of a batch, `[family][axis][lane]`.
    pub(super) fn fibres_of(&self, batch: usize) -> &[[Row; 3]] {
        let families = self.parameters.material.family_count();
        &self.fibres[batch * families..(batch + 1) * families]
    }

    /// Rotates the law's families into each element's axes; nothing for laws without fibres.
    fn pack_fibres(&mut self, chunk: &[BlockInput]) {
        let material = self.parameters.material;
        for direction in material.fibre_directions() {
            let mut lanes = [Row::default(); 3];
            for lane in 0..BATCH {
                let a = chunk[lane.min(chunk.len() - 1)].axes * Vec3::from(*direction);
                for i in 0..3 {
                    lanes[i].0[lane] = a[i];
                }
            }
            self.fibres.push(lanes);
        }
    }
}

/// The nodes of an element.
#[derive(Clone, Copy, Debug)]
pub struct NodeList {
    nodes: [u32; MOST_NODES],
    count: usize,
}

impl std::ops::Deref for NodeList {
    type Target = [u32];
    fn deref(&self) -> &[u32] {
        &self.nodes[..self.count]
    }
}
