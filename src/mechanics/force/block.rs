//! A block of elements: one body, one law, one formulation.

use super::sweep::{self, SweepInput, SweepOutput};
use crate::mechanics::element::{POINTS, ReferenceGeometry};
use crate::mechanics::lanes::BATCH;
use crate::mechanics::material::Material;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Law, density and viscosity of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockParameters {
    /// The constitutive law.
    pub material: Material,
    /// Whether the volumetric energy sees the element's mean dilatation (else each point's own J).
    pub mean_dilatation: bool,
    /// Density at rest ρ [kg/m³].
    pub density: f64,
    /// Linear bulk viscosity b1 [-].
    pub linear_viscosity: f64,
    /// Quadratic bulk viscosity b2 [-].
    pub quadratic_viscosity: f64,
}

impl BlockParameters {
    /// Speed of dilatational waves at rest, √((K + 4/3 G)/ρ) [m/s]; fibres apart.
    pub fn wave_speed(&self) -> f64 {
        let (G, K) = self.material.moduli_at_rest();
        ((K + 4.0 / 3.0 * G) / self.density).sqrt()
    }
}

/// One element to put into a block.
#[derive(Clone, Debug)]
pub struct BlockInput {
    /// Global number of the element.
    pub element: u32,
    /// Its corner nodes (global).
    pub nodes: [u32; 8],
    /// Its material axes, columns e1, e2, e3 in reference axes.
    pub axes: Mat3,
    /// Its reference geometry.
    pub geometry: ReferenceGeometry,
}

/// Constants of a batch of elements, lane by lane.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// Corner nodes: `[corner][lane]`.
    pub nodes: [[u32; BATCH]; 8],
    /// ∂ξ_k/∂X_j at each point: `[point][3 k + j][lane]` [1/m].
    pub inverse_jacobian: [[[f64; BATCH]; 9]; POINTS],
    /// Reference volume of each point [m³]; zero in lanes that pad the last batch.
    pub volume: [[f64; BATCH]; POINTS],
    /// λ / ρ: largest ω² per tangent norm [1/(m² kg/m³)]; zero in padding.
    pub frequency_bound: [f64; BATCH],
    /// Length L of the bulk viscosity [m]: 2/√λ, the edge of a cube, the thickness of a flat element, so that the damping
    /// ratio of the element's highest mode is b1 whatever its shape; 1 in padding.
    pub length: [f64; BATCH],
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
    /// First slot of the block in arrays over all slots; a multiple of [`BATCH`].
    pub first_slot: usize,
    pub(super) batches: Vec<Batch>,
    /// Fibre directions in reference axes: `[batch × families][axis][lane]`.
    pub(super) fibres: Vec<[[f64; BATCH]; 3]>,
    kernel: Box<dyn sweep::Kernel>,
}

impl ElementBlock {
    /// Packs elements into batches. `first_slot` must be a multiple of [`BATCH`].
    pub fn new(body: usize, parameters: BlockParameters, first_slot: usize, inputs: &[BlockInput]) -> Self {
        let mut block = Self {
            body,
            parameters,
            elements: inputs.iter().map(|i| i.element).collect(),
            first_slot,
            batches: Vec::with_capacity(inputs.len().div_ceil(BATCH)),
            fibres: Vec::new(),
            kernel: sweep::kernel(&parameters),
        };
        for chunk in inputs.chunks(BATCH) {
            block.batches.push(pack(chunk, parameters.density));
            block.pack_fibres(chunk);
        }
        block
    }

    /// Number of batches.
    pub fn batch_count(&self) -> usize {
        self.batches.len()
    }

    /// Number of slots, padding included.
    pub fn slot_count(&self) -> usize {
        self.batches.len() * BATCH
    }

    /// Corner nodes of the element in a slot of this block.
    pub fn nodes_of(&self, slot: usize) -> [u32; 8] {
        let batch = &self.batches[slot / BATCH];
        std::array::from_fn(|a| batch.nodes[a][slot % BATCH])
    }

    /// Sweeps the batches that `output` covers, from `first_batch`: element forces, energies, stable steps.
    pub fn sweep(&self, first_batch: usize, input: &SweepInput, output: SweepOutput) {
        self.kernel.sweep(self, first_batch, input, output);
    }

    /// Bytes in memory.
    pub fn memory(&self) -> usize {
        self.batches.len() * size_of::<Batch>()
            + self.fibres.len() * size_of::<[[f64; BATCH]; 3]>()
            + 4 * self.elements.len()
    }

    /// Rotates the law's families into each element's axes; nothing for laws without fibres.
    fn pack_fibres(&mut self, chunk: &[BlockInput]) {
        let material = self.parameters.material;
        for direction in material.fibre_directions() {
            let mut lanes = [[0.0; BATCH]; 3];
            for lane in 0..BATCH {
                let a = chunk[lane.min(chunk.len() - 1)].axes * Vec3::from(*direction);
                for i in 0..3 {
                    lanes[i][lane] = a[i];
                }
            }
            self.fibres.push(lanes);
        }
    }
}

/// One batch; lanes beyond the chunk repeat its last element with zero volume.
fn pack(chunk: &[BlockInput], density: f64) -> Batch {
    let mut batch = Batch {
        nodes: [[0; BATCH]; 8],
        inverse_jacobian: [[[0.0; BATCH]; 9]; POINTS],
        volume: [[0.0; BATCH]; POINTS],
        frequency_bound: [0.0; BATCH],
        length: [1.0; BATCH],
    };
    for lane in 0..BATCH {
        let input = &chunk[lane.min(chunk.len() - 1)];
        for (a, node) in input.nodes.iter().enumerate() {
            batch.nodes[a][lane] = *node;
        }
        // Padding keeps a zero inverse Jacobian: F = I, no stress, no volume, no limit on the step.
        if lane >= chunk.len() {
            continue;
        }
        for q in 0..POINTS {
            for k in 0..3 {
                for j in 0..3 {
                    batch.inverse_jacobian[q][3 * k + j][lane] = input.geometry.inverse_jacobian[q][(k, j)];
                }
            }
            batch.volume[q][lane] = input.geometry.volume[q];
        }
        batch.frequency_bound[lane] = input.geometry.gradient_bound / density;
        batch.length[lane] = 2.0 / input.geometry.gradient_bound.sqrt();
    }
    batch
}
