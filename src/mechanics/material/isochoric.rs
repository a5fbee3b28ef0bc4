//! The isochoric invariants Ī1 and Ī2: energy, stress and stiffness bound of `c (Ī1 − 3)` and `c (Ī2 − 3)`.
//!
//! Every law with an isochoric matrix is made of these. Both are formed from the deviator of C or of cof C, which
//! is formed from the strain, so that energy and stress are exactly 0 at rest and keep their digits near it.

use super::{Invariants, Kinematics};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::{Sym, Tensor};

/// `F⁻ᵀ M`, the stress P of a symmetric Mandel stress M = C S.
#[inline(always)]
pub(super) fn stress_from_mandel<R: Real>(k: &Kinematics<R>, M: &Sym<R>) -> Tensor<R> {
    k.inverse_transpose().dot_sym(M)
}

/// `c (Ī1 − 3)` [J/m³] and its Mandel stress `2 c J^(−2/3) dev C` [Pa], since `F − I1/3 F⁻ᵀ = F⁻ᵀ dev C`.
#[inline(always)]
pub(super) fn eval_first_invariant<R: Real>(c: f64, k: &Kinematics<R>) -> (R, Sym<R>) {
    let dev_C = k.E.scaled(k.J.constant(2.0)).deviator();
    let j23 = k.j23_m1() + 1.0;
    let excess = isochoric_excess(k.E.trace() * (2.0 / 3.0) + 1.0, &dev_C, j23);
    (excess * c, dev_C.scaled(j23 * (2.0 * c)))
}

/// `c (Ī2 − 3)` [J/m³] and its Mandel stress `−2 c J^(−4/3) dev cof C` [Pa].
///
/// Ī2 is the Ī1 of cof C: tr cof C = I2 and det cof C = J⁴.
#[inline(always)]
pub(super) fn eval_second_invariant<R: Real>(c: f64, k: &Kinematics<R>) -> (R, Sym<R>) {
    // tr cof C − 3 = 4 tr E + 2 (tr²E − tr E²) and dev cof C = dev(4 E² − (2 + 4 tr E) E)
    let t = k.E.trace();
    let E2 = k.E.squared();
    let mean = (t * 4.0 + (t * t - E2.trace()) * 2.0) * (1.0 / 3.0) + 1.0;
    let dev_cof = E2.scaled(t.constant(4.0)).plus_scaled(t * -4.0 - 2.0, &k.E).deviator();
    let j23 = k.j23_m1() + 1.0;
    let j43 = j23 * j23;
    let excess = isochoric_excess(mean, &dev_cof, j43);
    (excess * c, dev_cof.scaled(j43 * (-2.0 * c)))
}

/// `3 (w − 1)` with `w = mean / det^(1/3)` of the matrix `mean I + s`, tr s = 0; `scale = det^(−1/3)`.
///
/// As `mean³ − det = ½ mean s:s − det s`, this is `3 (½ mean s:s − det s) / (det (w² + w + 1))`: quadratic in s,
/// where the difference `scale · 3 mean − 3` would be left with the rounding of its first-order terms.
#[inline(always)]
fn isochoric_excess<R: Real>(mean: R, s: &Sym<R>, scale: R) -> R {
    let w = mean * scale;
    let d = mean * s.norm_squared() * 0.5 - s.determinant();
    d * scale * scale * scale * 3.0 / ((w + 1.0) * w + 1.0)
}

/// Bound [Pa] of the Hessian of `c (Ī1 − 3)`: `c J^(−2/3) [2 + ⅔ I1 y² + 4/9 (I1 tr C⁻¹ − 9)]`, y² the largest
/// eigenvalue of C⁻¹; its exact value 4c at rest.
///
/// In principal stretches, yᵢ = 1/sᵢ, the 3×3 block is `2I + ⅔ I1 diag(y²) + 4/9 I1 w⊗w − 4/I1 s⊗s` with
/// `w = y − 3s/I1`, `|w|² I1 = I1 tr C⁻¹ − 9`, and the rotation modes are `2 ± ⅔ I1 yᵢ yⱼ`.
#[inline(always)]
pub(super) fn bound_first_invariant<R: Real>(c: f64, k: &Kinematics<R>, inv: &Invariants<R>) -> R {
    let spread = inv.I1 * inv.trace_C_inverse - 9.0;
    (k.j23_m1() + 1.0) * (inv.I1 * inv.max_C_inverse * (2.0 / 3.0) + spread * (4.0 / 9.0) + 2.0) * c
}

/// Bound [Pa] of the Hessian of `c (Ī2 − 3)`, Ī2 = J^(2/3) Y, Y = tr C⁻¹: `c J^(2/3) [6 y⁴ − ⅔ Y y² + 4/9 Y |w|²]`,
/// y² the largest eigenvalue of C⁻¹; its exact value 4c at rest.
///
/// In principal stretches the 3×3 block is `diag(6 y⁴ − ⅔ Y y²) + 4/9 Y w⊗w − 4/Y y³⊗y³` with `w = y − 3y³/Y`,
/// `Y |w|² = 4Y² − 15 I1/J² + 27/(J² Y)`. The diagonal is convex in y², at most its value at the largest one
/// (where it is positive, as Y ≤ 3y²). Rotation modes: `yᵢyⱼ [2 (yᵢ² + yᵢyⱼ + yⱼ²) − ⅔ Y]`, no larger than that, and
/// `yᵢyⱼ [⅔ Y − 2 (yᵢ² − yᵢyⱼ + yⱼ²)] ≤ ⅔ y⁴`.
#[inline(always)]
pub(super) fn bound_second_invariant<R: Real>(c: f64, k: &Kinematics<R>, inv: &Invariants<R>) -> R {
    let Y = inv.trace_C_inverse;
    let y2 = inv.max_C_inverse;
    let J2_inverse = k.J_inverse * k.J_inverse;
    let spread = Y * Y * 4.0 - inv.I1 * J2_inverse * 15.0 + J2_inverse * 27.0 / Y;
    k.J23() * (y2 * (y2 * 6.0 - Y * (2.0 / 3.0)) + spread.max(Y.zero()) * (4.0 / 9.0)) * c
}
