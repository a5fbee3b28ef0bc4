//! The elements of a block in batches: constants lane by lane, of one kind, behind one dynamic call a chunk.

use super::block::{BlockInput, BlockParameters, ElementBlock, ErosionLimits};
use super::chunk::{Chunk, ChunkForces};
use super::conserving::ChangeOfStrain;
use super::erosion::Judge;
use super::memory::Memory;
use super::points::{PointBatch, PointInput, Points};
use super::rate::Rate;
use super::reduced::{NoOnePoint, OnePointBatch, ReducedBatch};
use super::stiffness::{Stiffness, StiffnessBatch};
use super::sweep::{self, Kernel, SweepInput};
use super::viscous::Viscous;
use crate::mechanics::element::{self, Element, ElementKind, corner_stiffness, for_each_element};
use crate::mechanics::lanes::{BATCH, Row};
use crate::mechanics::tensor::Vec3;
use crate::with_law;
use std::marker::PhantomData;

/// Constants of a batch of elements, lane by lane: 328 bytes a hexahedron.
///
/// The reference geometry at the points is made again from the corners at every sweep, for a tenth of its arithmetic;
/// stored, it would be 640 bytes an element, which a large mesh waits for.
#[derive(Clone, Debug)]
pub(super) struct Batch<E, const N: usize, const Q: usize> {
    /// Positions X of the nodes over [`Element::SCALE`]: `[component][node]` [m].
    pub corners: [[Row; N]; 3],
    /// 1/w of each point, w its reference volume [1/m³]; zero in lanes that pad the last batch, so that F = I there.
    pub inverse_weight: [Row; Q],
    /// Reference volume [m³]; zero in padding.
    pub volume: Row,
    /// [`Element::SCALE`] / volume [1/m³]; zero in padding.
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
    /// Nodes, numbered within the chunk: `[node][lane]`.
    pub nodes: [[u16; BATCH]; N],
    kind: PhantomData<E>,
}

/// An element with its one-point formulation.
pub(super) trait InBlocks<const N: usize, const Q: usize>: Element<N, Q> {
    /// Further constants of the batches of one-point elements.
    type OnePoint: OnePointBatch<Self, N, Q>;
}

/// What blocks ask of their elements: every pass, whatever their kind.
pub(super) trait Elements: std::fmt::Debug + Send + Sync {
    /// Nodes of a batch, numbered within the chunk: `[node][lane]`.
    fn nodes(&self, batch: usize) -> &[[u16; BATCH]];
    /// 1/w of each point of a batch [1/m³].
    fn inverse_weights(&self, batch: usize) -> &[Row];
    /// Forces, energies and stable steps of the batches of a chunk that are awake.
    fn sweep(&self, block: &ElementBlock, input: &SweepInput, forces: &mut ChunkForces);
    /// Adds the forces of shear viscosity of a chunk, whose displacements and velocities are gathered.
    fn add_viscous(&self, block: &ElementBlock, chunk: &mut ChunkForces);
    /// Adds the forces of memory of a chunk, whose displacements are gathered.
    fn add_memory(&self, block: &ElementBlock, input: &SweepInput, chunk: &mut ChunkForces);
    /// Notes which elements of a chunk are beyond their limits.
    fn judge(&self, block: &ElementBlock, limits: ErosionLimits, chunk: &mut ChunkForces);
    /// Shortest length of a chunk, and its largest rate (`exact`) or by how much that exceeds `allowed` [1/s]; see [`Rate`].
    fn rate(&self, block: &ElementBlock, chunk: &ChunkForces, allowed: f64, exact: bool) -> (f64, f64);
    /// Σ_q w ΔE:ΔE [m³] of a chunk between two displacements of its nodes [m], and g [m²]; see [`ChangeOfStrain`].
    fn change_of_strain(&self, chunk: &Chunk, ends: &[Vec<Vec3>; 2], g: &mut [Vec3]) -> f64;
    /// All points of a batch.
    fn eval_points(&self, block: &ElementBlock, batch: usize, input: PointInput, points: &mut PointBatch);
    /// Tangent stiffness of a batch at the displacements `u` [m], nodes × 3.
    fn eval_stiffness(&self, block: &ElementBlock, batch: usize, u: &[Vec3], stiffness: &mut StiffnessBatch);
    /// Bytes in memory.
    fn memory(&self) -> usize;
}

/// The batches of a block.
#[derive(Debug)]
pub(super) struct Packed<E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    pub batches: Vec<Batch<E, N, Q>>,
    /// Empty in other formulations.
    pub one_point: Vec<E::OnePoint>,
    kernel: Box<dyn Kernel<E, N, Q>>,
}

/// Elements with their chunks and the global nodes of those.
pub(super) type Cut = (Box<dyn Elements>, Vec<Chunk>, Vec<u32>);

macro_rules! in_blocks {
    ($($Kind:ident, $N:literal, $Q:literal, $OnePoint:ident;)*) => {
        $(impl InBlocks<$N, $Q> for element::$Kind {
            type OnePoint = $OnePoint;
        })*

        /// Packs elements of one kind into batches and cuts these into chunks.
        pub(super) fn pack_elements(kind: ElementKind, parameters: &BlockParameters, inputs: &[BlockInput]) -> Cut {
            match kind { $(ElementKind::$Kind => Packed::<element::$Kind, $N, $Q>::cut(parameters, inputs),)* }
        }
    };
}
for_each_element!(in_blocks);

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> Packed<E, N, Q> {
    fn cut(parameters: &BlockParameters, inputs: &[BlockInput]) -> Cut {
        let mut packed = Self {
            batches: inputs.chunks(BATCH).map(|lanes| pack(lanes, parameters)).collect(),
            one_point: inputs
                .chunks(BATCH)
                .filter_map(|lanes| E::OnePoint::pack(lanes, parameters))
                .collect(),
            kernel: sweep::kernel(parameters),
        };
        let (chunks, nodes) = super::chunk::cut_chunks(&mut packed.batches, inputs);
        (Box::new(packed), chunks, nodes)
    }
}

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> Elements for Packed<E, N, Q> {
    fn nodes(&self, batch: usize) -> &[[u16; BATCH]] {
        &self.batches[batch].nodes
    }
    fn inverse_weights(&self, batch: usize) -> &[Row] {
        &self.batches[batch].inverse_weight
    }
    fn sweep(&self, block: &ElementBlock, input: &SweepInput, forces: &mut ChunkForces) {
        self.kernel.sweep(self, block, input, forces);
    }
    fn add_viscous(&self, block: &ElementBlock, chunk: &mut ChunkForces) {
        pulp::Arch::new().dispatch(Viscous { elements: self, block, chunk });
    }
    fn add_memory(&self, block: &ElementBlock, input: &SweepInput, chunk: &mut ChunkForces) {
        with_law!(block.parameters.material, law => pulp::Arch::new().dispatch(Memory { law, elements: self, block, input, chunk }));
    }
    fn judge(&self, block: &ElementBlock, limits: ErosionLimits, chunk: &mut ChunkForces) {
        pulp::Arch::new().dispatch(Judge { elements: self, block, limits, chunk });
    }
    fn rate(&self, block: &ElementBlock, chunk: &ChunkForces, allowed: f64, exact: bool) -> (f64, f64) {
        let (elements, range) = (self, &block.chunks[chunk.chunk as usize].batches);
        if exact {
            pulp::Arch::new().dispatch(Rate::<true, E, N, Q> { elements, range, chunk, allowed })
        } else {
            pulp::Arch::new().dispatch(Rate::<false, E, N, Q> { elements, range, chunk, allowed })
        }
    }
    fn change_of_strain(&self, chunk: &Chunk, ends: &[Vec<Vec3>; 2], g: &mut [Vec3]) -> f64 {
        pulp::Arch::new().dispatch(ChangeOfStrain { elements: self, chunk, ends, g })
    }
    fn eval_points(&self, block: &ElementBlock, batch: usize, input: PointInput, points: &mut PointBatch) {
        with_law!(block.parameters.material, law => {
            pulp::Arch::new().dispatch(Points::new(law, (self, block, batch), input, points));
        });
    }
    fn eval_stiffness(&self, block: &ElementBlock, batch: usize, u: &[Vec3], stiffness: &mut StiffnessBatch) {
        with_law!(block.parameters.material, law => {
            pulp::Arch::new().dispatch(Stiffness::new(law, (self, block, batch), u, stiffness));
        });
    }
    fn memory(&self) -> usize {
        size_of_val(&self.batches[..]) + size_of_val(&self.one_point[..])
    }
}

/// One batch; lanes beyond the chunk repeat its last element with zero volume. The nodes are numbered later.
fn pack<E: Element<N, Q>, const N: usize, const Q: usize>(
    chunk: &[BlockInput],
    parameters: &BlockParameters,
) -> Batch<E, N, Q> {
    let (density, moduli) = (parameters.density, parameters.material.moduli_at_rest());
    let mut batch = Batch {
        corners: [[Row::default(); N]; 3],
        inverse_weight: [Row::default(); Q],
        volume: Row::default(),
        scaled_inverse_volume: Row::default(),
        frequency_bound: Row::default(),
        length: Row([1.0; BATCH]),
        corner_stiffness: [Row::default(); 2],
        inverse_least_mass: Row::default(),
        nodes: [[0; BATCH]; N],
        kind: PhantomData,
    };
    for lane in 0..BATCH {
        let BlockInput { geometry, corners, .. } = &chunk[lane.min(chunk.len() - 1)];
        for (corner, X) in corners.iter().take(N).enumerate() {
            for i in 0..3 {
                batch.corners[i][corner].0[lane] = X[i] / E::SCALE;
            }
        }
        // Padding keeps zero weights: F = I, no stress, no volume, no limit on the step.
        if lane >= chunk.len() {
            continue;
        }
        for (row, volume) in batch.inverse_weight.iter_mut().zip(&geometry.volume) {
            row.0[lane] = 1.0 / volume;
        }
        batch.volume.0[lane] = geometry.total_volume();
        batch.scaled_inverse_volume.0[lane] = E::SCALE / geometry.total_volume();
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

#[cfg(test)]
mod tests;
