//! The kinematic quantities that laws use, computed without cancellation near rest.

use crate::real::{Real, inverse_cbrt_m1};
use crate::tensor::{Sym, Tensor};

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
    /// C − I = FᵀF − I, twice the Green strain, from ∇u without cancellation [-].
    pub C_minus_I: Sym<R>,
    /// Mean of the eigenvalues of C, tr C / 3 [-].
    pub mean_C: R,
    /// Deviator of C [-].
    pub dev_C: Sym<R>,
    /// Mean of the eigenvalues of cof C, I2 / 3 [-].
    pub mean_cof_C: R,
    /// Deviator of cof C [-].
    pub dev_cof_C: Sym<R>,
    /// J^(−1/3) − 1, to full relative accuracy [-].
    pub a: R,
    /// 1/J, as the cube of J^(−1/3): a division would take as long as the rest of the cofactor [-].
    pub J_inverse: R,
}

impl<R: Real> Kinematics<R> {
    /// From the displacement gradient `H = ∇u = F − I`. J must be positive (the caller checks `j > −1`).
    #[inline(always)]
    pub fn new(H: &Tensor<R>) -> Self {
        let j = volume_change(H);
        Self::with_volume_change(H, j, inverse_cbrt_m1(j))
    }

    /// As [`Kinematics::new`], where `j = J − 1` of [`volume_change`] and `a = J^(−1/3) − 1` are known.
    ///
    /// With s the deviator of C, m its mean and q = s : s, `cof C = cof(m I + s)` has the mean `m² − q/6` and the deviator
    /// `s² − m s − q/3 I`: linear in s, so that nothing cancels near rest.
    #[inline(always)]
    pub fn with_volume_change(H: &Tensor<R>, j: R, a: R) -> Self {
        let h = &H.0;
        let one = j.constant(1.0);
        let F = H.plus(&Tensor::diagonal(one));
        let cof = F.cofactor();
        // C − I and its deviator.
        let mut G = Sym([one; 6]);
        for (g, (a, b)) in G.0.iter_mut().zip(Sym::<R>::INDICES) {
            let linear = h[a][b] + h[b][a];
            *g = h[2][a].mul_add(h[2][b], h[1][a].mul_add(h[1][b], h[0][a].mul_add(h[0][b], linear)));
        }
        let third = j.constant(1.0 / 3.0);
        let dev_C = G.deviator();
        let mean_C = G.trace().mul_add(third, one);
        // cof C by its mean and deviator.
        let q = dev_C.norm_squared();
        let dev_cof_C = dev_C.squared().plus_scaled(-mean_C, &dev_C).plus_diagonal(-(q * third));
        let root = a + 1.0;
        Self {
            F,
            cof,
            j,
            J: j + 1.0,
            C_minus_I: G,
            mean_C,
            dev_C,
            mean_cof_C: mean_C.mul_sub(mean_C, q * (1.0 / 6.0)),
            dev_cof_C,
            a,
            J_inverse: root * root * root,
        }
    }

    /// J^(−2/3) − 1 [-], without cancellation.
    #[inline(always)]
    pub fn j23_m1(&self) -> R {
        self.a * (self.a + 2.0)
    }

    /// I2/3 − 1, without cancellation.
    #[inline(always)]
    pub fn mean_cof_C_m1(&self) -> R {
        let trace = self.C_minus_I.trace();
        let second = (trace * trace - self.C_minus_I.norm_squared()) * 0.5;
        (trace * 2.0 + second) * (1.0 / 3.0)
    }

    /// Isochoric factor J^(2/3) [-].
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
    let linear = H.trace() + cof.trace();
    h[0][2].mul_add(cof.0[0][2], h[0][1].mul_add(cof.0[0][1], h[0][0].mul_add(cof.0[0][0], linear)))
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
    /// Invariants and bounds from the kinematics at a point.
    #[inline(always)]
    pub fn new(k: &Kinematics<R>) -> Self {
        let J2_inverse = k.J_inverse * k.J_inverse;
        let (I1, I2) = (k.mean_C * 3.0, k.mean_cof_C * 3.0);
        // C⁻¹ = cof C / J²
        let dev_C_inverse = k.dev_cof_C.norm_squared() * (J2_inverse * J2_inverse);
        Self {
            I1,
            I2,
            trace_C_inverse: I2 * J2_inverse,
            max_C: bound_largest(k.mean_C, k.dev_C.norm_squared()),
            max_C_inverse: bound_largest(k.mean_cof_C * J2_inverse, dev_C_inverse),
        }
    }
}

/// Upper bound of the largest eigenvalue of a symmetric 3×3 matrix with mean m and deviator s: `m + 2 √(s:s/6)`, the cosine
/// of the closed-form solution set to 1.
#[inline(always)]
pub fn bound_largest<R: Real>(mean: R, deviator_squared: R) -> R {
    (deviator_squared * (1.0 / 6.0)).sqrt().mul_add(mean.constant(2.0), mean)
}
