//! The elements of a block in batches: constants lane by lane, of one kind.

use super::chunk::{Chunk, cut_chunks};
use super::parameters::{BlockInput, BlockParameters};
use super::reduced::{NoOnePoint, OnePointBatch, ReducedBatch};
use crate::element::{self, Element, ElementKind, corner_stiffness, for_each_element};
use crate::lanes::{BATCH, Row};
use std::marker::PhantomData;

/// Constants of a batch of elements, lane by lane: 328 bytes a hexahedron.
///
/// The reference geometry at the points is made again from the corners at every evaluation, for a tenth of its arithmetic;
/// stored, it would be 640 bytes an element, which a large mesh waits for.
#[derive(Clone, Debug)]
pub(super) struct Batch<E, const N: usize, const Q: usize> {
    /// Positions X of the nodes, less that of the first, over [`Element::SCALE`]: `[component][node]` [m].
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
    /// Parameters of the corner penalty: energy [J], inverse of the volume deficit of a flat corner [1/m³] and hardening [-]; zero in padding.
    pub corner_stiffness: [Row; 3],
    /// 1/(ρ V_c), V_c the least volume of a corner: ω² of a stiffness is at most that times its norm [1/kg]; zero in padding.
    pub inverse_least_mass: Row,
    /// Nodes, numbered within the chunk: `[node][lane]`.
    pub nodes: [[u16; BATCH]; N],
    kind: PhantomData<E>,
}

/// An element with its one-point formulation.
pub(super) trait InBlocks<const N: usize, const Q: usize>: Element<N, Q> {
    /// Which one it is.
    const KIND: ElementKind;
    /// Further constants of the batches of one-point elements.
    type OnePoint: OnePointBatch<N>;
}

/// The batches of a block whose elements are of one kind.
#[derive(Debug)]
pub(super) struct Packed<E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    pub batches: Vec<Batch<E, N, Q>>,
    /// Empty in other formulations.
    pub one_point: Vec<E::OnePoint>,
}

/// Elements with their chunks and the global nodes of those.
type Cut<T> = (T, Vec<Chunk>, Vec<u32>);

/// Makes of the list of elements the enum [`Elements`], and `with_elements!`, which matches it. `$dollar` is a dollar sign, for the inner
/// macro.
macro_rules! in_blocks {
    ($dollar:tt $($Kind:ident, $N:literal, $Q:literal, $OnePoint:ident;)*) => {
        $(impl InBlocks<$N, $Q> for element::$Kind {
            const KIND: ElementKind = ElementKind::$Kind;
            type OnePoint = $OnePoint;
        }
        )*

        /// The batches of a block, by the kind of its elements.
        #[derive(Debug)]
        pub(super) enum Elements {
            $($Kind(Packed<element::$Kind, $N, $Q>),)*
        }

        impl Elements {
            /// Packs elements of one kind into batches and cuts these into chunks.
            pub fn cut(kind: ElementKind, parameters: &BlockParameters, inputs: &[BlockInput]) -> Cut<Self> {
                match kind {
                    $(ElementKind::$Kind => {
                        let (packed, chunks, nodes) = Packed::cut(parameters, inputs);
                        (Self::$Kind(packed), chunks, nodes)
                    })*
                }
            }
        }

        /// Runs `$body` with `$elements` bound to the [`Packed`] elements of a block; with a material also `$law` to what the kernels of
        /// such elements are compiled for.
        macro_rules! with_elements {
            ($dollar packed:expr, $dollar elements:ident => $dollar body:expr) => {
                match $dollar packed {
                    $($crate::force::packed::Elements::$Kind($dollar elements) => $dollar body,)*
                }
            };
            ($dollar packed:expr, $dollar material:expr; $dollar elements:ident, $dollar law:ident => $dollar body:expr) => {
                match $dollar packed {
                    $($crate::force::packed::Elements::$Kind($dollar elements) => {
                        // The condition is a constant: the branch not taken is not compiled.
                        if <$crate::element::$Kind as $crate::element::Element<$N, $Q>>::KERNELS_OF_LAWS {
                            $crate::material::with_kernel_law!($dollar material, $dollar law => $dollar body)
                        } else {
                            let $dollar law = $dollar material;
                            $dollar body
                        }
                    })*
                }
            };
        }
        pub(super) use with_elements;
    };
}
for_each_element!(in_blocks $);

impl<E: InBlocks<N, Q>, const N: usize, const Q: usize> Packed<E, N, Q> {
    fn cut(parameters: &BlockParameters, inputs: &[BlockInput]) -> Cut<Self> {
        let lanes = || inputs.chunks(BATCH);
        let mut batches: Vec<_> = lanes().map(|lanes| pack(lanes, parameters)).collect();
        let one_point = lanes().filter_map(|lanes| E::OnePoint::pack(lanes, parameters)).collect();
        let mut nodes: Vec<_> =
            batches.iter_mut().map(|batch: &mut Batch<E, N, Q>| &mut batch.nodes).collect();
        let (chunks, nodes) = cut_chunks(&mut nodes, inputs);
        (Self { batches, one_point }, chunks, nodes)
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
        corner_stiffness: [Row::default(); 3],
        inverse_least_mass: Row::default(),
        nodes: [[0; BATCH]; N],
        kind: PhantomData,
    };
    for lane in 0..BATCH {
        let BlockInput { geometry, corners, .. } = &chunk[lane.min(chunk.len() - 1)];
        for (corner, X) in corners.iter().take(N).enumerate() {
            for i in 0..3 {
                batch.corners[i][corner].0[lane] = (X[i] - corners[0][i]) / E::SCALE;
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
        let of_corners = corner_stiffness::<E, N, Q>(moduli, geometry.total_volume());
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
