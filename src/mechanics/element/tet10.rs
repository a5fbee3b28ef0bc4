//! The ten-node tetrahedron with four points.
//!
//! With the barycentric coordinates L_i, the shape functions are L_i (2 L_i − 1) at the corners and 4 L_i L_j between two. With m_ii the
//! value of a field u at corner i and m_ij that between i and j,
//!
//! ```text
//! ∂u/∂L_i = 4 Σ_j m_ij L_j − m_ii      ∂u/∂ξ_k = ∂u/∂L_(k+1) − ∂u/∂L_0
//! ```
//!
//! Point q has the coordinate L_q = (5 + 3 √5)/20 and (5 − √5)/20 in the others, weight 1/24: exact to second degree (Hammer & Stroud
//! 1956), so a uniform stress is integrated exactly where edges are straight and their nodes in the middle.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::Element;
use crate::real::Real;
use crate::tensor::{Tensor, tensor};

/// Barycentric coordinates of a point: at its own corner, and at the others.
const OWN: f64 = 0.585_410_196_624_968_5;
const OTHER: f64 = 0.138_196_601_125_010_5;

/// Fractions of the volume by which mass is lumped, at a corner and between two: in proportion to the diagonal of the consistent mass, V/70
/// and 8 V/105 (Hinton, Rock & Zienkiewicz 1976). Row sums would be negative at the corners.
const CORNER_FRACTION: f64 = 1.0 / 36.0;
const MIDDLE_FRACTION: f64 = 4.0 / 27.0;

/// The node of m_ij.
const NODE: [[usize; 4]; 4] = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];

/// Corners as in [`Tet4`](super::Tet4), then the nodes between 0–1, 1–2, 2–0, 0–3, 1–3 and 2–3.
#[derive(Clone, Copy, Debug)]
pub struct Tet10;

impl Element<10, 4> for Tet10 {
    const DERIVATIVE: f64 = 1.0;
    const WEIGHT: f64 = 1.0 / 24.0;
    /// (ω d³)^(−½) = √24, exact to rounding.
    const SCALE: f64 = 4.898_979_485_566_356;
    /// The edges of the four tetrahedra at the corners.
    const LENGTHS: &'static [(usize, usize)] = &[
        (0, 4),
        (0, 6),
        (0, 7),
        (4, 6),
        (6, 7),
        (7, 4),
        (1, 4),
        (1, 5),
        (1, 8),
        (4, 5),
        (5, 8),
        (8, 4),
        (2, 5),
        (2, 6),
        (2, 9),
        (5, 6),
        (6, 9),
        (9, 5),
        (3, 7),
        (3, 8),
        (3, 9),
        (7, 8),
        (8, 9),
        (9, 7),
    ];
    const KERNELS_OF_LAWS: bool = false;
    type Local<R: Real> = [Tensor<R>; 4];

    #[inline(always)]
    fn local_gradients<R: Real>(u: &[[R; 10]; 3]) -> [Tensor<R>; 4] {
        let mut out = [Tensor::diagonal(u[0][0].zero()); 4];
        for (i, u) in u.iter().enumerate() {
            // What the points share of ∂u/∂L_l.
            let mut shared = [u[0].zero(); 4];
            for l in 0..4 {
                let sum = u[NODE[l][0]] + u[NODE[l][1]] + u[NODE[l][2]] + u[NODE[l][3]];
                shared[l] = sum * (4.0 * OTHER) - u[l];
            }
            for (q, out) in out.iter_mut().enumerate() {
                let first = (u[NODE[0][q]] * (4.0 * (OWN - OTHER))) + shared[0];
                for k in 0..3 {
                    out.0[i][k] = u[NODE[k + 1][q]] * (4.0 * (OWN - OTHER)) + shared[k + 1] - first;
                }
            }
        }
        out
    }

    #[inline(always)]
    fn local_gradient_at<R: Real>(g: &[Tensor<R>; 4], q: usize) -> Tensor<R> {
        g[q]
    }

    #[inline(always)]
    fn no_stress<R: Real>(zero: R) -> [Tensor<R>; 4] {
        [tensor!(_i, _k => zero); 4]
    }

    #[inline(always)]
    fn add_local_stress<R: Real>(sums: &mut [Tensor<R>; 4], q: usize, P: &Tensor<R>, cof: &Tensor<R>) {
        sums[q] = sums[q].plus(&P.dot(cof));
    }

    #[inline(always)]
    fn nodal_forces<R: Real>(sums: &[Tensor<R>; 4]) -> [[R; 10]; 3] {
        let zero = sums[0].0[0][0].zero();
        let mut forces = [[zero; 10]; 3];
        for (i, f) in forces.iter_mut().enumerate() {
            // Conjugate to ∂u/∂L_l at the points, and their sums.
            let mut t = [[zero; 4]; 4];
            let mut all = [zero; 4];
            for (q, sum) in sums.iter().enumerate() {
                let row = &sum.0[i];
                t[0][q] = -(row[0] + row[1] + row[2]);
                for k in 0..3 {
                    t[k + 1][q] = row[k];
                }
                for l in 0..4 {
                    all[l] += t[l][q];
                }
            }
            for l in 0..4 {
                f[l] -= all[l];
                for q in 0..4 {
                    f[NODE[l][q]] += all[l] * (4.0 * OTHER) + t[l][q] * (4.0 * (OWN - OTHER));
                }
            }
        }
        forces
    }

    fn shapes() -> &'static [[f64; 10]; 4] {
        &SHAPES
    }

    fn shape_gradients() -> &'static [[[f64; 3]; 10]; 4] {
        &SHAPE_GRADIENTS
    }

    fn lumped_volumes(volume: &[f64; 4]) -> [f64; 10] {
        let volume: f64 = volume.iter().sum();
        std::array::from_fn(|a| volume * if a < 4 { CORNER_FRACTION } else { MIDDLE_FRACTION })
    }
}

/// Shape functions at the points, and their derivatives in local coordinates.
const SHAPES: [[f64; 10]; 4] = at_points().0;
const SHAPE_GRADIENTS: [[[f64; 3]; 10]; 4] = at_points().1;

const fn at_points() -> ([[f64; 10]; 4], [[[f64; 3]; 10]; 4]) {
    const OF_L: [[f64; 3]; 4] = [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (mut shapes, mut gradients) = ([[0.0; 10]; 4], [[[0.0; 3]; 10]; 4]);
    let mut i = 0;
    while i < 64 {
        // A point and a pair of corners; each pair between two corners comes twice, with the same result.
        let (q, a, b) = (i / 16, i / 4 % 4, i % 4);
        let (la, lb) = (if a == q { OWN } else { OTHER }, if b == q { OWN } else { OTHER });
        let node = NODE[a][b];
        shapes[q][node] = if a == b { la * (2.0 * la - 1.0) } else { 4.0 * la * lb };
        let mut k = 0;
        while k < 3 {
            gradients[q][node][k] = if a == b {
                (4.0 * la - 1.0) * OF_L[a][k]
            } else {
                4.0 * (la * OF_L[b][k] + lb * OF_L[a][k])
            };
            k += 1;
        }
        i += 1;
    }
    (shapes, gradients)
}
