//! Holzapfel–Gasser–Ogden tissue, with dispersed fibre families.

use super::mooney_rivlin::{bound_first_invariant, eval_first_invariant, stress_from_mandel};
use super::{FibreFamilies, Invariants, Kinematics, Law, Response, Volumetric};
use crate::mechanics::real::Real;

/// Which invariants the fibre term takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum I4Form {
    /// The full I1, I4: a compressible tissue does not swell under fibre tension (the default).
    Full,
    /// J^(−2/3) I1, J^(−2/3) I4, for comparison with codes that use them.
    Isochoric,
}

/// The matrix term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixForm {
    /// c/2 (Ī1 − 3), the default.
    Isochoric,
    /// c/2 (I1 − 3) − c ln J.
    Coupled,
}

/// ψ = c/2 (Ī1 − 3) + Σ_a k1/(2 k2) (exp[k2 ⟨E_a⟩²] − 1) + U(J),  E_a = κ (I1 − 3) + (1 − 3κ)(I4a − 1)
///
/// (Holzapfel, Gasser & Ogden 2000; Gasser, Ogden & Holzapfel 2006.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolzapfelGasserOgden {
    /// Matrix shear modulus c [Pa].
    pub c: f64,
    /// Fibre stiffness k1 [Pa].
    pub k1: f64,
    /// Fibre exponent k2 [-].
    pub k2: f64,
    /// Dispersion κ, 0 (aligned) … 1/3 (isotropic) [-].
    pub kappa: f64,
    /// Fibre families.
    pub families: FibreFamilies,
    /// Invariants of the fibre term.
    pub i4: I4Form,
    /// Matrix term.
    pub matrix: MatrixForm,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for HolzapfelGasserOgden {
    fn family_count(&self) -> usize {
        self.families.directions().len()
    }
    #[inline(always)]
    fn eval<R: Real>(&self, k: &Kinematics<R>, _fibres: &[[R; 3]]) -> Response<R> {
        // SKELETON: the fibre term is still to be written.
        let (psi, M) = eval_first_invariant(0.5 * self.c, k);
        Response { psi, P: stress_from_mandel(k, &M) }
    }
    #[inline(always)]
    fn eval_stiffness_bound<R: Real>(&self, k: &Kinematics<R>, inv: &Invariants<R>, _fibres: &[[R; 3]]) -> R {
        bound_first_invariant(0.5 * self.c, k, inv)
    }
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }
    fn moduli_at_rest(&self) -> (f64, f64) {
        (self.c, self.volumetric.bulk_modulus())
    }
}
