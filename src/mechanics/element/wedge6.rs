//! The six-node wedge with three points in the triangle times two along the line.
//!
//! Shape functions L_i(ξ, η) ½ (1 ± ζ) with L = (1 − ξ − η, ξ, η) and ζ within ±1. Point q = 3 s + t is at the barycentric coordinates
//! (⅔, ⅙, ⅙) of the triangle, ⅔ at corner t, and at ζ = ∓1/√3 for s = 0, 1. Every point has the weight ⅙.
//!
//! ∂u/∂ξ and ∂u/∂η depend on ζ alone, and ∂u/∂ζ on (ξ, η) alone: a component has 2 × 2 + 3 derivatives, not 3 × 6.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::Element;
use super::hex8::GAUSS;
use crate::real::Real;
use crate::tensor::{Tensor, tensor};

/// Points of the triangle, and sides of the line.
const TRIANGLE: usize = 3;

/// Barycentric coordinates of a point of the triangle: at its own corner, and at the others.
const OWN: f64 = 2.0 / 3.0;
const OTHER: f64 = 1.0 / 6.0;

/// Linear shape functions at a Gauss point: of the near and of the far end.
const NEAR: f64 = 0.5 * (1.0 + GAUSS);
const FAR: f64 = 0.5 * (1.0 - GAUSS);

/// Nodes 0–2 are counter-clockwise on the bottom seen from the top, 3–5 above them.
#[derive(Clone, Copy, Debug)]
pub struct Wedge6;

/// Local gradients of a nodal field, or local stresses.
#[derive(Clone, Copy, Debug)]
pub struct WedgeGradients<R> {
    /// ∂u_i/∂ξ and ∂u_i/∂η: `[component i][axis][side]`.
    in_plane: [[[R; 2]; 2]; 3],
    /// ∂u_i/∂ζ: `[component i][point of the triangle]`.
    along: [[R; TRIANGLE]; 3],
}

impl Element<6, 6> for Wedge6 {
    const DERIVATIVE: f64 = 1.0;
    const WEIGHT: f64 = 1.0 / 6.0;
    /// (ω d³)^(−½) = √6, exact to rounding.
    const SCALE: f64 = 2.449_489_742_783_178;
    /// Edges, and the diagonals of the sides.
    const LENGTHS: &'static [(usize, usize)] = &[
        (0, 1),
        (1, 2),
        (2, 0),
        (3, 4),
        (4, 5),
        (5, 3),
        (0, 3),
        (1, 4),
        (2, 5),
        (0, 4),
        (1, 3),
        (1, 5),
        (2, 4),
        (2, 3),
        (0, 5),
    ];
    const CORNERS: &'static [[usize; 3]] =
        &[[1, 2, 3], [2, 0, 4], [0, 1, 5], [5, 4, 0], [3, 5, 1], [4, 3, 2]];
    const CORNER_DETERMINANT: f64 = 2.0;
    const KERNELS_OF_LAWS: bool = false;
    type Local<R: Real> = WedgeGradients<R>;

    #[inline(always)]
    fn local_gradients<R: Real>(u: &[[R; 6]; 3]) -> WedgeGradients<R> {
        let zero = u[0][0].zero();
        let mut out = WedgeGradients { in_plane: [[[zero; 2]; 2]; 3], along: [[zero; TRIANGLE]; 3] };
        for (i, u) in u.iter().enumerate() {
            for axis in 0..2 {
                out.in_plane[i][axis] = to_sides(u[axis + 1] - u[0], u[axis + 4] - u[3]);
            }
            out.along[i] = to_triangle([(u[3] - u[0]) * 0.5, (u[4] - u[1]) * 0.5, (u[5] - u[2]) * 0.5]);
        }
        out
    }

    #[inline(always)]
    fn local_gradient_at<R: Real>(g: &WedgeGradients<R>, q: usize) -> Tensor<R> {
        let (side, point) = (q / TRIANGLE, q % TRIANGLE);
        tensor!(i, k => if k < 2 { g.in_plane[i][k][side] } else { g.along[i][point] })
    }

    #[inline(always)]
    fn no_stress<R: Real>(zero: R) -> WedgeGradients<R> {
        WedgeGradients { in_plane: [[[zero; 2]; 2]; 3], along: [[zero; TRIANGLE]; 3] }
    }

    #[inline(always)]
    fn add_local_stress<R: Real>(sums: &mut WedgeGradients<R>, q: usize, P: &Tensor<R>, cof: &Tensor<R>) {
        let (side, point) = (q / TRIANGLE, q % TRIANGLE);
        let local = P.dot(cof);
        for i in 0..3 {
            sums.in_plane[i][0][side] += local.0[i][0];
            sums.in_plane[i][1][side] += local.0[i][1];
            sums.along[i][point] += local.0[i][2];
        }
    }

    #[inline(always)]
    fn nodal_forces<R: Real>(sums: &WedgeGradients<R>) -> [[R; 6]; 3] {
        let mut forces = [[sums.along[0][0].zero(); 6]; 3];
        for (i, f) in forces.iter_mut().enumerate() {
            for axis in 0..2 {
                let [low, high] = sums.in_plane[i][axis];
                let [low, high] = to_sides(low, high);
                f[0] -= low;
                f[axis + 1] += low;
                f[3] -= high;
                f[axis + 4] += high;
            }
            for (corner, along) in to_triangle(sums.along[i]).into_iter().enumerate() {
                f[corner] -= along * 0.5;
                f[corner + 3] += along * 0.5;
            }
        }
        forces
    }

    fn shapes() -> &'static [[f64; 6]; 6] {
        &SHAPES
    }

    fn shape_gradients() -> &'static [[[f64; 3]; 6]; 6] {
        &SHAPE_GRADIENTS
    }
}

/// Interpolates two ends to the two points between them. It is its own transpose.
#[inline(always)]
fn to_sides<R: Real>(low: R, high: R) -> [R; 2] {
    [high.mul_add(low.constant(FAR), low * NEAR), low.mul_add(low.constant(FAR), high * NEAR)]
}

/// Interpolates three corners to the three points between them. It is its own transpose.
#[inline(always)]
fn to_triangle<R: Real>([a, b, c]: [R; TRIANGLE]) -> [R; TRIANGLE] {
    let shared = (a + b + c) * OTHER;
    let own = OWN - OTHER;
    [a * own + shared, b * own + shared, c * own + shared]
}

/// Shape functions at the points, and their derivatives in local coordinates.
const SHAPES: [[f64; 6]; 6] = at_points().0;
const SHAPE_GRADIENTS: [[[f64; 3]; 6]; 6] = at_points().1;

const fn at_points() -> ([[f64; 6]; 6], [[[f64; 3]; 6]; 6]) {
    const IN_PLANE: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let (mut shapes, mut gradients) = ([[0.0; 6]; 6], [[[0.0; 3]; 6]; 6]);
    let mut i = 0;
    while i < 36 {
        let (q, a) = (i / 6, i % 6);
        let (corner, is_top) = (a % TRIANGLE, a / TRIANGLE == 1);
        let l = if corner == q % TRIANGLE { OWN } else { OTHER };
        let height = if is_top == (q / TRIANGLE == 1) { NEAR } else { FAR };
        shapes[q][a] = l * height;
        let up = if is_top { 0.5 } else { -0.5 };
        gradients[q][a] = [IN_PLANE[corner][0] * height, IN_PLANE[corner][1] * height, up * l];
        i += 1;
    }
    (shapes, gradients)
}
