//! A block of elements: one body, one law, one formulation.

use super::chunk::{Chunk, ChunkForces};
use super::packed::{Elements, pack_elements};
use super::sweep::SweepInput;
use crate::mechanics::element::{ElementKind, MOST_NODES, ReferenceGeometry};
use crate::mechanics::lanes::{BATCH, Row};
use crate::mechanics::material::{Material, PronySeries};
use crate::mechanics::tensor::{Mat3, Vec3};

/// How the energy of an element is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// The points of the element for everything.
    Full,
    /// The same, and one mean dilatation for the volumetric energy of a split law; coupled laws are integrated fully.
    MeanDilatation,
    /// One point at the mean gradient, and a stabilisation of the hourglass modes ([`crate::mechanics::element::Hourglass`]).
    Reduced,
}

impl Formulation {
    /// Whether an element has it: the one place that says so.
    pub fn is_of(self, kind: ElementKind) -> bool {
        match self {
            Self::Full => true,
            // At one point the mean is the point's own.
            Self::MeanDilatation => kind.point_count() > 1,
            Self::Reduced => kind == ElementKind::Hex8,
        }
    }
}

/// Elements that no block can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BlockError {
    /// Their kind has no such formulation.
    #[error("elements of kind {0:?} have no formulation {1:?}")]
    Formulation(ElementKind, Formulation),
    /// They are of several kinds, or have not the nodes of their kind.
    #[error("the elements of a block are of one kind, with all its nodes")]
    Kinds,
}

/// Law, formulation, density and viscosity of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockParameters {
    /// The constitutive law.
    pub material: Material,
    /// How it is integrated.
    pub formulation: Formulation,
    /// Density at rest ρ [kg/m³].
    pub density: f64,
    /// Linear bulk viscosity b1 [-].
    pub linear_viscosity: f64,
    /// Quadratic bulk viscosity b2 [-].
    pub quadratic_viscosity: f64,
    /// Shear viscosity η of the material [Pa s].
    pub shear_viscosity: f64,
    /// Relaxation of the isochoric stress.
    pub prony: PronySeries,
    /// What its elements bear; `None` for ever.
    pub erosion: Option<ErosionLimits>,
}

impl BlockParameters {
    /// Whether stress depends on rate or history, bulk viscosity apart: forces of [`ElementForces::add_viscous`](super::ElementForces::add_viscous).
    pub fn is_viscous(&self) -> bool {
        self.shear_viscosity > 0.0 || !self.prony.is_none()
    }
    /// Whether compression has a viscous pressure.
    pub fn has_bulk_viscosity(&self) -> bool {
        self.linear_viscosity > 0.0 || self.quadratic_viscosity > 0.0
    }
    /// As [`BlockParameters::wave_speed`], along fibres that all lie in its direction [m/s]: nothing small is faster.
    pub fn fastest_wave(&self) -> f64 {
        self.wave_speed().hypot((self.material.fibre_modulus_at_rest() / self.density).sqrt())
    }
    /// Speed of dilatational waves at rest, √((K + 4/3 G)/ρ) [m/s]; fibres apart.
    pub fn wave_speed(&self) -> f64 {
        let (G, K) = self.material.moduli_at_rest();
        ((K + 4.0 / 3.0 * G) / self.density).sqrt()
    }
}

/// What the elements of a part bear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErosionLimits {
    /// Largest principal stretch of F̄ [-]; infinite without this limit.
    pub stretch: f64,
    /// Least mean volume ratio [-]; 0 without this limit.
    pub volume_ratio: f64,
}

/// One element to put into a block.
#[derive(Clone, Debug)]
pub struct BlockInput {
    /// Global number of the element.
    pub element: u32,
    /// Its nodes (global).
    pub nodes: Vec<u32>,
    /// Their reference positions X [m].
    pub corners: Vec<Vec3>,
    /// Its material axes, columns e1, e2, e3 in reference axes.
    pub axes: Mat3,
    /// Its kind and reference geometry.
    pub geometry: ReferenceGeometry,
}

/// Rows of history of bulk viscosity, where there is any.
pub(super) const BULK_ROWS: usize = 2;

/// A block of elements, ready to be swept.
#[derive(Debug)]
pub struct ElementBlock {
    /// Index of the body.
    pub body: usize,
    /// Law, density, viscosity.
    pub parameters: BlockParameters,
    /// Global element of each slot.
    pub elements: Vec<u32>,
    /// First slot of the block in arrays over all slots, at the beginning of a chunk.
    pub first_slot: usize,
    /// What its elements are.
    pub kind: ElementKind,
    pub(super) packed: Box<dyn Elements>,
    /// Fibre directions in reference axes: `[batch × families][axis][lane]`.
    pub(super) fibres: Vec<[Row; 3]>,
    pub(super) chunks: Vec<Chunk>,
    /// Global nodes of all chunks, see [`Chunk::nodes`].
    pub(super) chunk_nodes: Vec<u32>,
}

impl ElementBlock {
    /// Packs elements into batches. `first_slot` is the [`ElementBlock::end_slot`] of the block before, 0 for the first.
    ///
    /// # Errors
    /// Where the elements are not of one kind, or that has not the formulation.
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
        if !parameters.formulation.is_of(kind) {
            return Err(BlockError::Formulation(kind, parameters.formulation));
        }
        let (packed, chunks, chunk_nodes) = pack_elements(kind, &parameters, inputs);
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
        };
        for lanes in inputs.chunks(BATCH) {
            block.pack_fibres(lanes);
        }
        Ok(block)
    }

    /// Number of batches.
    pub fn batch_count(&self) -> usize {
        self.elements.len().div_ceil(BATCH)
    }

    /// Rows of history of a batch: with bulk viscosity J̄ − 1 [-] and its pressure [Pa], ≥ 0 in compression; then for each point with a
    /// memory the symmetric tensors of its Prony series [Pa].
    pub fn history_rows(&self) -> usize {
        self.bulk_rows() + self.memory_points() * self.memory_rows()
    }

    /// Those of them that are of bulk viscosity.
    pub(super) fn bulk_rows(&self) -> usize {
        if self.parameters.has_bulk_viscosity() { BULK_ROWS } else { 0 }
    }

    /// Points whose stress has a history.
    pub(super) fn memory_points(&self) -> usize {
        if self.parameters.formulation == Formulation::Reduced { 1 } else { self.kind.point_count() }
    }

    /// Rows of history of a point.
    pub(super) fn memory_rows(&self) -> usize {
        6 * self.parameters.prony.history_len()
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

    /// Number of chunks.
    pub fn chunk_count(&self) -> usize {
        self.chunks.len()
    }

    /// Nodes of the element in a slot of this block.
    pub fn nodes_of(&self, slot: usize) -> NodeList {
        let batch = slot / BATCH;
        let (nodes, own) = (self.nodes_of_chunk(batch / Chunk::BATCHES), self.packed.nodes(batch));
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

    /// Nodes of the i-th batch of a chunk, in its own numbering.
    pub(super) fn nodes_of_batch(&self, chunk: usize, i: usize) -> &[[u16; BATCH]] {
        self.packed.nodes(self.chunks[chunk].batches.start as usize + i)
    }

    /// Sweeps the batches of a chunk that are awake: element forces, energies, stable steps.
    pub(super) fn sweep(&self, input: &SweepInput, forces: &mut ChunkForces) {
        self.packed.sweep(self, input, forces);
    }

    /// Bytes in memory.
    pub fn memory(&self) -> usize {
        self.packed.memory()
            + self.fibres.len() * size_of::<[Row; 3]>()
            + 4 * (self.elements.len() + self.chunk_nodes.len())
            + self.chunks.len() * size_of::<Chunk>()
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
