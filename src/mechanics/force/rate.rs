//! How fast elements are being stretched: the limit `h max|D| ≤ 0.1` of the step.

use super::block::ElementBlock;
use super::sweep::gather;
use crate::mechanics::element::{HEX8_DIAGONALS, HEX8_EDGES};
use crate::mechanics::lanes::{BATCH, Lane};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::Vec3;
use pulp::{Simd, WithSimd};

/// Largest relative stretch rate `|Δv·Δx| / |Δx|²` of the edges and body diagonals of a range of batches [1/s]; infinite
/// when a velocity or position is not finite.
///
/// Blind to rotation, and exact for a uniform rate along each of the 16 directions. Velocities that are zero bit by bit
/// stretch nothing, so elements that nothing has reached yet are passed over.
pub fn largest_stretch_rate(
    block: &ElementBlock,
    batches: std::ops::Range<usize>,
    x: &[Vec3],
    v: &[Vec3],
) -> f64 {
    pulp::Arch::new().dispatch(Rate { block, batches, x, v })
}

struct Rate<'a> {
    block: &'a ElementBlock,
    batches: std::ops::Range<usize>,
    x: &'a [Vec3],
    v: &'a [Vec3],
}

impl WithSimd for Rate<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let zero = Lane::splat(simd, 0.0);
        let (mut largest, mut witness) = (zero, zero);
        let (mut x, mut v) = ([[[0.0; BATCH]; 8]; 3], [[[0.0; BATCH]; 8]; 3]);
        for batch in &self.block.batches[self.batches] {
            if batch.nodes.as_flattened().iter().all(|node| self.v[*node as usize] == Vec3::zeros()) {
                continue;
            }
            gather(&batch.nodes, self.x, &mut x);
            gather(&batch.nodes, self.v, &mut v);
            for part in 0..BATCH / S::F64_LANES {
                for (a, b) in HEX8_EDGES.into_iter().chain(HEX8_DIAGONALS) {
                    let (mut along, mut length) = (zero, Lane::splat(simd, f64::MIN_POSITIVE));
                    for i in 0..3 {
                        let dx = Lane::load(simd, &x[i][b], part) - Lane::load(simd, &x[i][a], part);
                        let dv = Lane::load(simd, &v[i][b], part) - Lane::load(simd, &v[i][a], part);
                        along = dx.mul_add(dv, along);
                        length = dx.mul_add(dx, length);
                    }
                    let along = along.abs();
                    witness += along;
                    largest = largest.max(along / length);
                }
            }
        }
        let (mut rates, mut witnesses) = ([0.0; BATCH], [0.0; BATCH]);
        largest.store(&mut rates, 0);
        witness.store(&mut witnesses, 0);
        // Comparisons lose a NaN, sums keep it.
        if witnesses.iter().all(|w| w.is_finite()) {
            rates.into_iter().fold(0.0, f64::max)
        } else {
            f64::INFINITY
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::element::ReferenceGeometry;
    use crate::mechanics::force::{BlockInput, BlockParameters};
    use crate::mechanics::material::{CoupledNeoHookean, Material};
    use crate::mechanics::tensor::Mat3;

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
                let geometry = ReferenceGeometry::new(&nodes.map(|node| x[node as usize]));
                BlockInput { element, nodes, axes: Mat3::identity(), geometry }
            })
            .collect();
        let parameters = BlockParameters {
            material: Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1.0, lambda: 1.0 }),
            mean_dilatation: false,
            density: 1.0,
            linear_viscosity: 0.0,
            quadratic_viscosity: 0.0,
        };
        (x, ElementBlock::new(0, parameters, 0, &inputs))
    }

    fn rate(block: &ElementBlock, x: &[Vec3], v: &[Vec3]) -> f64 {
        largest_stretch_rate(block, 0..block.batch_count(), x, v)
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
                expected = expected.max(dx.dot(&dv).abs() / dx.norm_squared());
            }
        }
        let found = rate(&block, &x, &v);
        assert!((found - expected).abs() <= 1e-14 * expected, "{found} against {expected}");
    }

    #[test]
    fn rotation_and_rest_stretch_nothing() {
        let (x, block) = row();
        let spinning: Vec<Vec3> = x.iter().map(|x| Vec3::new(0.3, -0.2, 0.9).cross(x)).collect();
        assert!(rate(&block, &x, &spinning) < 1e-14);
        assert!(rate(&block, &x, &vec![Vec3::zeros(); x.len()]).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn what_is_not_finite_is_seen_wherever_it_is() {
        let (x, block) = row();
        for node in [0, 7, 77, 19 * 8 - 1] {
            for broken in [f64::NAN, f64::INFINITY] {
                let mut v: Vec<Vec3> = x.iter().map(|x| x * 0.1).collect();
                v[node].y = broken;
                assert!(rate(&block, &x, &v).is_infinite(), "node {node}, {broken}");
            }
        }
    }
}
