//! Neo-Hookean solids: the isochoric split and the coupled compressible form.

use super::mooney_rivlin::{bound_first_invariant, eval_first_invariant, stress_from_mandel};
use super::{Invariants, Kinematics, Law, Response, Volumetric};
use crate::mechanics::real::Real;

/// ψ = C10 (Ī1 − 3) + U(J). Shear modulus at rest 2 C10.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// C10 [Pa].
    pub c10: f64,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for NeoHookean {
    #[inline(always)]
    fn eval<R: Real>(&self, k: &Kinematics<R>, _fibres: &[[R; 3]]) -> Response<R> {
        let (psi, M) = eval_first_invariant(self.c10, k);
        Response { psi, P: stress_from_mandel(k, &M) }
    }
    #[inline(always)]
    fn eval_stiffness_bound<R: Real>(&self, k: &Kinematics<R>, inv: &Invariants<R>, _fibres: &[[R; 3]]) -> R {
        bound_first_invariant(self.c10, k, inv)
    }
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }
    fn moduli_at_rest(&self) -> (f64, f64) {
        (2.0 * self.c10, self.volumetric.bulk_modulus())
    }
}

/// ψ = μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)²      (Bonet & Wood 2008)
///
/// P = μ (F − F⁻ᵀ) + λ ln J F⁻ᵀ. Coupled: it has no separate U(J), so its elements use full integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledNeoHookean {
    /// Shear modulus μ [Pa].
    pub mu: f64,
    /// First Lamé parameter λ [Pa].
    pub lambda: f64,
}

impl Law for CoupledNeoHookean {
    #[inline(always)]
    fn eval<R: Real>(&self, k: &Kinematics<R>, _fibres: &[[R; 3]]) -> Response<R> {
        let ln_J = k.j.ln_1p();
        let psi = (k.E.trace() - ln_J) * self.mu + ln_J * ln_J * (0.5 * self.lambda);
        // F⁻ᵀ (2 μ E + λ ln J I): exactly zero at rest
        let mut M = k.E.scaled(ln_J.constant(2.0 * self.mu));
        for d in &mut M.0[..3] {
            *d += ln_J * self.lambda;
        }
        Response { psi, P: stress_from_mandel(k, &M) }
    }
    /// `μ + |μ − λ ln J| y² + λ⁺ tr C⁻¹`, y² the largest eigenvalue of C⁻¹; 2μ + 3λ at rest.
    #[inline(always)]
    fn eval_stiffness_bound<R: Real>(&self, k: &Kinematics<R>, inv: &Invariants<R>, _fibres: &[[R; 3]]) -> R {
        let ln_J = k.j.ln_1p();
        let skew = (ln_J * -self.lambda + self.mu).abs() * inv.max_C_inverse;
        skew + inv.trace_C_inverse * self.lambda.max(0.0) + self.mu
    }
    fn volumetric(&self) -> Option<Volumetric> {
        None
    }
    fn moduli_at_rest(&self) -> (f64, f64) {
        (self.mu, self.lambda + 2.0 / 3.0 * self.mu)
    }
}
