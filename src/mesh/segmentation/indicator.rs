//! Smooth indicators of the classes: φ_a(x) = Σ_v B(x − x_v) [class of v is a], with a cubic B-spline along each axis.
//!
//! The surface between a and b is φ_a = φ_b. It is smooth, lies in the middle between flat layers of voxels, and is where the
//! labels put it up to the curvature over the width of the spline.

use super::grid::ClassGrid;
use crate::mechanics::tensor::Vec3;

/// Least width of the spline in voxels: its standard deviation is 0.58 of that.
const LEAST_WIDTH: f64 = 1.25;

/// Voxels of the spline along an axis, at most: ±2 widths, sampled at less than a width.
const MOST_SAMPLES: usize = 8;

/// Indicator φ of a class, and its gradient [1/m].
#[derive(Clone, Copy, Debug)]
pub struct Indicator {
    /// Value [-]; the values of all classes have the sum 1, where nothing is beyond the grid.
    pub value: f64,
    /// Gradient [1/m].
    pub gradient: Vec3,
}

/// Weights of the voxels of a row.
#[derive(Clone, Copy)]
struct Row {
    first: i64,
    stride: i64,
    count: usize,
    weights: [f64; MOST_SAMPLES],
    slopes: [f64; MOST_SAMPLES],
}

impl Row {
    /// Weights around a position [m] along an axis of voxels at distances `spacing` [m], for a spline of this width [m].
    fn new(position: f64, spacing: f64, width: f64) -> Self {
        let width = width.max(LEAST_WIDTH * spacing);
        let stride = (width / (LEAST_WIDTH * spacing)).floor().max(1.0);
        let step = stride * spacing;
        // Voxels whose centres are within two widths.
        let centre = position / spacing - 0.5;
        let first = (centre - 2.0 * width / spacing).ceil() as i64;
        let (mut weights, mut slopes) = ([0.0; MOST_SAMPLES], [0.0; MOST_SAMPLES]);
        let (mut count, mut sum, mut change) = (0, 0.0, 0.0);
        while count < MOST_SAMPLES {
            let at = (first as f64 - centre) * spacing + count as f64 * step;
            if at >= 2.0 * width {
                break;
            }
            (weights[count], slopes[count]) = spline(-at / width);
            slopes[count] /= width;
            sum += weights[count];
            change += slopes[count];
            count += 1;
        }
        // Of any width and offset, the weights have the sum 1.
        for i in 0..count {
            weights[i] /= sum;
            slopes[i] = (slopes[i] - weights[i] * change) / sum;
        }
        Self { first, stride: stride as i64, count, weights, slopes }
    }

    fn voxel(&self, i: usize) -> i64 {
        self.first + self.stride * i as i64
    }
}

/// Cubic B-spline of unit width, and its slope.
fn spline(t: f64) -> (f64, f64) {
    let (a, sign) = (t.abs(), t.signum());
    if a < 1.0 {
        (2.0 / 3.0 - a * a + 0.5 * a * a * a, sign * (1.5 * a * a - 2.0 * a))
    } else if a < 2.0 {
        let b = 2.0 - a;
        (b * b * b / 6.0, -sign * 0.5 * b * b)
    } else {
        (0.0, 0.0)
    }
}

impl ClassGrid {
    /// Indicators of all classes at a position [m], smoothed over `width` [m] or the least that voxels allow.
    pub fn indicators(&self, p: &Vec3, width: f64, out: &mut Vec<Indicator>) {
        out.clear();
        out.resize(self.count, Indicator { value: 0.0, gradient: Vec3::zeros() });
        let [x, y, z] = [0, 1, 2].map(|k| Row::new(p[k], self.spacing[k], width));
        let inside = |voxel: i64, k: usize| voxel.clamp(0, self.dims[k] as i64 - 1) as usize;
        for k in 0..z.count {
            let plane = self.dims[1] * inside(z.voxel(k), 2);
            for j in 0..y.count {
                let row = self.dims[0] * (plane + inside(y.voxel(j), 1));
                let (yz, dy, dz) =
                    (y.weights[j] * z.weights[k], y.slopes[j] * z.weights[k], y.weights[j] * z.slopes[k]);
                for i in 0..x.count {
                    let found = &mut out[usize::from(self.classes[row + inside(x.voxel(i), 0)])];
                    found.value += x.weights[i] * yz;
                    found.gradient.x += x.slopes[i] * yz;
                    found.gradient.y += x.weights[i] * dy;
                    found.gradient.z += x.weights[i] * dz;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Layers along x: class 0 below 5 m, class 1 above; voxels of 1 × 1 × 2 m.
    fn layers() -> ClassGrid {
        let classes = (0..1000).map(|voxel| u8::from(voxel % 10 >= 5)).collect();
        ClassGrid { dims: [10; 3], spacing: [1.0, 1.0, 2.0], classes, count: 2, first: [0; 3] }
    }

    #[test]
    fn indicators_meet_in_the_middle_and_have_the_sum_one() {
        let (grid, mut found) = (layers(), Vec::new());
        for width in [0.0, 2.0, 4.0] {
            grid.indicators(&Vec3::new(5.0, 4.3, 9.1), width, &mut found);
            assert!((found[0].value - 0.5).abs() < 0.05, "{width}: {found:?}");
            assert!((found[0].value + found[1].value - 1.0).abs() < 1e-12);
            assert!(found[1].gradient.x > 0.05 && found[1].gradient.yz().norm() < 1e-9);
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_value() {
        let (grid, mut found) = (layers(), Vec::new());
        let mut value = |x: f64| {
            grid.indicators(&Vec3::new(x, 4.0, 9.0), 0.0, &mut found);
            found[1]
        };
        let (low, high, middle) = (value(5.299), value(5.301), value(5.3));
        assert!(((high.value - low.value) / 0.002 - middle.gradient.x).abs() < 1e-2 * middle.gradient.x);
    }
}
