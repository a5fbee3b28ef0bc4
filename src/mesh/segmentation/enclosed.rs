//! Volume that a closed surface encloses in a box.
//!
//! What lies inside on a line along x is the sum of ± x over its crossings; within the box, of ± (clamp(x, x₀, x₁) − x₀). Over all
//! lines that is the integral ∮ (clamp(x, x₀, x₁) − x₀) n_x dA of what of the surface lies between the sides of the box across y and
//! z, which is exact triangle by triangle: the volume by the divergence theorem, with any ends that the box cuts closed.

use crate::mechanics::tensor::Vec3;
use crate::mesh::read::stl::ClosedSurface;

/// Volume [m³] that a surface in metres encloses in a box, which need not meet it.
pub fn enclosed_m3(surface: &ClosedSurface, [low, high]: &[Vec3; 2]) -> f64 {
    let of_triangle = |triangle: &[u32; 3]| {
        let mut within = triangle.map(|node| surface.points[node as usize]).to_vec();
        for axis in [1, 2] {
            within = clipped(&within, axis, low[axis], 1.0);
            within = clipped(&within, axis, high[axis], -1.0);
        }
        let right = clipped(&within, 0, low.x, 1.0);
        let beyond = flux(&clipped(&right, 0, high.x, 1.0), |_| high.x - low.x);
        beyond + flux(&clipped(&right, 0, high.x, -1.0), |x| x - low.x)
    };
    surface.triangles.iter().map(of_triangle).sum()
}

/// ∫ f(x) n_x dA over a plane polygon, of a linear f.
fn flux(polygon: &[Vec3], f: impl Fn(f64) -> f64) -> f64 {
    let [a, rest @ ..] = polygon else { return 0.0 };
    let fan = rest.windows(2).map(|side| {
        let (b, c) = (side[0], side[1]);
        0.5 * (b - a).cross(&(c - a)).x * f((a.x + b.x + c.x) / 3.0)
    });
    fan.sum()
}

/// The part of a convex polygon where `side` (x_axis − at) ≥ 0.
fn clipped(polygon: &[Vec3], axis: usize, at: f64, side: f64) -> Vec<Vec3> {
    let height = |x: &Vec3| side * (x[axis] - at);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (of_a, of_b) = (height(a), height(b));
        if of_a >= 0.0 {
            kept.push(*a);
        }
        if (of_a > 0.0 && of_b < 0.0) || (of_a < 0.0 && of_b > 0.0) {
            kept.push(a + (b - a) * (of_a / (of_a - of_b)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::rigid::{Shape, triangulated};

    fn surface(shape: &Shape) -> ClosedSurface {
        let (points, triangles) = triangulated(shape);
        ClosedSurface { points, triangles }
    }

    #[test]
    fn boxes_meet_in_a_box() {
        let brick = surface(&Shape::Box { half: Vec3::new(1.0, 2.0, 3.0) });
        for (low, high, expected) in [
            (Vec3::repeat(-5.0), Vec3::repeat(5.0), 48.0),
            (Vec3::new(-0.5, -0.25, 1.0), Vec3::new(0.5, 5.0, 2.5), 1.0 * 2.25 * 1.5),
            (Vec3::new(0.25, -5.0, -5.0), Vec3::new(5.0, 5.0, 5.0), 0.75 * 24.0),
            (Vec3::repeat(-0.5), Vec3::repeat(0.5), 1.0),
            (Vec3::new(1.5, -1.0, -1.0), Vec3::new(2.0, 1.0, 1.0), 0.0),
        ] {
            let found = enclosed_m3(&brick, &[low, high]);
            assert!((found - expected).abs() < 1e-12, "{found} of {expected}");
        }
    }

    #[test]
    fn the_pieces_of_a_ball_are_the_ball() {
        let ball = surface(&Shape::Ball { radius: 1.0 });
        let ends = [-2.0, -0.35, 0.1, 2.0];
        let mut sum = 0.0;
        for n in 0..27_usize {
            let piece =
                [0, 1].map(|end| Vec3::new(ends[n % 3 + end], ends[n / 3 % 3 + end], ends[n / 9 + end]));
            sum += enclosed_m3(&ball, &piece);
        }
        assert!((sum / ball.volume() - 1.0).abs() < 1e-12, "{sum} of {}", ball.volume());
        let half = enclosed_m3(&ball, &[Vec3::new(0.0, -2.0, -2.0), Vec3::repeat(2.0)]);
        assert!((half / ball.volume() - 0.5).abs() < 1e-3, "{half}");
    }
}
