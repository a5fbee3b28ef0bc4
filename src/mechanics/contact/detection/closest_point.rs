//! The point of a face that is closest to a given point: bilinear quadrilaterals and triangles.

use crate::tensor::Vec3;

/// Iterations of the bound-constrained Newton method; flat faces take two, warped ones four or five.
const MAX_ITERATIONS: usize = 40;
/// A step in the parametric coordinates of the face (0…1) below this is convergence.
const CONVERGED: f64 = 1e-14;

/// Location of a point on a face. Edge k runs from corner k to the next corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Between all edges of the face.
    Interior,
    /// On edge k, between its ends.
    Edge(usize),
    /// At corner k, the end of two edges.
    Corner(usize),
}

/// A point of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePoint {
    /// Position in space [m].
    pub point: Vec3,
    /// Shape functions at the point; the last is zero on a triangle.
    pub weights: [f64; 4],
    /// Inside, on an edge or on a corner.
    pub feature: Feature,
}

/// A face in space, corners counter-clockwise seen from outside: the bilinear patch of four, or a triangle if the
/// last two are the same node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Positions of the corners [m]; on a triangle the last two coincide.
    pub corners: [Vec3; 4],
    /// The last corner repeats the third.
    pub triangle: bool,
}

impl Patch {
    /// The face at nodal positions `x` [m].
    #[inline]
    pub fn new(face: &[u32; 4], x: &[Vec3]) -> Self {
        Self { corners: face.map(|node| x[node as usize]), triangle: face[2] == face[3] }
    }

    /// The face at the fraction `tau` of the motion from `x` to `x_end` [m].
    pub fn between(face: &[u32; 4], x: &[Vec3], x_end: &[Vec3], tau: f64) -> Self {
        let at = |node: u32| x[node as usize] + (x_end[node as usize] - x[node as usize]) * tau;
        Self { corners: face.map(at), triangle: face[2] == face[3] }
    }

    /// Number of corners (and of edges).
    pub fn corner_count(&self) -> usize {
        if self.triangle { 3 } else { 4 }
    }

    /// Shape functions at the coordinates `a`, `b` in 0…1, from corner 0 towards corners 1 and 3; on a triangle the
    /// side opposite to edge 0–1 degenerates to corner 2.
    pub fn weights(&self, a: f64, b: f64) -> [f64; 4] {
        let w = [(1.0 - a) * (1.0 - b), a * (1.0 - b), a * b, (1.0 - a) * b];
        if self.triangle { [w[0], w[1], w[2] + w[3], 0.0] } else { w }
    }

    /// The point with the given shape functions.
    pub fn point(&self, weights: &[f64; 4]) -> Vec3 {
        let c = &self.corners;
        c[0] * weights[0] + c[1] * weights[1] + c[2] * weights[2] + c[3] * weights[3]
    }

    /// Tangents along `a` and `b` at the point with the given shape functions, not normalised.
    pub fn tangents(&self, weights: &[f64; 4]) -> (Vec3, Vec3) {
        let c = &self.corners;
        if self.triangle {
            return (c[1] - c[0], c[2] - c[0]);
        }
        // b = w2 + w3 and a = w1 + w2 for a bilinear patch.
        let (a, b) = (weights[1] + weights[2], weights[2] + weights[3]);
        let along_a = (c[1] - c[0]) * (1.0 - b) + (c[2] - c[3]) * b;
        let along_b = (c[3] - c[0]) * (1.0 - a) + (c[2] - c[1]) * a;
        (along_a, along_b)
    }

    /// Outward unit normal at the point with the given shape functions; that of the diagonals where the patch is
    /// degenerate, zero if it has no area.
    pub fn normal(&self, weights: &[f64; 4]) -> Vec3 {
        let (a, b) = self.tangents(weights);
        let n = a.cross(&b);
        let length = n.norm();
        if length > 1e-12 * (a.norm_squared() + b.norm_squared()) {
            return n / length;
        }
        let c = &self.corners;
        let n = (c[2] - c[0]).cross(&(c[3] - c[1]));
        n.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
    }

    /// Area [m²], exact for flat faces, second-order accurate in the warp.
    pub fn area(&self) -> f64 {
        let c = &self.corners;
        if self.triangle {
            return 0.5 * (c[1] - c[0]).cross(&(c[2] - c[0])).norm();
        }
        0.5 * (c[2] - c[0]).cross(&(c[3] - c[1])).norm()
    }

    /// The two edge vectors at corner k: to the next corner, and to the previous one.
    pub fn edges_at(&self, k: usize) -> (Vec3, Vec3) {
        let n = self.corner_count();
        (self.corners[(k + 1) % n] - self.corners[k], self.corners[(k + n - 1) % n] - self.corners[k])
    }

    /// Shape functions where the line through `p` along `n` meets the face or its continuation, with the edge that
    /// this point is farthest beyond and by how much, in parametric coordinates (negative inside). `None` where the
    /// line does not meet it.
    pub fn along(&self, p: &Vec3, n: &Vec3) -> Option<([f64; 4], (usize, f64))> {
        let c = self.corners.map(|corner| corner - p);
        // Cramer's rule in the plane normal to n.
        let solve = |u: &Vec3, v: &Vec3, r: &Vec3| {
            let det = n.dot(&u.cross(v));
            (det != 0.0).then(|| (n.dot(&r.cross(v)) / det, n.dot(&u.cross(r)) / det))
        };
        let farthest = |beyond: [(usize, f64); 4]| {
            beyond
                .into_iter()
                .fold((0, f64::NEG_INFINITY), |far, edge| if edge.1 > far.1 { edge } else { far })
        };
        if self.triangle {
            let (w1, w2) = solve(&(c[1] - c[0]), &(c[2] - c[0]), &-c[0])?;
            let w0 = 1.0 - w1 - w2;
            return Some(([w0, w1, w2, 0.0], farthest([(0, -w2), (1, -w0), (2, -w1), (2, -w1)])));
        }
        // Newton's method on the bilinear patch, projected along n.
        let (mut a, mut b) = (0.5, 0.5);
        for _ in 0..MAX_ITERATIONS {
            let w = self.weights(a, b);
            let point = c[0] * w[0] + c[1] * w[1] + c[2] * w[2] + c[3] * w[3];
            let (along_a, along_b) = self.tangents(&w);
            let (d_a, d_b) = solve(&along_a, &along_b, &-point)?;
            (a, b) = (a + d_a, b + d_b);
            if d_a.abs() + d_b.abs() <= 1e-12 {
                let beyond = farthest([(0, -b), (1, a - 1.0), (2, b - 1.0), (3, -a)]);
                return Some((self.weights(a, b), beyond));
            }
        }
        None
    }

    /// Point of the face closest to `s`.
    pub fn closest(&self, s: &Vec3) -> FacePoint {
        if self.triangle { self.closest_on_triangle(s) } else { self.closest_on_quad(s) }
    }

    /// Newton's method for min ‖x(a,b) − s‖² on the unit square, with the bounds as an active set and backtracking.
    fn closest_on_quad(&self, s: &Vec3) -> FacePoint {
        let c = &self.corners;
        let (e_a, e_b, e_ab) = (c[1] - c[0], c[3] - c[0], c[0] - c[1] + c[2] - c[3]);
        let from = c[0] - s;
        let offset = |a: f64, b: f64| from + e_a * a + e_b * b + e_ab * (a * b);
        let (mut a, mut b) = (0.5, 0.5);
        let mut o = offset(a, b);
        for _ in 0..MAX_ITERATIONS {
            // Gradient, and the bounds that hold.
            let (x_a, x_b) = (e_a + e_ab * b, e_b + e_ab * a);
            let (g_a, g_b) = (o.dot(&x_a), o.dot(&x_b));
            let held_a = (a <= 0.0 && g_a > 0.0) || (a >= 1.0 && g_a < 0.0);
            let held_b = (b <= 0.0 && g_b > 0.0) || (b >= 1.0 && g_b < 0.0);
            let (h_aa, h_bb) = (x_a.norm_squared(), x_b.norm_squared());
            let (d_a, d_b) = match (held_a, held_b) {
                (true, true) => break,
                (true, false) => (0.0, -g_b / h_bb),
                (false, true) => (-g_a / h_aa, 0.0),
                (false, false) => newton_step(h_aa, h_bb, x_a.dot(&x_b), o.dot(&e_ab), g_a, g_b),
            };
            if !(d_a.is_finite() && d_b.is_finite()) {
                return self.closest_on_border(s);
            }
            // Backtracking on the squared distance.
            let (mut fraction, before) = (1.0, o.norm_squared());
            let (old_a, old_b) = (a, b);
            loop {
                a = (old_a + fraction * d_a).clamp(0.0, 1.0);
                b = (old_b + fraction * d_b).clamp(0.0, 1.0);
                o = offset(a, b);
                // Rounding may raise the value of the last step: accept an equal one.
                if o.norm_squared() <= before * (1.0 + 1e-12) || fraction < 1e-3 {
                    break;
                }
                fraction *= 0.5;
            }
            if (a - old_a).abs() + (b - old_b).abs() <= CONVERGED {
                return self.quad_point(a, b);
            }
        }
        // Both bounds are active, or no convergence (far off a strongly warped face): the border may be closer.
        let found = self.quad_point(a, b);
        let border = self.closest_on_border(s);
        if (border.point - s).norm_squared() < (found.point - s).norm_squared() { border } else { found }
    }

    fn quad_point(&self, a: f64, b: f64) -> FacePoint {
        let (low_a, high_a, low_b, high_b) = (a <= 0.0, a >= 1.0, b <= 0.0, b >= 1.0);
        let feature = match (low_a, high_a, low_b, high_b) {
            (true, _, true, _) => Feature::Corner(0),
            (_, true, true, _) => Feature::Corner(1),
            (_, true, _, true) => Feature::Corner(2),
            (true, _, _, true) => Feature::Corner(3),
            (_, _, true, _) => Feature::Edge(0),
            (_, true, _, _) => Feature::Edge(1),
            (_, _, _, true) => Feature::Edge(2),
            (true, _, _, _) => Feature::Edge(3),
            _ => Feature::Interior,
        };
        let weights = self.weights(a, b);
        FacePoint { point: self.point(&weights), weights, feature }
    }

    /// Closest point on the edges; the first of equally close ones.
    fn closest_on_border(&self, s: &Vec3) -> FacePoint {
        let n = self.corner_count();
        let mut best = self.edge_point(0, s);
        for k in 1..n {
            let other = self.edge_point(k, s);
            if (other.point - s).norm_squared() < (best.point - s).norm_squared() {
                best = other;
            }
        }
        best
    }

    fn edge_point(&self, k: usize, s: &Vec3) -> FacePoint {
        let next = (k + 1) % self.corner_count();
        let (from, along) = (self.corners[k], self.corners[next] - self.corners[k]);
        let length = along.norm_squared();
        let fraction = if length > 0.0 { ((s - from).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
        let mut weights = [0.0; 4];
        weights[k] = 1.0 - fraction;
        weights[next] = fraction;
        let feature = match fraction {
            0.0 => Feature::Corner(k),
            1.0 => Feature::Corner(next),
            _ => Feature::Edge(k),
        };
        FacePoint { point: from + along * fraction, weights, feature }
    }

    fn closest_on_triangle(&self, s: &Vec3) -> FacePoint {
        let c = &self.corners;
        let (e1, e2, o) = (c[1] - c[0], c[2] - c[0], s - c[0]);
        let (d11, d12, d22) = (e1.norm_squared(), e1.dot(&e2), e2.norm_squared());
        let (o1, o2) = (o.dot(&e1), o.dot(&e2));
        let det = d11 * d22 - d12 * d12;
        let (w1, w2) = ((d22 * o1 - d12 * o2) / det, (d11 * o2 - d12 * o1) / det);
        // Also false for a triangle without area.
        if w1 > 0.0 && w2 > 0.0 && w1 + w2 < 1.0 {
            let weights = [1.0 - w1 - w2, w1, w2, 0.0];
            return FacePoint { point: self.point(&weights), weights, feature: Feature::Interior };
        }
        self.closest_on_border(s)
    }
}

/// Newton's step for the distance, or Gauss–Newton's where the Hessian is not positive definite.
fn newton_step(h_aa: f64, h_bb: f64, cross: f64, curvature: f64, g_a: f64, g_b: f64) -> (f64, f64) {
    let mut h_ab = cross + curvature;
    let mut det = h_aa * h_bb - h_ab * h_ab;
    if det <= 1e-6 * h_aa * h_bb {
        h_ab = cross;
        det = h_aa * h_bb - h_ab * h_ab;
    }
    ((h_ab * g_b - h_bb * g_a) / det, (h_ab * g_a - h_aa * g_b) / det)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact equality is intended
mod tests {
    use super::*;

    fn warped() -> Patch {
        Patch {
            corners: [
                Vec3::new(0.0, 0.0, 0.0),
                Vec3::new(1.0, 0.1, 0.3),
                Vec3::new(1.2, 1.1, -0.1),
                Vec3::new(-0.1, 0.9, 0.2),
            ],
            triangle: false,
        }
    }

    /// Distance to the closest point of a fine grid.
    fn sampled(patch: &Patch, s: &Vec3) -> f64 {
        let mut best = f64::INFINITY;
        for i in 0..=200 {
            for j in 0..=200 {
                let w = patch.weights(f64::from(i) / 200.0, f64::from(j) / 200.0);
                best = best.min((patch.point(&w) - s).norm());
            }
        }
        best
    }

    #[test]
    fn flat_faces_are_exact() {
        // A planar quadrilateral that is no parallelogram, tilted.
        let tilt = nalgebra::Rotation3::from_euler_angles(0.3, -0.2, 0.5);
        let corners =
            [[0.0, 0.0], [2.0, 0.1], [1.7, 1.0], [0.2, 0.8]].map(|[x, y]| tilt * Vec3::new(x, y, 0.0));
        let patch = Patch { corners, triangle: false };
        let inside = tilt * Vec3::new(0.9, 0.5, 0.37);
        let found = patch.closest(&inside);
        assert_eq!(found.feature, Feature::Interior);
        assert!((found.point - tilt * Vec3::new(0.9, 0.5, 0.0)).norm() < 1e-15);
        assert!((patch.normal(&found.weights) - tilt * Vec3::z()).norm() < 1e-15);
        let beyond = patch.closest(&(tilt * Vec3::new(-1.0, -1.0, 0.2)));
        assert_eq!(beyond.feature, Feature::Corner(0));
        assert_eq!(beyond.point, corners[0]);
    }

    #[test]
    fn warped_faces_and_triangles_agree_with_sampling_from_all_sides() {
        let quad = warped();
        let mut corners = quad.corners;
        corners[3] = corners[2];
        let triangle = Patch { corners, triangle: true };
        for patch in [quad, triangle] {
            for k in 0..60 {
                let t = f64::from(k);
                let s = Vec3::new(
                    0.5 + 1.3 * (1.7 * t).sin(),
                    0.5 + 1.2 * (2.9 * t).cos(),
                    0.8 * (0.7 * t).sin(),
                );
                let found = patch.closest(&s);
                let (got, grid) = ((found.point - s).norm(), sampled(&patch, &s));
                assert!(got <= grid + 1e-12 && got >= grid - 0.02, "{s}: {got} against {grid}");
                assert!((patch.point(&found.weights) - found.point).norm() < 1e-14);
                assert!((found.weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                if found.feature == Feature::Interior {
                    let n = patch.normal(&found.weights);
                    assert!((s - found.point).cross(&n).norm() <= 1e-12, "the offset is along the normal");
                }
            }
        }
    }

    #[test]
    fn degenerate_faces_stay_finite() {
        let p = Vec3::new(1.0, 2.0, 3.0);
        for triangle in [false, true] {
            let patch = Patch { corners: [p; 4], triangle };
            let found = patch.closest(&Vec3::zeros());
            assert!((found.point - p).norm() < 1e-15);
            assert_eq!(patch.normal(&found.weights), Vec3::zeros());
        }
    }
}
