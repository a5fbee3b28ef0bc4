//! What every law reads of the deformation, formed so that nothing cancels near rest.

use crate::mechanics::real::{Real, inverse_cbrt_m1};
use crate::mechanics::tensor::{Sym, Tensor};

/// The deformation at one point.
#[derive(Clone, Copy, Debug)]
pub struct Kinematics<R> {
    /// Deformation gradient F = I + ∇u [-].
    pub F: Tensor<R>,
    /// cof F = J F⁻ᵀ [-].
    pub cof: Tensor<R>,
    /// J − 1, without cancellation [-].
    pub j: R,
    /// J = det F [-].
    pub J: R,
    /// Green strain E = ½(FᵀF − I), from ∇u without cancellation [-].
    pub E: Sym<R>,
    /// J^(−1/3) − 1, to full relative accuracy [-].
    pub a: R,
    /// 1/J, as the cube of J^(−1/3): a division is as long as the rest of the cofactor [-].
    pub J_inverse: R,
}

impl<R: Real> Kinematics<R> {
    /// From the displacement gradient `H = ∇u = F − I`. J must be positive (the caller checks `j > −1`).
    #[inline(always)]
    pub fn new(H: &Tensor<R>) -> Self {
        let j = volume_change(H);
        Self::with_volume_change(H, j, inverse_cbrt_m1(j))
    }

    /// As [`Kinematics::new`], for those who have `j = J − 1` of [`volume_change`] and `a = J^(−1/3) − 1` already.
    #[inline(always)]
    pub fn with_volume_change(H: &Tensor<R>, j: R, a: R) -> Self {
        let h = &H.0;
        let one = h[0][0].constant(1.0);
        let F = H.plus(&Tensor::diagonal(one));
        let cof = F.cofactor();
        let mut E = Sym([one; 6]);
        for (e, (a, b)) in E.0.iter_mut().zip([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]) {
            let quadratic = h[2][a].mul_add(h[2][b], h[1][a].mul_add(h[1][b], h[0][a] * h[0][b]));
            *e = (quadratic + h[a][b] + h[b][a]) * 0.5;
        }
        let root = a + 1.0;
        Self { F, cof, j, J: j + 1.0, E, a, J_inverse: root * root * root }
    }

    /// J^(−2/3) − 1.
    #[inline(always)]
    pub fn j23_m1(&self) -> R {
        self.a * (self.a + 2.0)
    }

    /// F⁻ᵀ.
    #[inline(always)]
    pub fn inverse_transpose(&self) -> Tensor<R> {
        self.cof.scaled(self.J_inverse)
    }

    /// J^(2/3).
    #[inline(always)]
    pub fn J23(&self) -> R {
        self.J * (self.a + 1.0)
    }
}

/// J − 1 of F = I + H, without cancellation: `det(I + H) − 1 = tr H + tr cof H + det H`.
#[inline(always)]
pub fn volume_change<R: Real>(H: &Tensor<R>) -> R {
    let cof = H.cofactor();
    let h = &H.0;
    let det = h[0][2].mul_add(cof.0[0][2], h[0][1].mul_add(cof.0[0][1], h[0][0] * cof.0[0][0]));
    H.trace() + cof.trace() + det
}

/// Invariants of C and bounds of the principal stretches, for the stiffness bounds.
#[derive(Clone, Copy, Debug)]
pub struct Invariants<R> {
    /// I1 = tr C.
    pub I1: R,
    /// I2 = ½(I1² − tr C²).
    pub I2: R,
    /// tr C⁻¹ = I2 / J².
    pub trace_C_inverse: R,
    /// Upper bound of the largest eigenvalue of C (the square of the largest stretch); exact at rest.
    pub max_C: R,
    /// Upper bound of the largest eigenvalue of C⁻¹; exact at rest.
    pub max_C_inverse: R,
}

impl<R: Real> Invariants<R> {
    /// From the kinematics of the point.
    ///
    /// The largest eigenvalue of a symmetric 3×3 matrix with mean m and deviator s is at most `m + 2 √(s:s/6)`
    /// (the cosine of the closed-form solution set to 1).
    #[inline(always)]
    pub fn new(k: &Kinematics<R>) -> Self {
        // With C = I + 2E: C² has the deviator of 4(E + E²).
        let E2 = k.E.squared();
        let t = k.E.trace();
        let I1 = t * 2.0 + 3.0;
        let I2 = t * 4.0 + 3.0 + (t * t - E2.trace()) * 2.0;
        let J2_inverse = k.J_inverse * k.J_inverse;
        let trace_C_inverse = I2 * J2_inverse;
        let dev_C = k.E.deviator().norm_squared() * 4.0;
        // cof C = C² − I1 C + I2 I, so its deviator is that of 4E² + 2(2 − I1) E.
        let four = I1.constant(4.0);
        let dev_cof = E2.scaled(four).plus_scaled(I1 * -2.0 + 4.0, &k.E).deviator();
        let dev_C_inverse = dev_cof.norm_squared() * (J2_inverse * J2_inverse);
        Self {
            I1,
            I2,
            trace_C_inverse,
            max_C: bound_largest(I1 * (1.0 / 3.0), dev_C),
            max_C_inverse: bound_largest(trace_C_inverse * (1.0 / 3.0), dev_C_inverse),
        }
    }
}

/// Upper bound of the largest eigenvalue of a symmetric 3×3 matrix with mean m and deviator s: `m + 2 √(s:s/6)`, the cosine
/// of the closed-form solution set to 1.
#[inline(always)]
fn bound_largest<R: Real>(mean: R, deviator_squared: R) -> R {
    mean + (deviator_squared.max(mean.zero()) * (1.0 / 6.0)).sqrt() * 2.0
}
