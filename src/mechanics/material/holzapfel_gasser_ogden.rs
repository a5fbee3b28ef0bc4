//! Holzapfel–Gasser–Ogden tissue, with dispersed fibre families.

use super::exponential::BoundedExponential;
use super::fibre_terms::{FibreEnergy, FibreInvariant, FibreStrain, FibreTerms, I4Form};
use super::isochoric::{bound_first_invariant, eval_first_invariant};
use super::neo_hookean::eval_coupled_matrix;
use super::validity::TISSUE;
use super::{
    BoundedResponse, Deformations, FibreFamilies, Invariants, Kinematics, Law, Response, Volumetric,
};
use crate::real::Real;
use crate::tensor::Sym;

/// Form of the matrix term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixForm {
    /// c/2 (Ī1 − 3), the default.
    Isochoric,
    /// c/2 (I1 − 3) − c ln J.
    Coupled,
}

/// ψ = c/2 (Ī1 − 3) + Σ_a k1/(2 k2) (exp[k2 ⟨E_a⟩²] − 1) + U(J),  E_a = κ (I1 − 3) + (1 − 3κ)(I4a − 1)
///
/// (Holzapfel, Gasser & Ogden 2000; Gasser, Ogden & Holzapfel 2006.) The whole term of a family is inactive while its
/// E_a < 0; ψ and P are continuous there, the tangent is not.
///
/// FEBio's "Holzapfel-Gasser-Ogden" is [`MatrixForm::Isochoric`] with [`I4Form::Isochoric`], its "HGO
/// unconstrained" is [`MatrixForm::Coupled`] with [`I4Form::Full`], both with [`Volumetric::QuadraticLn`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolzapfelGasserOgden {
    /// Matrix shear modulus c [Pa], ≥ 0.
    pub c: f64,
    /// Fibre stiffness k1 [Pa], ≥ 0.
    pub k1: f64,
    /// Fibre exponent k2 [-], ≥ 0; at 0 the fibre energy is its limit k1/2 ⟨E_a⟩².
    pub k2: f64,
    /// Dispersion κ, 0 (aligned) … 1/3 (isotropic) [-].
    pub kappa: f64,
    /// Fibre families, at most [`super::MAX_FAMILIES`].
    pub families: FibreFamilies,
    /// Invariants of the fibre term.
    pub i4: I4Form,
    /// Matrix term, isochoric or coupled.
    pub matrix: MatrixForm,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl HolzapfelGasserOgden {
    /// k2, with 0 replaced by a number so small that `exp_m1(k2 E²) / k2` is E² to the last bit.
    #[inline(always)]
    fn exponent(&self) -> f64 {
        self.k2.max(1e-100)
    }

    /// ψ, stress and stiffness bound of the matrix.
    #[inline(always)]
    fn eval_matrix<R: Real>(&self, k: &Kinematics<R>, inv: &Invariants<R>) -> (R, Sym<R>, R) {
        match self.matrix {
            MatrixForm::Isochoric => {
                let (psi, factor) = eval_first_invariant(0.5 * self.c, k);
                (psi, k.dev_C.scaled(factor), bound_first_invariant(0.5 * self.c, k, inv))
            }
            MatrixForm::Coupled => {
                let (psi, matrix) = eval_coupled_matrix(self.c, k);
                (psi, matrix, (inv.max_C_inverse + 1.0) * self.c)
            }
        }
    }

    /// W = k1/(2 k2) (exp(k2 E²) − 1), W′ = k1 E exp(k2 E²) and W″ = k1 (1 + 2 k2 E²) exp(k2 E²), continued beyond
    /// [`super::FIBRE_EXPONENT_LIMIT`], where W″ is the left-hand limit.
    #[inline(always)]
    fn eval_fibre_energy<R: Real>(&self, strain: FibreStrain<R>) -> FibreEnergy<R> {
        let (k2, E) = (self.exponent(), strain.E);
        let e = BoundedExponential::new(E * E * k2);
        FibreEnergy {
            W: e.minus_one * (0.5 * self.k1 / k2),
            dW: E * e.slope * self.k1,
            ddW: e.exponent.scale_add(2.0, 1.0) * e.slope * self.k1,
        }
    }
}

impl Law for HolzapfelGasserOgden {
    const NAME: &'static str = "Holzapfel–Gasser–Ogden";
    const FITTED: Deformations = TISSUE;

    #[inline(always)]
    fn fibre_directions(&self) -> &[[f64; 3]] {
        self.families.directions()
    }

    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (psi, matrix, bound) = self.eval_matrix(k, inv);
        let mut exponent = psi.zero();
        if fibres.is_empty() {
            let response = Response { psi, matrix, fibres: None };
            return BoundedResponse { response, stiffness_bound: bound, fibre_exponent: exponent };
        }
        let invariant = FibreInvariant { kappa: self.kappa, form: self.i4 };
        let mut terms = FibreTerms::new(invariant, psi, bound);
        for a in fibres {
            let strain = invariant.strain(k, a);
            terms.add(k, inv, a, (strain, self.eval_fibre_energy(strain)));
            if self.k1 > 0.0 {
                exponent = exponent.max(strain.E * strain.E * self.k2);
            }
        }
        terms.response(k, matrix, exponent)
    }

    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }

    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        let K = self.volumetric.bulk_modulus();
        match self.matrix {
            MatrixForm::Isochoric => (self.c, K),
            MatrixForm::Coupled => (self.c, K + 2.0 / 3.0 * self.c),
        }
    }

    /// A strain ε along a family adds 4 (1 − 2κ)² k1 ≤ 4 k1 to the modulus: E_a grows by 2 (1 − 2κ) ε, the energy is
    /// k1/2 E_a².
    fn fibre_modulus_at_rest(&self) -> f64 {
        4.0 * self.k1 * self.families.directions().len() as f64
    }

    fn without_idle_fibres(self) -> Self {
        if self.k1 == 0.0 { Self { families: FibreFamilies::NONE, ..self } } else { self }
    }

    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self { c: self.c * factor, k1: self.k1 * factor, ..self })
    }
}
