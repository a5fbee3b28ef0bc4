//! The surface of a cube as a lattice of quadrilaterals, and its equiangular map to the sphere.

use crate::mechanics::tensor::Vec3;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

/// The surface of a cube, each face divided into n × n quadrilaterals.
pub(super) struct CubeSurface {
    /// Lattice coordinates 0..=n of the points.
    pub(super) points: Vec<[u32; 3]>,
    /// Indices into `points`, counter-clockwise seen from outside.
    pub(super) quads: Vec<[u32; 4]>,
}

impl CubeSurface {
    /// The surface with `n` quadrilaterals along each edge of the cube, points in order of their first use.
    pub(super) fn new(n: u32) -> Self {
        let mut points = Vec::new();
        let mut index: HashMap<[u32; 3], u32> = HashMap::new();
        let mut quads = Vec::new();
        for (axis, side) in [(0, 0), (0, n), (1, 0), (1, n), (2, 0), (2, n)] {
            for (v, u) in (0..n).flat_map(|v| (0..n).map(move |u| (v, u))) {
                // (u, v) run along the next two axes in cyclic order, so that u × v points along `axis`.
                let mut quad = [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)].map(|(u, v)| {
                    let mut point = [side; 3];
                    (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (u, v);
                    *index.entry(point).or_insert_with(|| {
                        points.push(point);
                        (points.len() - 1) as u32
                    })
                });
                if side == 0 {
                    quad.reverse();
                }
                quads.push(quad);
            }
        }
        Self { points, quads }
    }
}

/// Lattice coordinates 0..=n as a point of the cube [−1, 1]³, spaced so that equal steps span equal angles from the centre
/// of a face: tan(π/4 · (2i − n)/n).
///
/// Ronchi, Iacono & Paolucci (1996): the elements of the sphere are far more uniform than with equal steps.
pub(super) fn equiangular(point: [u32; 3], n: u32) -> Vec3 {
    Vec3::from(point.map(|i| {
        let steps = f64::from(2 * i) - f64::from(n);
        // The faces lie exactly at ±1, which tan(π/4) misses by rounding.
        if steps.abs() >= f64::from(n) { steps.signum() } else { (FRAC_PI_4 * steps / f64::from(n)).tan() }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_is_closed() {
        for n in [1, 2, 5] {
            let surface = CubeSurface::new(n);
            assert_eq!(surface.quads.len() as u32, 6 * n * n);
            // Euler: V − E + F = 2 with E = 2 F.
            assert_eq!(surface.points.len() as u32, 6 * n * n + 2);
            for quad in &surface.quads {
                let x = quad.map(|a| equiangular(surface.points[a as usize], n));
                assert!((x[2] - x[0]).cross(&(x[3] - x[1])).dot(&x[0]) > 0.0, "outwards");
            }
        }
    }
}
