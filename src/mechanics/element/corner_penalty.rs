//! A penalty on the corners of hexahedra and wedges that are crushed or folded.
//!
//! Quadrature does not look at the corners: hourglass modes that add up at one of them can fold it, its Jacobian negative, while
//! the points nearby and the mean are fine. So a corner whose Jacobian det = e₁·(e₂×e₃), the triple product of its three edges,
//! falls below the fraction θ₀ of that at rest is given energy:
//!
//! ```text
//! W = Σ_c V/n (½ κ μ s² + ¼ M s⁶) = Σ_c ½ a s² (1 + ⅓ η s⁴)      s = ⟨t_c − det_c⟩ b      t_c = θ₀ det_c at rest
//! a = κ μ V / n      b = 1 / (θ₀ δ V)      η = 3 M / (2 κ μ)      M = K + 4/3 μ
//! ```
//!
//! with n corners, each of the determinant δ V where opposite sides are parallel, so that `s = ⟨1 − J_c/θ₀⟩`, a number that single
//! precision holds however small the element: soft where a corner is crushed; and where it folds,
//! s ≥ 1, what no impact has that is slower than sound, `½ ρ v² < ½ M`. Relative to the volume V rather than to the corner's own
//! determinant, it is no stiffer at a corner that is flat at rest; a corner that is folded at rest is not to fold further. Forces
//! are the gradient of W, and momentum and angular momentum are kept, because det turns with nothing.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::Element;
use super::hex8_modes::V3;
use crate::real::Real;

/// Fraction of the Jacobian at rest below which a corner is penalised, θ₀ [-].
pub const CORNER_THRESHOLD: f64 = 0.3;

/// Stiffness of the penalty, κ [-]. With it the least J at a corner of gel under a ball stays above 0, and the least at a point is
/// several times larger than without.
const STIFFNESS: f64 = 20.0;

/// W and its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct CornerResponse<R, const N: usize> {
    /// Energy W of the penalty [J].
    pub energy: R,
    /// Corner forces ∂W/∂u [N]: `[component][corner]`.
    pub forces: [[R; N]; 3],
    /// Bound of the norm of the Hessian of W [N/m].
    pub stiffness: R,
}

/// a [J], b [1/m³] and η [-] of an element of volume `volume` [m³], shear modulus μ [Pa] and bulk modulus K [Pa] at rest; zero for one
/// whose corners are not penalised.
pub fn corner_stiffness<E: Element<N, Q>, const N: usize, const Q: usize>(
    (mu, bulk): (f64, f64),
    volume: f64,
) -> [f64; 3] {
    if E::CORNERS.is_empty() {
        return [0.0; 3];
    }
    let lack = CORNER_THRESHOLD * E::CORNER_DETERMINANT * volume;
    let soft = STIFFNESS * mu;
    [soft * volume / E::CORNERS.len() as f64, 1.0 / lack, 1.5 * (bulk + 4.0 / 3.0 * mu) / soft]
}

/// The penalty with a [J], b [1/m³] and hardening η [-] on an element with [`Element::CORNERS`], `X` [m] at rest and their
/// displacements `u` [m]: `[component][corner]`.
///
/// With A_i = ∂det/∂x_i the products of two edges, the Hessian of a corner's term W(l) is `W'' ∇det ∇detᵀ − W' ∇²det`, of norm at most
/// `W'' [Σ|A_i|² + |Σ A_i|²] + 4 W' Σ|e_i|`.
#[inline(always)]
pub fn eval_corner_penalty<R: Real, const N: usize>(
    corners: &[[usize; 3]],
    X: &[[R; N]; 3],
    u: &[[R; N]; 3],
    [scale, per_lack, hardening]: [R; 3],
) -> CornerResponse<R, N> {
    let zero = scale.zero();
    let scale_per_lack = scale * per_lack;
    let mut out = CornerResponse { energy: zero, forces: [[zero; N]; 3], stiffness: zero };
    for (c, neighbours) in corners.iter().copied().enumerate() {
        let (mut at_rest, mut e) = ([[zero; 3]; 3], [[zero; 3]; 3]);
        for (n, a) in neighbours.into_iter().enumerate() {
            for i in 0..3 {
                at_rest[n][i] = X[i][a] - X[i][c];
                e[n][i] = at_rest[n][i] + (u[i][a] - u[i][c]);
            }
        }
        let det_at_rest = dot(&at_rest[0], &cross(&at_rest[1], &at_rest[2]));
        let A = [cross(&e[1], &e[2]), cross(&e[2], &e[0]), cross(&e[0], &e[1])];
        let threshold = (det_at_rest * CORNER_THRESHOLD).min(det_at_rest);
        let lack = (threshold - dot(&e[0], &A[0])).max(zero) * per_lack;
        let hard = hardening * (lack * lack) * (lack * lack);
        let pull = scale_per_lack * lack * (hard + 1.0);
        out.energy = (scale * lack * 0.5 * hard.scale_add(1.0 / 3.0, 1.0)).mul_add(lack, out.energy);
        let mut square = zero;
        for i in 0..3 {
            let mut sum = zero;
            for (A, a) in A.iter().zip(neighbours) {
                out.forces[i][a] -= pull * A[i];
                sum += A[i];
                square = A[i].mul_add(A[i], square);
            }
            out.forces[i][c] += pull * sum;
            square = sum.mul_add(sum, square);
        }
        let lengths = norm(&e[0]) + norm(&e[1]) + norm(&e[2]);
        // In this order single precision holds every factor.
        let slope = lack.select_positive(hard.scale_add(5.0, 1.0) * scale_per_lack, zero);
        out.stiffness += (pull * 4.0).mul_add(lengths, slope * (square * per_lack));
    }
    out
}

#[inline(always)]
fn dot<R: Real>(a: &V3<R>, b: &V3<R>) -> R {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

#[inline(always)]
fn norm<R: Real>(a: &V3<R>) -> R {
    dot(a, a).sqrt()
}

#[inline(always)]
fn cross<R: Real>(a: &V3<R>, b: &V3<R>) -> V3<R> {
    [a[1].mul_sub(b[2], a[2] * b[1]), a[2].mul_sub(b[0], a[0] * b[2]), a[0].mul_sub(b[1], a[1] * b[0])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::Dual;
    use crate::element::{ElementKind, HEX8_CORNERS, Hex8, ReferenceGeometry};
    use nalgebra::SMatrix;

    type Nodal = [[f64; 8]; 3];

    /// Both terms count where a corner folds.
    const STIFF: [f64; 3] = [3.0, 1.0, 300.0];

    fn wave(i: usize) -> f64 {
        (i as f64 * 12.9898).sin() * 43758.5453 % 1.0
    }

    fn nodal(value: impl Fn(usize, usize) -> f64) -> Nodal {
        std::array::from_fn(|i| std::array::from_fn(|a| value(i, a)))
    }

    /// A brick of edges 1, 2, 0.5, its corners moved.
    fn distorted() -> Nodal {
        nodal(|i, a| [0.5, 1.0, 0.25][i] * HEX8_CORNERS[a][i] + 0.05 * wave(3 * a + i))
    }

    /// Crushed along z, and its corners moved at random.
    fn crushed(X: &Nodal, fraction: f64, q: f64, seed: usize) -> Nodal {
        nodal(|i, a| if i == 2 { -fraction * X[2][a] } else { 0.0 } + q * wave(91 * seed + 3 * a + i + 7))
    }

    #[test]
    fn neighbours_are_joined_by_edges_and_right_handed() {
        let X = nodal(|i, a| 0.5 * HEX8_CORNERS[a][i]);
        let response = eval_corner_penalty(Hex8::CORNERS, &X, &nodal(|i, a| -X[i][a]), [2.0, 1.0, 0.0]);
        // Shrunk to a point every corner lacks its threshold.
        assert!((response.energy - 8.0 * CORNER_THRESHOLD * CORNER_THRESHOLD).abs() < 1e-14);
        let at_rest = eval_corner_penalty(Hex8::CORNERS, &X, &[[0.0; 8]; 3], [2.0, 1.0, 1e3]);
        assert!(at_rest.energy == 0.0 && at_rest.stiffness == 0.0);
    }

    #[test]
    fn a_corner_that_folds_takes_what_the_stiffness_says() {
        // A brick pressed flat, s = 1: ½ κ μ + ¼ M a volume.
        let X = nodal(|i, a| [0.5, 1.0, 0.25][i] * HEX8_CORNERS[a][i]);
        let (mu, bulk) = (3.0, 200.0);
        let u = nodal(|i, a| if i == 2 { -X[2][a] } else { 0.0 });
        let energy =
            eval_corner_penalty(Hex8::CORNERS, &X, &u, corner_stiffness::<Hex8, 8, 8>((mu, bulk), 1.0))
                .energy;
        let expected = 0.5 * STIFFNESS * mu + 0.25 * (bulk + 4.0 / 3.0 * mu);
        assert!((energy / expected - 1.0).abs() < 1e-13, "{energy} for {expected}");
    }

    #[test]
    fn forces_are_the_gradient_and_keep_both_momenta() {
        let X = distorted();
        for seed in 0..20 {
            let u = crushed(&X, 0.8, 0.2, seed);
            let response = eval_corner_penalty(Hex8::CORNERS, &X, &u, STIFF);
            assert!(response.energy > 0.0, "nothing to see");
            let dual = |x: &Nodal| x.map(|row| row.map(|value| Dual { value, slope: 0.0 }));
            let k = STIFF.map(|value| Dual { value, slope: 0.0 });
            for (i, a) in (0..3).flat_map(|i| (0..8).map(move |a| (i, a))) {
                let mut moved = dual(&u);
                moved[i][a].slope = 1.0;
                let slope = eval_corner_penalty(Hex8::CORNERS, &dual(&X), &moved, k).energy.slope;
                assert!((slope - response.forces[i][a]).abs() < 1e-12 * response.stiffness);
            }
            let x = nodal(|i, a| X[i][a] + u[i][a]);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let force: f64 = response.forces[i].iter().sum();
                let moment: f64 =
                    (0..8).map(|a| x[j][a] * response.forces[k][a] - x[k][a] * response.forces[j][a]).sum();
                assert!(force.abs() + moment.abs() < 1e-13 * response.stiffness);
            }
        }
    }

    #[test]
    fn the_bound_is_above_the_largest_eigenvalue_of_the_exact_hessian() {
        let X = distorted();
        let mut closest = 0.0_f64;
        for seed in 0..200 {
            let u = crushed(&X, 0.9, 0.05 + 0.005 * seed as f64, seed);
            let dual = |x: &Nodal| x.map(|row| row.map(|value| Dual { value, slope: 0.0 }));
            let k = STIFF.map(|value| Dual { value, slope: 0.0 });
            let mut hessian = SMatrix::<f64, 24, 24>::zeros();
            for column in 0..24 {
                let mut moved = dual(&u);
                moved[column / 8][column % 8].slope = 1.0;
                let forces = eval_corner_penalty(Hex8::CORNERS, &dual(&X), &moved, k).forces;
                for row in 0..24 {
                    hessian[(row, column)] = forces[row / 8][row % 8].slope;
                }
            }
            assert!((hessian - hessian.transpose()).norm() < 1e-12 * hessian.norm());
            let largest = hessian.symmetric_eigenvalues().abs().max();
            let bound = eval_corner_penalty(Hex8::CORNERS, &X, &u, STIFF).stiffness;
            assert!(largest <= bound * (1.0 + 1e-12), "{seed}: {largest} above {bound}");
            closest = closest.max(largest / bound);
        }
        // A bound that is far off would cost steps.
        assert!(closest > 0.3, "{closest}");
    }

    #[test]
    fn a_corner_that_is_folded_at_rest_is_left_alone_there() {
        let mut X = nodal(|i, a| 0.5 * HEX8_CORNERS[a][i]);
        // Beyond the diagonal of its face.
        (X[0][6], X[1][6], X[2][6]) = (-0.2, -0.2, 0.5);
        let response = eval_corner_penalty(Hex8::CORNERS, &X, &[[0.0; 8]; 3], [1.0, 1.0, 1e3]);
        assert!(response.energy == 0.0);
    }

    #[test]
    fn no_corner_is_penalised_where_every_point_is_well() {
        // What the evaluation relies on: with J at all points above its gate, no corner of an incompressible element is below θ₀.
        let corners = HEX8_CORNERS.map(|c| crate::tensor::Vec3::from(c) * 0.5);
        let mut least = f64::INFINITY;
        for seed in 0..20_000 {
            let q = 0.1 + 0.4 * wave(seed).abs();
            let moved: [_; 8] = std::array::from_fn(|a| {
                corners[a] + crate::tensor::Vec3::from_fn(|i, _| q * wave(77 * seed + 3 * a + i))
            });
            let volume = ReferenceGeometry::new(ElementKind::Hex8, &moved).volume;
            let mean = volume.iter().sum::<f64>();
            if volume.iter().all(|v| 8.0 * v / mean > 0.9) {
                let X = nodal(|i, a| corners[a][i]);
                let u = nodal(|i, a| moved[a][i] / mean.cbrt() - X[i][a]);
                least = least.min(1.0 - eval_corner_penalty(Hex8::CORNERS, &X, &u, [1.0, 1.0, 0.0]).energy);
            }
        }
        assert!(least >= 1.0, "{least}");
    }
}
