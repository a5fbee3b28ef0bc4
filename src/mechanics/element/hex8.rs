//! The eight-node hexahedron with 2×2×2 Gauss points.
//!
//! Corner signs (ξ, η, ζ) in the order of the mesh: (−−−) (+−−) (++−) (−+−) (−−+) (+−+) (+++) (−++). Point q has the
//! signs of its bits: ξ bit 0, η bit 1, ζ bit 2. Every point has the weight 1.
//!
//! Derivatives in local coordinates use the tensor product: ∂u/∂ξ at a point depends on (η, ζ) only, so a component has
//! 3 × 4 of them, not 3 × 8, each an interpolation of four edge differences. They are left unscaled, see
//! [`DERIVATIVE`]: that takes 108 operations an element where stored gradients take 1 152; so few that the reference
//! geometry is not stored either but made again from the corners.

use super::Element;
use crate::real::Real;
use crate::tensor::{Tensor, tensor};

/// Number of quadrature points.
pub const POINTS: usize = 8;

/// Local coordinates (ξ, η, ζ) of the corners, each −1 or 1.
pub const HEX8_CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Edges along each local axis `k`, as `[axis][b2][b1]` with b1, b2 the sides (0 low, 1 high) in the two other axes, in
/// the order ξ → (η, ζ), η → (ξ, ζ), ζ → (ξ, η): (low corner, high corner).
const EDGES_ALONG: [[[(usize, usize); 2]; 2]; 3] = [
    [[(0, 1), (3, 2)], [(4, 5), (7, 6)]],
    [[(0, 3), (1, 2)], [(4, 7), (5, 6)]],
    [[(0, 4), (1, 5)], [(3, 7), (2, 6)]],
];

/// The 12 edges of the hexahedron, as pairs of corners.
pub const HEX8_EDGES: [(usize, usize); 12] =
    [(0, 1), (3, 2), (4, 5), (7, 6), (0, 3), (1, 2), (4, 7), (5, 6), (0, 4), (1, 5), (3, 7), (2, 6)];

/// The 4 body diagonals.
pub const HEX8_DIAGONALS: [(usize, usize); 4] = [(0, 6), (1, 7), (2, 4), (3, 5)];

/// Edges and body diagonals.
const HEX8_LENGTHS: [(usize, usize); 16] = {
    let mut all = [(0, 0); 16];
    let mut i = 0;
    while i < 16 {
        all[i] = if i < 12 { HEX8_EDGES[i] } else { HEX8_DIAGONALS[i - 12] };
        i += 1;
    }
    all
};

/// The Gauss coordinate 1/√3.
pub const GAUSS: f64 = 0.577_350_269_189_625_8;
/// Linear shape functions at a Gauss point: of the near and of the far end.
const NEAR: f64 = 0.5 * (1.0 + GAUSS);
const FAR: f64 = 0.5 * (1.0 - GAUSS);

/// ∂u/∂ξ = `DERIVATIVE` × the derivatives of [`Element::local_gradients`], which take a whole difference in place of its half
/// along an edge, and the near end with the factor 1 in place of `NEAR` in two interpolations: an operation less each.
const DERIVATIVE: f64 = 0.5 * NEAR * NEAR;

/// ∂u_i/∂ξ_k over [`DERIVATIVE`] at all points: `[component i][axis k][q2][q1]`, q1, q2 the point's sides in the two other axes.
pub type LocalGradients<R> = [[[[R; 2]; 2]; 3]; 3];

/// Where point `q` finds its entry of axis `k`: (q2, q1).
#[inline(always)]
const fn entry(q: usize, k: usize) -> (usize, usize) {
    let bits = [q & 1, (q >> 1) & 1, (q >> 2) & 1];
    match k {
        0 => (bits[2], bits[1]),
        1 => (bits[2], bits[0]),
        _ => (bits[1], bits[0]),
    }
}

/// Interpolates two ends to the two Gauss points between them, over `NEAR`. It is its own transpose.
#[inline(always)]
fn to_points<R: Real>(low: R, high: R) -> (R, R) {
    let ratio = low.constant(FAR / NEAR);
    (high.mul_add(ratio, low), low.mul_add(ratio, high))
}

/// Operations of the element in local coordinates, for any number type.
#[derive(Clone, Copy, Debug)]
pub struct Hex8;

impl Hex8 {
    /// Local coordinates of point `q`.
    pub fn point(q: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| if (q >> k) & 1 == 1 { GAUSS } else { -GAUSS })
    }
}

impl Element<8, 8> for Hex8 {
    const DERIVATIVE: f64 = DERIVATIVE;
    const WEIGHT: f64 = 1.0;
    const SCALE: f64 = 5.765_680_169_303_579;
    const LENGTHS: &'static [(usize, usize)] = &HEX8_LENGTHS;
    const SINGLE_PRECISION: bool = true;
    const CORNERS: &'static [[usize; 3]] =
        &[[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]];
    type Local<R: Real> = LocalGradients<R>;

    #[inline(always)]
    fn local_gradients<R: Real>(u: &[[R; 8]; 3]) -> LocalGradients<R> {
        let mut out = [[[[u[0][0]; 2]; 2]; 3]; 3];
        for (out, u) in out.iter_mut().zip(u) {
            for (out, edges) in out.iter_mut().zip(&EDGES_ALONG) {
                let (d00, d01) = to_points(along(u, edges[0][0]), along(u, edges[0][1]));
                let (d10, d11) = to_points(along(u, edges[1][0]), along(u, edges[1][1]));
                (out[0][0], out[1][0]) = to_points(d00, d10);
                (out[0][1], out[1][1]) = to_points(d01, d11);
            }
        }
        out
    }

    fn shapes() -> &'static [[f64; 8]; POINTS] {
        &SHAPES
    }

    fn shape_gradients() -> &'static [[[f64; 3]; 8]; POINTS] {
        &LOCAL_SHAPE_GRADIENTS
    }

    #[inline(always)]
    fn local_gradient_at<R: Real>(g: &LocalGradients<R>, q: usize) -> Tensor<R> {
        tensor!(i, k => {
            let (q2, q1) = entry(q, k);
            g[i][k][q2][q1]
        })
    }

    #[inline(always)]
    fn no_stress<R: Real>(zero: R) -> LocalGradients<R> {
        [[[[zero; 2]; 2]; 3]; 3]
    }

    #[inline(always)]
    fn add_local_stress<R: Real>(sums: &mut LocalGradients<R>, q: usize, P: &Tensor<R>, cof: &Tensor<R>) {
        for (sum, p) in sums.iter_mut().zip(&P.0) {
            for k in 0..3 {
                let (q2, q1) = entry(q, k);
                let sum = &mut sum[k][q2][q1];
                *sum = p[2].mul_add(cof.0[2][k], p[1].mul_add(cof.0[1][k], p[0].mul_add(cof.0[0][k], *sum)));
            }
        }
    }

    #[inline(always)]
    fn nodal_forces<R: Real>(sums: &LocalGradients<R>) -> [[R; 8]; 3] {
        let mut forces = [[sums[0][0][0][0].zero(); 8]; 3];
        for (f, sums) in forces.iter_mut().zip(sums) {
            for (s, edges) in sums.iter().zip(&EDGES_ALONG) {
                let (d00, d10) = to_points(s[0][0], s[1][0]);
                let (d01, d11) = to_points(s[0][1], s[1][1]);
                let (e00, e01) = to_points(d00, d01);
                let (e10, e11) = to_points(d10, d11);
                add_along(f, edges[0][0], e00);
                add_along(f, edges[0][1], e01);
                add_along(f, edges[1][0], e10);
                add_along(f, edges[1][1], e11);
            }
        }
        forces
    }
}

/// The difference along an edge.
#[inline(always)]
fn along<R: Real>(u: &[R; 8], (a, b): (usize, usize)) -> R {
    u[b] - u[a]
}

/// The transpose of [`along`].
#[inline(always)]
fn add_along<R: Real>(f: &mut [R; 8], (a, b): (usize, usize), e: R) {
    f[a] -= e;
    f[b] += e;
}

/// Shape functions of the corners at each point.
const SHAPES: [[f64; 8]; POINTS] = shapes_at_points().0;
/// Their derivatives in local coordinates.
const LOCAL_SHAPE_GRADIENTS: [[[f64; 3]; 8]; POINTS] = shapes_at_points().1;

/// N_a and ∂N_a/∂ξ at each point.
const fn shapes_at_points() -> ([[f64; 8]; POINTS], [[[f64; 3]; 8]; POINTS]) {
    let (mut shapes, mut gradients) = ([[0.0; 8]; POINTS], [[[0.0; 3]; 8]; POINTS]);
    let mut i = 0;
    while i < 8 * POINTS {
        let (q, a) = (i / 8, i % 8);
        let c = HEX8_CORNERS[a];
        let mut factor = [0.0; 3];
        let mut k = 0;
        while k < 3 {
            let local = if (q >> k) & 1 == 1 { GAUSS } else { -GAUSS };
            factor[k] = 0.5 * (1.0 + c[k] * local);
            k += 1;
        }
        shapes[q][a] = factor[0] * factor[1] * factor[2];
        gradients[q][a] = [
            0.5 * c[0] * factor[1] * factor[2],
            0.5 * c[1] * factor[0] * factor[2],
            0.5 * c[2] * factor[0] * factor[1],
        ];
        i += 1;
    }
    (shapes, gradients)
}

/// Shape functions of the corners at local coordinates.
pub fn shape_at(local: [f64; 3]) -> [f64; 8] {
    HEX8_CORNERS.map(|c| (0..3).map(|i| 0.5 * (1.0 + c[i] * local[i])).product())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{ElementKind, ReferenceGeometry};
    use crate::tensor::{Mat3, Vec3};

    fn distorted() -> [Vec3; 8] {
        std::array::from_fn(|a| {
            let c = HEX8_CORNERS[a];
            Vec3::new(c[0] * 1.0 + 0.1 * c[1] * c[2], c[1] * 1.5 + 0.2 * c[0], c[2] * 0.7 + 0.1 * c[0] * c[1])
        })
    }

    #[test]
    fn gradients_of_a_linear_field_are_exact_on_a_distorted_element() {
        let corners = distorted();
        let A = Mat3::new(0.1, 0.2, -0.3, 0.4, 0.5, 0.6, -0.7, 0.8, 0.9);
        let u = std::array::from_fn(|i| std::array::from_fn(|a| (A * corners[a])[i]));
        let g = Hex8::local_gradients(&u);
        let X = std::array::from_fn(|i| std::array::from_fn(|a| corners[a][i]));
        let jacobians = Hex8::local_gradients(&X);
        for q in 0..POINTS {
            let inverse = Mat3::from(&Hex8::local_gradient_at(&jacobians, q)).try_inverse().unwrap();
            let H = Mat3::from(&Hex8::local_gradient_at(&g, q)) * inverse;
            assert!((H - A).norm() < 1e-14);
        }
    }

    #[test]
    fn nodal_forces_are_the_transpose_of_the_gradients() {
        // Σ f·u = Σ T : ∂u/∂ξ for arbitrary u and T.
        let u: [[f64; 8]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|a| ((3 * a + 7 * i) as f64).sin()));
        let g = Hex8::local_gradients(&u);
        let mut sums = [[[[0.0; 2]; 2]; 3]; 3];
        let mut power = 0.0;
        for q in 0..POINTS {
            let P = Tensor::from_fn(|i, k| ((q * 5 + i * 2 + k) as f64).cos());
            let cof = Tensor::from_fn(|i, k| ((q * 3 + i * 7 + k * 2) as f64).sin());
            power += P.dot(&cof).double_dot(&Hex8::local_gradient_at(&g, q));
            Hex8::add_local_stress(&mut sums, q, &P, &cof);
        }
        let f = Hex8::nodal_forces(&sums);
        let virtual_work: f64 = (0..3).map(|i| (0..8).map(|a| f[i][a] * u[i][a]).sum::<f64>()).sum();
        assert!((power - virtual_work).abs() < 1e-12);
    }

    #[test]
    fn a_cube_has_the_textbook_bound() {
        // A unit cube: corner volume 1/8, highest mode of the Laplacian 4/L².
        let corners = HEX8_CORNERS.map(|c| Vec3::new(c[0], c[1], c[2]) * 0.5);
        let geometry = ReferenceGeometry::new(ElementKind::Hex8, &corners);
        assert!((geometry.gradient_bound - 4.0).abs() < 1e-12);
        assert!((geometry.total_volume() - 1.0).abs() < 1e-14);
    }
}
