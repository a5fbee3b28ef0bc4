//! A block of elements: one body, one law, one formulation.

use super::chunk::{Chunk, ChunkForces, cut_chunks};
use super::reduced::ReducedBatch;
use super::sweep::{self, SweepInput};
use crate::mechanics::element::{POINTS, ReferenceGeometry, corner_stiffness};
use crate::mechanics::lanes::{BATCH, Row};
use crate::mechanics::material::{Material, PronySeries};
use crate::mechanics::tensor::{Mat3, Vec3};

/// How the energy of an element is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// 2×2×2 points for everything.
    Full,
    /// 2×2×2 points, and one mean dilatation for the volumetric energy of a split law; coupled laws are integrated fully.
    MeanDilatation,
    /// One point at the mean gradient, and a stabilisation of the hourglass modes ([`crate::mechanics::element::Hourglass`]).
    Reduced,
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
    /// Points whose stress has a history.
    pub(super) fn memory_points(&self) -> usize {
        match self.formulation {
            Formulation::Full | Formulation::MeanDilatation => POINTS,
            Formulation::Reduced => 1,
        }
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
    /// Its corner nodes (global).
    pub nodes: [u32; 8],
    /// Their reference positions X [m].
    pub corners: [Vec3; 8],
    /// Its material axes, columns e1, e2, e3 in reference axes.
    pub axes: Mat3,
    /// Its reference geometry.
    pub geometry: ReferenceGeometry,
}

/// The corners are scaled so that the cofactors of their derivatives are right for the forces as they are.
///
/// With `∂/∂ξ = d g`, d [`DERIVATIVE`] and g the derivatives at hand, a stress P gives the force conjugate to g(u)
/// `w P F_X⁻ᵀ d = d³ P cof g(X)`, which is `P cof g(X / s)` for `s = d^(−3/2)`. Then `det g(X / s) = w / s`.
pub(super) const CORNER_SCALE: f64 = 5.765_680_169_303_579;

/// Rows of history of bulk viscosity, where there is any.
pub(super) const BULK_ROWS: usize = 2;

/// Constants of a batch of elements, lane by lane: 328 bytes an element.
///
/// The reference geometry at the points is made again from the corners at every sweep, for a tenth of its arithmetic;
/// stored, it would be 640 bytes an element, which a large mesh waits for.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// Corner positions X over [`CORNER_SCALE`]: `[component][corner]` [m].
    pub corners: [[Row; 8]; 3],
    /// 1/w of each point, w its reference volume [1/m³]; zero in lanes that pad the last batch, so that F = I there.
    pub inverse_weight: [Row; POINTS],
    /// Reference volume [m³]; zero in padding.
    pub volume: Row,
    /// [`CORNER_SCALE`] / volume [1/m³]; zero in padding.
    pub scaled_inverse_volume: Row,
    /// λ / ρ: largest ω² per tangent norm [1/(m² kg/m³)]; zero in padding.
    pub frequency_bound: Row,
    /// Length L of the bulk viscosity [m]: 2/√λ, the edge of a cube, the thickness of a flat element, so that the damping
    /// ratio of the element's highest mode is b1 whatever its shape; 1 in padding.
    pub length: Row,
    /// Stiffness [Pa/m³] and hardening [1/m¹²] of the corner penalty; zero in padding.
    pub corner_stiffness: [Row; 2],
    /// 1/(ρ V_c), V_c the least volume of a corner: ω² of a stiffness is at most that times its norm [1/kg]; zero in padding.
    pub inverse_least_mass: Row,
    /// Corner nodes, numbered within the chunk: `[corner][lane]`.
    pub nodes: [[u16; BATCH]; 8],
}

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
    pub(super) batches: Vec<Batch>,
    /// Further constants of the batches of one-point elements, empty in other formulations.
    pub(super) reduced: Vec<ReducedBatch>,
    /// Fibre directions in reference axes: `[batch × families][axis][lane]`.
    pub(super) fibres: Vec<[Row; 3]>,
    pub(super) chunks: Vec<Chunk>,
    /// Global nodes of all chunks, see [`Chunk::nodes`].
    pub(super) chunk_nodes: Vec<u32>,
    kernel: Box<dyn sweep::Kernel>,
}

impl ElementBlock {
    /// Packs elements into batches. `first_slot` is the [`ElementBlock::end_slot`] of the block before, 0 for the first.
    pub fn new(body: usize, parameters: BlockParameters, first_slot: usize, inputs: &[BlockInput]) -> Self {
        let mut block = Self {
            body,
            parameters,
            elements: inputs.iter().map(|i| i.element).collect(),
            first_slot,
            batches: inputs.chunks(BATCH).map(|lanes| pack(lanes, &parameters)).collect(),
            reduced: match parameters.formulation {
                Formulation::Full | Formulation::MeanDilatation => Vec::new(),
                Formulation::Reduced => {
                    inputs.chunks(BATCH).map(|lanes| ReducedBatch::new(lanes, &parameters)).collect()
                }
            },
            fibres: Vec::new(),
            chunks: Vec::new(),
            chunk_nodes: Vec::new(),
            kernel: sweep::kernel(&parameters),
        };
        for lanes in inputs.chunks(BATCH) {
            block.pack_fibres(lanes);
        }
        (block.chunks, block.chunk_nodes) = cut_chunks(&mut block.batches, inputs);
        block
    }

    /// Number of batches.
    pub fn batch_count(&self) -> usize {
        self.batches.len()
    }

    /// Rows of history of a batch: with bulk viscosity J̄ − 1 [-] and its pressure [Pa], ≥ 0 in compression; then for each point with a
    /// memory the symmetric tensors of its Prony series [Pa].
    pub fn history_rows(&self) -> usize {
        self.bulk_rows() + self.parameters.memory_points() * self.memory_rows()
    }

    /// Those of them that are of bulk viscosity.
    pub(super) fn bulk_rows(&self) -> usize {
        if self.parameters.has_bulk_viscosity() { BULK_ROWS } else { 0 }
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
        self.batches.len() * BATCH
    }

    /// Where the next block begins in arrays over all slots: whole chunks.
    pub fn end_slot(&self) -> usize {
        self.first_slot + self.chunks.len() * Chunk::SLOTS
    }

    /// Number of chunks.
    pub fn chunk_count(&self) -> usize {
        self.chunks.len()
    }

    /// Corner nodes of the element in a slot of this block.
    pub fn nodes_of(&self, slot: usize) -> [u32; 8] {
        let batch = slot / BATCH;
        let nodes = self.nodes_of_chunk(batch / Chunk::BATCHES);
        std::array::from_fn(|a| nodes[self.batches[batch].nodes[a][slot % BATCH] as usize])
    }

    /// Global nodes of a chunk, in its own numbering.
    pub(super) fn nodes_of_chunk(&self, chunk: usize) -> &[u32] {
        let range = &self.chunks[chunk].nodes;
        &self.chunk_nodes[range.start as usize..range.end as usize]
    }

    /// The i-th batch of a chunk.
    pub(super) fn batch_of_chunk(&self, chunk: usize, i: usize) -> &Batch {
        &self.batches[self.chunks[chunk].batches.start as usize + i]
    }

    /// Sweeps the batches of a chunk that are awake: element forces, energies, stable steps.
    pub(super) fn sweep(&self, input: &SweepInput, forces: &mut ChunkForces) {
        self.kernel.sweep(self, input, forces);
    }

    /// Bytes in memory.
    pub fn memory(&self) -> usize {
        self.batches.len() * size_of::<Batch>()
            + self.reduced.len() * size_of::<ReducedBatch>()
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

/// One batch; lanes beyond the chunk repeat its last element with zero volume. The nodes are numbered later.
fn pack(chunk: &[BlockInput], parameters: &BlockParameters) -> Batch {
    let (density, moduli) = (parameters.density, parameters.material.moduli_at_rest());
    let mut batch = Batch {
        corners: [[Row::default(); 8]; 3],
        inverse_weight: [Row::default(); POINTS],
        volume: Row::default(),
        scaled_inverse_volume: Row::default(),
        frequency_bound: Row::default(),
        length: Row([1.0; BATCH]),
        corner_stiffness: [Row::default(); 2],
        inverse_least_mass: Row::default(),
        nodes: [[0; BATCH]; 8],
    };
    for lane in 0..BATCH {
        let BlockInput { geometry, corners, .. } = &chunk[lane.min(chunk.len() - 1)];
        for (corner, X) in corners.iter().enumerate() {
            for i in 0..3 {
                batch.corners[i][corner].0[lane] = X[i] / CORNER_SCALE;
            }
        }
        // Padding keeps zero weights: F = I, no stress, no volume, no limit on the step.
        if lane >= chunk.len() {
            continue;
        }
        for q in 0..POINTS {
            batch.inverse_weight[q].0[lane] = 1.0 / geometry.volume[q];
        }
        batch.volume.0[lane] = geometry.total_volume();
        batch.scaled_inverse_volume.0[lane] = CORNER_SCALE / geometry.total_volume();
        batch.frequency_bound.0[lane] = geometry.gradient_bound / density;
        batch.length.0[lane] = 2.0 / geometry.gradient_bound.sqrt();
        let of_corners = corner_stiffness(moduli, geometry.total_volume());
        for (row, value) in batch.corner_stiffness.iter_mut().zip(of_corners) {
            row.0[lane] = value;
        }
        let least = geometry.corner_volume.iter().copied().fold(f64::INFINITY, f64::min);
        batch.inverse_least_mass.0[lane] = 1.0 / (density * least);
    }
    batch
}
