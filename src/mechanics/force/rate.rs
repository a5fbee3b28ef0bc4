//! How fast elements are being stretched: the limit `h max|D| ≤ 0.1` of the step.

use super::block::ElementBlock;
use super::sweep::gather;
use crate::mechanics::element::{HEX8_DIAGONALS, HEX8_EDGES};
use crate::mechanics::lanes::{BATCH, Lane};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::Vec3;
use pulp::{Simd, WithSimd};

/// Largest relative stretch rate `|Δv·Δx| / |Δx|²` of the edges and body diagonals of a range of batches [1/s].
///
/// Blind to rotation, and exact for a uniform rate along each of the 16 directions.
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
        let mut largest = Lane::splat(simd, 0.0);
        let (mut x, mut v) = ([[[0.0; BATCH]; 8]; 3], [[[0.0; BATCH]; 8]; 3]);
        for batch in &self.block.batches[self.batches] {
            gather(&batch.nodes, self.x, &mut x);
            gather(&batch.nodes, self.v, &mut v);
            for part in 0..BATCH / S::F64_LANES {
                for (a, b) in HEX8_EDGES.into_iter().chain(HEX8_DIAGONALS) {
                    let (mut along, mut length) =
                        (Lane::splat(simd, 0.0), Lane::splat(simd, f64::MIN_POSITIVE));
                    for i in 0..3 {
                        let dx = Lane::load(simd, &x[i][b], part) - Lane::load(simd, &x[i][a], part);
                        let dv = Lane::load(simd, &v[i][b], part) - Lane::load(simd, &v[i][a], part);
                        along = dx.mul_add(dv, along);
                        length = dx.mul_add(dx, length);
                    }
                    largest = largest.max(along.abs() / length);
                }
            }
        }
        let mut out = [0.0; BATCH];
        largest.store(&mut out, 0);
        out.into_iter().fold(0.0, f64::max)
    }
}
