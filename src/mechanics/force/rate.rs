//! How fast elements are being stretched: what limits `h max|D|`, the strain of a step.

use super::block::ElementBlock;
use super::chunk::ChunkForces;
use super::packed::{Batch, InBlocks, Packed, with_elements};
use super::rows::{gather, keep_still};
use super::{Assembly, ElementForces, Threads};
use crate::element::Element;
use crate::lanes::{BATCH, Lane, Row};
use crate::real::Real;
use crate::tensor::Vec3;
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// A rate below this fraction of the allowed one is below it in exact arithmetic too.
const CERTAIN: f64 = 1.0 - 1e-12;

/// Least length that stretch is relative to, over that at rest. Where an edge or diagonal passes through zero while its element
/// is well (hourglass modes that add up at one corner), a rate relative to its own length would let the step follow it to zero.
const LEAST_LENGTH: f64 = 0.25;

/// Relative stretch rate `|Δv·Δx| / max(|Δx|², (¼ |ΔX|)²)` of an edge or diagonal ΔX [m] at rest, Δx [m] now, Δv [m/s] [1/s].
pub fn stretch_rate(dX: &Vec3, dx: &Vec3, dv: &Vec3) -> f64 {
    let least = LEAST_LENGTH * LEAST_LENGTH * dX.norm_squared();
    dv.dot(dx).abs() / dx.norm_squared().max(least).max(f64::MIN_POSITIVE)
}

impl ElementForces {
    /// Largest [`stretch_rate`] of the edges and body diagonals of all elements [1/s], at the
    /// positions of the last evaluation and the velocities `v` [m/s], nodes × 3; 0 when it is certain that a step of `h` [s]
    /// stretches none by more than `limit` [-]; infinite when a velocity or position is not finite.
    ///
    /// Blind to rotation, and exact for a uniform rate along each of the 16 directions. A chunk is certain to be below the
    /// limit when its velocities differ too little to stretch its shortest length so much; its shortest length is known
    /// from the last time that it was measured, less what it can have lost since.
    pub fn largest_stretch_rate(
        &mut self,
        threads: &Threads,
        blocks: &[ElementBlock],
        v: &[Vec3],
        h: f64,
        limit: f64,
    ) -> f64 {
        threads.for_each(&mut self.chunks, |chunk| {
            if chunk.active == 0 {
                chunk.stretch_rate = 0.0;
                return;
            }
            let block = &blocks[chunk.block as usize];
            let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
            let mut witness = Vec3::zeros();
            for (local, node) in chunk.v.iter_mut().zip(block.nodes_of_chunk(chunk.chunk as usize)) {
                *local = v[*node as usize];
                // Not `inf` and `sup`: they compare by branches.
                low = low.zip_map(local, f64::min);
                high = high.zip_map(local, f64::max);
                witness += *local;
            }
            // Comparisons lose a NaN, sums keep it.
            if !(witness.x.is_finite() && witness.y.is_finite() && witness.z.is_finite()) {
                chunk.stretch_rate = f64::INFINITY;
                return;
            }
            let difference = (high - low).norm();
            chunk.stretch_rate = 0.0;
            if difference * h > limit * chunk.shortest {
                // Divisions are most of what exact rates cost: they wait until an element is seen to need them.
                let allowed = CERTAIN * limit / h;
                let (excess, shortest) = block.rate::<false>(chunk, allowed);
                chunk.shortest = shortest;
                if !(excess <= 0.0) {
                    (chunk.stretch_rate, _) = block.rate::<true>(chunk, allowed);
                }
            }
            chunk.shortest -= difference * h;
        });
        self.chunks.iter().map(|chunk| chunk.stretch_rate).fold(0.0, f64::max)
    }

    /// Forgets what is known of lengths at a node that was moved otherwise than by its velocity.
    pub fn forget_lengths(&mut self, assembly: &Assembly, node: u32) {
        for (chunk, _) in assembly.places(node as usize) {
            self.chunks[*chunk as usize].shortest = 0.0;
        }
    }
}

impl ElementBlock {
    /// Largest rate of a chunk, or what it exceeds `allowed` by, and its shortest length, see [`Rate`].
    fn rate<const EXACT: bool>(&self, chunk: &ChunkForces, allowed: f64) -> (f64, f64) {
        let range = &self.chunks[chunk.chunk as usize].batches;
        with_elements!(&self.packed, elements => {
            pulp::Arch::new().dispatch(Rate::<EXACT, _, _, _> { elements, range, chunk, allowed })
        })
    }
}

/// Shortest length of a chunk that stretch is relative to, from its `u` and `v`, beside its largest rate where that is `EXACT`,
/// else by how much `|Δv·Δx|` exceeds `allowed` [1/s] times the square of that length at most.
struct Rate<'a, const EXACT: bool, E: InBlocks<N, Q>, const N: usize, const Q: usize> {
    elements: &'a Packed<E, N, Q>,
    /// Batches of the chunk.
    range: &'a Range<u32>,
    chunk: &'a ChunkForces,
    allowed: f64,
}

impl<const EXACT: bool, E: InBlocks<N, Q>, const N: usize, const Q: usize> WithSimd
    for Rate<'_, EXACT, E, N, Q>
{
    type Output = (f64, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (f64, f64) {
        let (chunk, range) = (self.chunk, self.range);
        let least = if EXACT { 0.0 } else { f64::NEG_INFINITY };
        let mut extremes = [Row([least; BATCH]), Row([f64::INFINITY; BATCH]), Row([0.0; BATCH])];
        let (mut u, mut v) = ([[Row::default(); N]; 3], [[Row::default(); N]; 3]);
        let batches = &self.elements.batches[range.start as usize..range.end as usize];
        for (i, batch) in batches.iter().enumerate() {
            gather(&batch.nodes, &chunk.u, &mut u);
            gather(&batch.nodes, &chunk.v, &mut v);
            keep_still(chunk.eroded_lanes(i), &mut u);
            keep_still(chunk.eroded_lanes(i), &mut v);
            for part in 0..BATCH / S::F64_LANES {
                rate_of_batch::<S, EXACT, E, N, Q>(simd, part, batch, (&u, &v), self.allowed, &mut extremes);
            }
        }
        let [largest, squares, witnesses] = extremes;
        if !witnesses.0.iter().all(|w| w.is_finite()) {
            return (f64::INFINITY, 0.0);
        }
        let shortest = squares.0.into_iter().fold(f64::INFINITY, f64::min).sqrt();
        (largest.0.into_iter().fold(least, f64::max), shortest)
    }
}

/// Updates (largest rate or excess, shortest squared length, a sum that is finite when all are) of each lane.
#[inline(always)]
fn rate_of_batch<S: Simd, const EXACT: bool, E: Element<N, Q>, const N: usize, const Q: usize>(
    simd: S,
    part: usize,
    batch: &Batch<E, N, Q>,
    (u, v): (&[[Row; N]; 3], &[[Row; N]; 3]),
    allowed: f64,
    extremes: &mut [Row; 3],
) {
    let mut largest = Lane::load(simd, &extremes[0], part);
    let mut shortest = Lane::load(simd, &extremes[1], part);
    let mut witness = Lane::load(simd, &extremes[2], part);
    for &(a, b) in E::LENGTHS {
        let (mut along, mut length) = (Lane::splat(simd, 0.0), Lane::splat(simd, f64::MIN_POSITIVE));
        let mut at_rest = along;
        for i in 0..3 {
            let dX =
                Lane::load(simd, &batch.corners[i][b], part) - Lane::load(simd, &batch.corners[i][a], part);
            let du = Lane::load(simd, &u[i][b], part) - Lane::load(simd, &u[i][a], part);
            let dx = dX.mul_add(dX.constant(E::SCALE), du);
            let dv = Lane::load(simd, &v[i][b], part) - Lane::load(simd, &v[i][a], part);
            along = dx.mul_add(dv, along);
            length = dx.mul_add(dx, length);
            at_rest = dX.mul_add(dX, at_rest);
        }
        let along = along.abs();
        witness += along + length;
        let length = length.max(at_rest * (LEAST_LENGTH * LEAST_LENGTH * E::SCALE * E::SCALE));
        largest = largest.max(if EXACT { along / length } else { along - length * allowed });
        shortest = shortest.min(length);
    }
    largest.store(&mut extremes[0], part);
    shortest.store(&mut extremes[1], part);
    witness.store(&mut extremes[2], part);
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // the same bits are what is meant
mod tests {
    use super::*;
    use crate::element::{ElementKind, HEX8_DIAGONALS, HEX8_EDGES, OfElement, ReferenceGeometry};
    use crate::force::{BlockInput, BlockParameters, ForceInput, Formulation};
    use crate::material::{CoupledNeoHookean, Material};
    use crate::tensor::Mat3;

    /// Nineteen distorted elements in a row, each with corners of its own, and a block of them.
    fn row() -> (Vec<Vec3>, ElementBlock) {
        let corner =
            |a: u32| Vec3::new(f64::from((a ^ (a >> 1)) & 1), f64::from((a >> 1) & 1), f64::from(a >> 2));
        let wave = |i: u32| (f64::from(i) * 1.7).sin() * 0.1;
        let x: Vec<Vec3> = (0..19 * 8)
            .map(|i| corner(i % 8) + Vec3::new(wave(i) + f64::from(i / 8), wave(i + 1), wave(i + 2)))
            .collect();
        let inputs: Vec<BlockInput> = (0..19)
            .map(|element| {
                let nodes: [u32; 8] = std::array::from_fn(|a| 8 * element + a as u32);
                let corners = nodes.map(|node| x[node as usize]);
                let geometry = ReferenceGeometry::new(ElementKind::Hex8, &corners);
                BlockInput {
                    element,
                    nodes: OfElement::from_slice(&nodes),
                    corners: OfElement::from_slice(&corners),
                    axes: Mat3::identity(),
                    geometry,
                }
            })
            .collect();
        let parameters = BlockParameters::elastic(
            Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1.0, lambda: 1.0 }),
            Formulation::Full,
            1.0,
        );
        (x, ElementBlock::new(0, parameters, 0, &inputs).unwrap())
    }

    /// The rate at rest, exact: no step is short enough to be certain.
    fn rate(block: ElementBlock, v: &[Vec3]) -> f64 {
        let blocks = [block];
        ElementForces::new(&blocks).largest_stretch_rate(&Threads::ONE, &blocks, v, 1.0, 0.0)
    }

    #[test]
    fn rate_is_the_largest_of_all_pairs() {
        let (x, block) = row();
        let v: Vec<Vec3> =
            x.iter().map(|x| Vec3::new((x.y * 3.0).sin(), x.x * 0.1, (x.z + x.x).cos())).collect();
        let mut expected = 0.0_f64;
        for element in 0..19 {
            for (a, b) in HEX8_EDGES.into_iter().chain(HEX8_DIAGONALS) {
                let (dx, dv) =
                    (x[8 * element + b] - x[8 * element + a], v[8 * element + b] - v[8 * element + a]);
                expected = expected.max(stretch_rate(&dx, &dx, &dv));
            }
        }
        let found = rate(block, &v);
        assert!((found - expected).abs() <= 1e-14 * expected, "{found} against {expected}");
    }

    #[test]
    fn an_edge_that_passes_through_zero_is_stretched_at_a_finite_rate() {
        let x = row().0;
        let (a, b) = (x[0], x[1]);
        for fraction in [1e-3, 1e-6, 0.0, -1e-6] {
            let mut u = vec![Vec3::zeros(); x.len()];
            u[1] = (a - b) * (1.0 - fraction);
            let mut v = vec![Vec3::zeros(); x.len()];
            v[1] = a - b;
            let blocks = [row().1];
            let mut forces = ElementForces::new(&blocks);
            let input = ForceInput::at(&u);
            forces.evaluate(&Threads::ONE, &blocks, &input);
            // Within the step that a limit of a tenth allows the edge gets to the other side.
            let rate = forces.largest_stretch_rate(&Threads::ONE, &blocks, &v, 1.0, 0.0);
            assert!((0.1..4.0).contains(&rate), "{fraction}: {rate}");
            assert!(stretch_rate(&(b - a), &((b - a) * fraction), &(a - b)) <= 16.0 * fraction.abs() + 1e-15);
        }
    }

    #[test]
    fn rotation_and_rest_stretch_nothing() {
        let (x, block) = row();
        let spinning: Vec<Vec3> = x.iter().map(|x| Vec3::new(0.3, -0.2, 0.9).cross(x)).collect();
        assert!(rate(block, &spinning) < 1e-14);
        assert!(rate(row().1, &vec![Vec3::zeros(); x.len()]).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn what_is_not_finite_is_seen_wherever_it_is() {
        let (x, _) = row();
        for node in [0, 7, 77, 19 * 8 - 1] {
            for broken in [f64::NAN, f64::INFINITY] {
                let mut v: Vec<Vec3> = x.iter().map(|x| x * 0.1).collect();
                v[node].y = broken;
                assert!(rate(row().1, &v).is_infinite(), "node {node}, {broken}");
            }
        }
    }

    #[test]
    fn what_is_passed_over_is_below_the_limit() {
        // Steps that stretch more and more: the answer is 0 or exact, and never 0 above the limit.
        let (x, block) = row();
        let blocks = [block];
        let mut forces = ElementForces::new(&blocks);
        let v: Vec<Vec3> = x.iter().map(|x| Vec3::new(0.0, (x.y * 3.0).sin(), 0.1 * x.x)).collect();
        let (mut u, mut passed_over) = (vec![Vec3::zeros(); x.len()], 0);
        let (h, limit) = (2e-2, 0.1);
        for step in 0..40 {
            let v: Vec<Vec3> = v.iter().map(|v| v * (0.2 * f64::from(step))).collect();
            let input = ForceInput::at(&u);
            forces.evaluate(&Threads::ONE, &blocks, &input);
            let mut exact = ElementForces::new(&blocks);
            exact.evaluate(&Threads::ONE, &blocks, &input);
            let exact = exact.largest_stretch_rate(&Threads::ONE, &blocks, &v, h, 0.0);
            let found = forces.largest_stretch_rate(&Threads::ONE, &blocks, &v, h, limit);
            assert!(found == exact || (found == 0.0 && exact * h <= limit), "{found} against {exact}");
            passed_over += u32::from(found == 0.0);
            u.iter_mut().zip(&v).for_each(|(u, v)| *u += v * h);
        }
        assert!((3..40).contains(&passed_over), "{passed_over}");
    }
}
