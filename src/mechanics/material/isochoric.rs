//! The isochoric invariants Ī1 and Ī2: energy, stress and stiffness bound of `c (Ī1 − 3)` and `c (Ī2 − 3)`.
//!
//! Every law with an isochoric matrix consists of these. Both are computed from the deviator of C or of cof C, which
//! is computed from the strain, so that energy and stress are exactly 0 at rest and accurate near it.

use super::{Invariants, Kinematics};
use crate::real::Real;
use crate::tensor::Sym;

/// `c (Ī1 − 3)` [J/m³] and the factor [Pa] of dev C in its stress: `F − I1/3 F⁻ᵀ = F⁻ᵀ dev C`, so
/// `P = cof F · (2 c J^(−2/3) / J) dev C`.
#[inline(always)]
pub(super) fn eval_first_invariant<R: Real>(c: f64, k: &Kinematics<R>) -> (R, R) {
    let j23 = k.j23_m1() + 1.0;
    let excess = isochoric_excess(k.mean_C, &k.dev_C, j23, k.J_inverse * k.J_inverse);
    (excess * c, j23 * k.J_inverse * (2.0 * c))
}

/// `c (Ī2 − 3)` [J/m³] and the factor [Pa] of dev cof C in its stress, `−2 c J^(−4/3) / J`.
///
/// Ī2 is the Ī1 of cof C: tr cof C = I2 and det cof C = J⁴.
#[inline(always)]
pub(super) fn eval_second_invariant<R: Real>(c: f64, k: &Kinematics<R>) -> (R, R) {
    let j23 = k.j23_m1() + 1.0;
    let j43 = j23 * j23;
    let J2_inverse = k.J_inverse * k.J_inverse;
    let excess = isochoric_excess(k.mean_cof_C, &k.dev_cof_C, j43, J2_inverse * J2_inverse);
    (excess * c, j43 * k.J_inverse * (-2.0 * c))
}

/// `3 (w − 1)` with `w = mean / det^(1/3)` of the matrix `mean I + s`, tr s = 0; `scale = det^(−1/3)`, and its cube.
///
/// As `mean³ − det = ½ mean s:s − det s`, this is `3 (½ mean s:s − det s) / (det (w² + w + 1))`: quadratic in s,
/// where the difference `scale · 3 mean − 3` would retain the rounding of its first-order terms.
#[inline(always)]
fn isochoric_excess<R: Real>(mean: R, s: &Sym<R>, scale: R, scale_cubed: R) -> R {
    let w = mean * scale;
    let d = (mean * 0.5).mul_sub(s.norm_squared(), s.determinant());
    let one = w.constant(1.0);
    d * (scale_cubed * 3.0) / (w + 1.0).mul_add(w, one)
}

/// Bound [Pa] of the Hessian of `c (Ī1 − 3)`: `c J^(−2/3) [2 + ⅔ I1 y² + 4/9 (I1 tr C⁻¹ − 9)]`, y² the largest
/// eigenvalue of C⁻¹; its exact value 4c at rest.
///
/// In principal stretches, yᵢ = 1/sᵢ, the 3×3 block is `2I + ⅔ I1 diag(y²) + 4/9 I1 w⊗w − 4/I1 s⊗s` with
/// `w = y − 3s/I1`, `|w|² I1 = I1 tr C⁻¹ − 9`, and the rotation modes are `2 ± ⅔ I1 yᵢ yⱼ`.
#[inline(always)]
pub(super) fn bound_first_invariant<R: Real>(c: f64, k: &Kinematics<R>, inv: &Invariants<R>) -> R {
    // 4/9 (I1 tr C⁻¹ − 9) + 2
    let spread = (inv.I1 * inv.trace_C_inverse).scale_add(4.0 / 9.0, -2.0);
    (k.j23_m1() + 1.0) * (inv.I1 * (2.0 / 3.0)).mul_add(inv.max_C_inverse, spread) * c
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
    // 1/(J² Y) = 1/I2
    let outer = (inv.I1 * J2_inverse).mul_add(Y.constant(-15.0), Y.constant(27.0) / inv.I2);
    let spread = (Y * 4.0).mul_add(Y, outer).max(Y.zero()) * (4.0 / 9.0);
    let diagonal = y2.mul_sub(y2.constant(6.0), Y * (2.0 / 3.0));
    k.J23() * diagonal.mul_add(y2, spread) * c
}

/// Bound [Pa] of the Hessian of f(Ī1 − 3) with f′ = `slope` and f″ ≤ `curvature` [Pa]: `|f′| B + ⟨f″⟩ |∂Ī1/∂F|²`, B
/// the bound of [`bound_first_invariant`] (which also bounds the negative eigenvalues), `|∂Ī1/∂F|² = 4/9 J^(−4/3) I1
/// (I1 tr C⁻¹ − 9)`.
#[inline(always)]
pub(super) fn bound_function_of_first<R: Real>(
    slope: R,
    curvature: R,
    k: &Kinematics<R>,
    inv: &Invariants<R>,
) -> R {
    let j23 = k.j23_m1() + 1.0;
    let excess = inv.I1 * inv.trace_C_inverse - 9.0;
    let gradient_squared = excess.max(excess.zero()) * inv.I1 * (j23 * j23) * (4.0 / 9.0);
    let bend = curvature.max(curvature.zero()) * gradient_squared;
    slope.abs().mul_add(bound_first_invariant(1.0, k, inv), bend)
}

/// Bound [-] of the Hessian of `Ī1 − ½ Ī2`; its exact value 2 at rest.
///
/// Mode by mode (see [`bound_first_invariant`] and [`bound_second_invariant`]), with a = J^(−2/3), b = J^(2/3), t =
/// yᵢyⱼ or y²: the reduction by Ī2 is at least `b/2 (6 t² − ⅔ Y t)`, least at t = Y/18 or the smallest t; its `−4/Y
/// y³⊗y³` adds at most `4 ⟨b Y/I1 − a⟩ + 4 b/Y |v|²` to `−4a/I1 s⊗s`, v the part of y³ orthogonal to s, `|v|² = Σy⁶ −
/// Y²/I1`. Rotation modes of the other sign are at most `2a − ⅔ a I1 t + b t (⅔ Y − 2 t)` at the ends of t.
#[inline(always)]
pub(super) fn bound_first_less_second<R: Real>(k: &Kinematics<R>, inv: &Invariants<R>) -> R {
    let (a, b) = (k.j23_m1() + 1.0, k.J23());
    let (I1, Y) = (inv.I1, inv.trace_C_inverse);
    let zero = Y.zero();
    let least = Y.constant(1.0) / inv.max_C;
    let t = least.max(Y * (1.0 / 18.0));
    let taken_off = b * t * (t * 6.0 - Y * (2.0 / 3.0)) * 0.5;
    // Σy⁶ = Y³ − 3 Y I1/J² + 3/J²
    let J2_inverse = k.J_inverse * k.J_inverse;
    let sixth = Y * Y * Y + (Y * I1 - 1.0) * J2_inverse * -3.0;
    let across = (sixth - Y * Y / I1).max(zero);
    let added = (b * Y / I1 - a).max(zero) + b / Y * across;
    let block = bound_first_invariant(1.0, k, inv) - taken_off + added * 4.0;
    let skew = (I1 * least * (-1.0 / 3.0) + 1.0) * a * 2.0
        + b * inv.max_C_inverse * (Y * (2.0 / 3.0) - least * 2.0).max(zero);
    block.max(skew)
}
