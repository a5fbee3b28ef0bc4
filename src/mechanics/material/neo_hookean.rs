//! Neo-Hookean solids: the isochoric split and the coupled compressible form.

use super::isochoric::{bound_first_invariant, eval_first_invariant};
use super::validity::TISSUE;
use super::{BoundedResponse, Deformations, Invariants, Kinematics, Law, Response, Volumetric};
use crate::real::{Real, ln_1p_defect};
use crate::tensor::Sym;

/// ψ = C10 (Ī1 − 3) + U(J). Shear modulus at rest 2 C10.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    /// C10 [Pa], ≥ 0.
    pub c10: f64,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for NeoHookean {
    const NAME: &'static str = "neo-Hookean";
    const FITTED: Deformations = TISSUE;

    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        _fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (psi, factor) = eval_first_invariant(self.c10, k);
        BoundedResponse {
            response: Response { psi, matrix: k.dev_C.scaled(factor), fibres: None },
            stiffness_bound: bound_first_invariant(self.c10, k, inv),
            fibre_exponent: k.J.zero(),
        }
    }
    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }
    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (2.0 * self.c10, self.volumetric.bulk_modulus())
    }
    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self { c10: self.c10 * factor, ..self })
    }
}

/// ψ = μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)²      (Bonet & Wood 2008)
///
/// P = μ (F − F⁻ᵀ) + λ ln J F⁻ᵀ. Coupled: it has no separate U(J), so its elements use full integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledNeoHookean {
    /// Shear modulus μ [Pa], ≥ 0.
    pub mu: f64,
    /// First Lamé parameter λ [Pa].
    pub lambda: f64,
}

/// `μ/2 (I1 − 3) − μ ln J` [J/m³] and its stress `μ (C − I) / J` [Pa].
///
/// `½ (I1 − 3) − ln J` is computed as `½ J^(2/3) (Ī1 − 3) + 3/2 (z − ln(1 + z))`, z = J^(2/3) − 1, because tr E and
/// ln J agree to first order.
#[inline(always)]
pub(super) fn eval_coupled_matrix<R: Real>(mu: f64, k: &Kinematics<R>) -> (R, Sym<R>) {
    let (half_excess, _) = eval_first_invariant(0.5, k);
    let j23_m1 = k.j23_m1();
    let J23 = k.J23();
    let psi = (J23 * half_excess + ln_1p_defect(-(j23_m1 * J23)) * 1.5) * mu;
    (psi, k.C_minus_I.scaled(k.J_inverse * mu))
}

impl Law for CoupledNeoHookean {
    const NAME: &'static str = "coupled neo-Hookean";
    const FITTED: Deformations = Deformations { jacobian: [0.7, 1.4], ..TISSUE };

    /// The bound is `μ + max(g⁺ y² + λ⁺ tr C⁻¹, −g y²)`, `g = μ − λ ln J`, y² the largest eigenvalue of C⁻¹; 2μ + 3λ at rest.
    ///
    /// In principal stretches the 3×3 block is `μ I + g diag(y²) + λ y⊗y`, and the rotation modes `μ ± g yᵢ yⱼ`.
    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        _fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let ln_J = k.j.ln_1p();
        let (psi, matrix) = eval_coupled_matrix(self.mu, k);
        let pressure = ln_J * self.lambda;
        let skew = (ln_J * -self.lambda + self.mu) * inv.max_C_inverse;
        let block = skew.max(skew.zero()) + inv.trace_C_inverse * self.lambda.max(0.0);
        BoundedResponse {
            response: Response {
                psi: (pressure * 0.5).mul_add(ln_J, psi),
                matrix: matrix.plus_diagonal(pressure * k.J_inverse),
                fibres: None,
            },
            stiffness_bound: block.max(-skew) + self.mu,
            fibre_exponent: k.J.zero(),
        }
    }
    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        None
    }
    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (self.mu, self.lambda + 2.0 / 3.0 * self.mu)
    }
    fn with_isochoric_scaled(self, _factor: f64) -> Option<Self> {
        None
    }
}
