//! Mooney–Rivlin rubber.

use super::{Invariants, Kinematics, Law, Response, Volumetric};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::{Sym, Tensor};

/// ψ = C10 (Ī1 − 3) + C01 (Ī2 − 3) + U(J)      (Mooney 1940; Rivlin 1948; isochoric split)
///
/// Ī1 = J^(−2/3) I1, Ī2 = J^(−4/3) I2. Shear modulus at rest 2 (C10 + C01).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlin {
    /// C10 [Pa].
    pub c10: f64,
    /// C01 [Pa].
    pub c01: f64,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

/// ψ and P of `c (Ī1 − 3)`: `P = 2 c J^(−2/3) F⁻ᵀ dev(2E)`, since `F − I1/3 F⁻ᵀ = F⁻ᵀ dev C`.
///
/// In this form the stress is exactly zero at rest and loses no digits near it.
#[inline(always)]
pub(super) fn eval_first_invariant<R: Real>(c: f64, k: &Kinematics<R>) -> (R, Sym<R>) {
    let b = k.j23_m1();
    let t = k.E.trace() * 2.0;
    // Ī1 − 3 = (1 + b)(3 + t) − 3
    let psi = (b * (t + 3.0) + t) * c;
    (psi, k.E.deviator().scaled((b + 1.0) * (4.0 * c)))
}

/// `F⁻ᵀ M` for a symmetric M (the Mandel stress C S).
#[inline(always)]
pub(super) fn stress_from_mandel<R: Real>(k: &Kinematics<R>, M: &Sym<R>) -> Tensor<R> {
    k.inverse_transpose().dot_sym(M)
}

/// Bound [Pa] of the Hessian of `c (Ī1 − 3)`: `c J^(−2/3) [2 + ⅔ I1 y² + 4/9 (I1 tr C⁻¹ − 9)]`, y² the largest
/// eigenvalue of C⁻¹; its exact value 4c at rest.
///
/// In principal stretches the 3×3 block is `2I + ⅔ I1 diag(y²) + 4/9 I1 (y − 3s/I1)⊗(…) − 4/I1 s⊗s` with yᵢ = 1/sᵢ,
/// and the rotation modes are at most `2 + ⅔ I1 yᵢ yⱼ`.
#[inline(always)]
pub(super) fn bound_first_invariant<R: Real>(c: f64, k: &Kinematics<R>, inv: &Invariants<R>) -> R {
    let spread = inv.I1 * inv.trace_C_inverse - 9.0;
    (k.j23_m1() + 1.0) * (inv.I1 * inv.max_C_inverse * (2.0 / 3.0) + spread * (4.0 / 9.0) + 2.0) * c
}

impl Law for MooneyRivlin {
    #[inline(always)]
    fn eval<R: Real>(&self, k: &Kinematics<R>, _fibres: &[[R; 3]]) -> Response<R> {
        let (psi1, M1) = eval_first_invariant(self.c10, k);
        // I2 = 3 + 4 tr E + 2 (tr²E − tr E²); Mandel part dev(I1 C − C²) = dev((2 + 4 tr E) E − 4 E²)
        let t = k.E.trace();
        let E2 = k.E.squared();
        let i2 = t * 4.0 + (t * t - E2.trace()) * 2.0;
        let b = k.j23_m1();
        let b2 = b * (b + 2.0);
        let psi2 = (b2 * (i2 + 3.0) + i2) * self.c01;
        let factor = (b2 + 1.0) * (2.0 * self.c01);
        let M2 = k.E.scaled(t * 4.0 + 2.0).plus_scaled(t.constant(-4.0), &E2).deviator();
        Response { psi: psi1 + psi2, P: stress_from_mandel(k, &M1.plus_scaled(factor, &M2)) }
    }

    #[inline(always)]
    fn eval_stiffness_bound<R: Real>(&self, k: &Kinematics<R>, inv: &Invariants<R>, _fibres: &[[R; 3]]) -> R {
        bound_first_invariant(self.c10, k, inv) + bound_second_invariant(self.c01, k, inv)
    }

    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }

    fn moduli_at_rest(&self) -> (f64, f64) {
        (2.0 * (self.c10 + self.c01), self.volumetric.bulk_modulus())
    }
}

/// Bound [Pa] of the Hessian of `c (Ī2 − 3)`, from `Ī2 = Ī1(F⁻ᵀ)`; its exact value 4c at rest.
///
/// With yᵢ = 1/sᵢ, Y = Σ y², and β the bound of the first-invariant form in y, the principal block is at most
/// `y⁴ β + J^(2/3) max(4 y⁴ − 4/3 Y y²)` and the rotation modes `J^(2/3) y² (6 y² − ⅔ Y)`.
#[inline(always)]
fn bound_second_invariant<R: Real>(c: f64, k: &Kinematics<R>, inv: &Invariants<R>) -> R {
    let one_third = k.a + 1.0;
    let j23 = (one_third * one_third).constant(1.0) / (one_third * one_third);
    let Y = inv.trace_C_inverse;
    let y2 = inv.max_C_inverse;
    let beta = Y * inv.max_C * (2.0 / 3.0) + (Y * inv.I1 - 9.0) * (4.0 / 9.0) + 2.0;
    // 4y⁴ − 4/3 Y y² is convex in y², so its maximum over [0, y²max] is at an end: 0 or y²max.
    let curvature = (y2 * y2 * 4.0 - Y * y2 * (4.0 / 3.0)).max(y2.zero());
    let principal = y2 * y2 * beta + curvature;
    let rotation = y2 * (y2 * 6.0 - Y * (2.0 / 3.0));
    j23 * principal.max(rotation) * c
}
