//! Holzapfel–Gasser–Ogden tissue, with dispersed fibre families.

use super::isochoric::{bound_first_invariant, eval_first_invariant};
use super::neo_hookean::eval_coupled_matrix;
use super::{BoundedResponse, FibreFamilies, Invariants, Kinematics, Law, Response, Volumetric};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::Sym;

/// The largest exponent k2 E_a² [-] up to which a fibre term is the exponential one.
///
/// Beyond it the energy goes on linearly in the exponent (so quadratically in E_a, with the stress continuous):
/// nothing overflows, whatever a lane holds. e²⁰⁰ ≈ 7·10⁸⁶ is far beyond any tissue: a point that gets there has
/// failed, and [`BoundedResponse::fibre_exponent`] tells.
pub const FIBRE_EXPONENT_LIMIT: f64 = 200.0;

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
/// (Holzapfel, Gasser & Ogden 2000; Gasser, Ogden & Holzapfel 2006.) The whole term of a family is off while its
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
    /// Fibre families.
    pub families: FibreFamilies,
    /// Invariants of the fibre term.
    pub i4: I4Form,
    /// Matrix term.
    pub matrix: MatrixForm,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

/// The stretch of one family.
#[derive(Clone, Copy)]
struct FibreStrain<R> {
    /// ⟨E_a⟩ [-].
    E: R,
    /// The square of its stretch, a·C a [-].
    I4: R,
}

/// The energy W(E) of one family and its derivatives, at E ≥ 0.
struct FibreEnergy<R> {
    /// W = k1/(2 k2) (exp(k2 E²) − 1) [J/m³].
    W: R,
    /// W′ = k1 E exp(k2 E²) [Pa].
    dW: R,
    /// W″ = k1 (1 + 2 k2 E²) exp(k2 E²) [Pa], from above at E = 0, from below at the limit and beyond.
    ddW: R,
}

impl HolzapfelGasserOgden {
    /// k2, and in place of 0 a number so small that `exp_m1(k2 E²) / k2` is E² to the last bit.
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

    /// The strain of the family `a` in the invariants of the law; exactly 0 at rest.
    ///
    /// With `θ = κ I1 + (1 − 3κ) I4 = 1 + E_a` of the full invariants, the isochoric ones give `J^(−2/3) θ − 1`.
    #[inline(always)]
    fn eval_fibre_strain<R: Real>(&self, k: &Kinematics<R>, a: &[R; 3]) -> FibreStrain<R> {
        let I4_m1 = k.C_minus_I.quadratic_form(a);
        let aligned = I4_m1 * (1.0 - 3.0 * self.kappa);
        let full = k.C_minus_I.trace().mul_add(aligned.constant(self.kappa), aligned);
        let strain = match self.i4 {
            I4Form::Full => full,
            I4Form::Isochoric => k.j23_m1().mul_add(full + 1.0, full),
        };
        FibreStrain { E: strain.max(strain.zero()), I4: I4_m1 + 1.0 }
    }

    /// W, W′ and W″ at a fibre strain, continued beyond [`FIBRE_EXPONENT_LIMIT`].
    #[inline(always)]
    fn eval_fibre_energy<R: Real>(&self, strain: FibreStrain<R>) -> FibreEnergy<R> {
        let (k2, E) = (self.exponent(), strain.E);
        let q = E * E * k2;
        let bounded = q.min(q.constant(FIBRE_EXPONENT_LIMIT));
        let e_m1 = bounded.exp_m1();
        let e = e_m1 + 1.0;
        FibreEnergy {
            W: e.mul_add(q - bounded, e_m1) * (0.5 * self.k1 / k2),
            dW: E * e * self.k1,
            ddW: bounded.scale_add(2.0, 1.0) * e * self.k1,
        }
    }

    /// Bound [Pa] of the Hessian of one family's term: `W″ |∂E_a/∂F|² + W′ max(∂²E_a/∂F²)`.
    ///
    /// A family that is off counts with W″(0⁺) = k1: it is the one-sided value at rest, and the stable step must
    /// hold when the family switches on within it.
    ///
    /// With `B = κ F + (1 − 3κ) F a⊗a`, `|B|² = κ² I1 + (1 − 3κ)(1 − κ) I4`, `θ = κ I1 + (1 − 3κ) I4`:
    /// full: ∂E = 2B, ∂²E ≤ 2 (1 − 2κ); isochoric: ∂E = 2 J^(−2/3) (B − θ/3 F⁻ᵀ) and, by completing the square,
    /// `∂²E ≤ J^(−2/3) [4/9 θ |F⁻ᵀ − 3B/θ|² + 2 (1 − 2κ) + ⅔ θ y²]`, y² the largest eigenvalue of C⁻¹.
    #[inline(always)]
    fn bound_fibre_term<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        strain: FibreStrain<R>,
        energy: &FibreEnergy<R>,
    ) -> R {
        let kappa = self.kappa;
        let aligned = 1.0 - 3.0 * kappa;
        let I4 = strain.I4;
        let B2 = inv.I1.mul_add(I4.constant(kappa * kappa), I4 * (aligned * (1.0 - kappa)));
        let curvature = 2.0 * (1.0 - 2.0 * kappa);
        match self.i4 {
            I4Form::Full => (energy.ddW * 4.0).mul_add(B2, energy.dW * curvature),
            I4Form::Isochoric => {
                let j23 = k.j23_m1() + 1.0;
                let theta = inv.I1 * kappa + I4 * aligned;
                let Y = inv.trace_C_inverse;
                let slope = (B2 - theta * (2.0 / 3.0) + theta * theta * Y * (1.0 / 9.0)) * 4.0;
                let square = theta * Y - 6.0 + B2 * 9.0 / theta;
                let bend = square * (4.0 / 9.0) + theta * inv.max_C_inverse * (2.0 / 3.0) + curvature;
                (energy.ddW * slope.max(Y.zero()) * j23 + energy.dW * bend) * j23
            }
        }
    }
}

impl Law for HolzapfelGasserOgden {
    #[inline(always)]
    fn family_count(&self) -> usize {
        self.families.directions().len()
    }

    /// The matrix (with, of isochoric invariants, −⅓ tr(C S)/J I) and S = Σ 2 W′ [κ I + (1 − 3κ) a⊗a].
    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (mut psi, mut matrix, mut bound) = self.eval_matrix(k, inv);
        let zero = psi.zero();
        if fibres.is_empty() {
            let response = Response { psi, matrix, fibres: None };
            return BoundedResponse { response, stiffness_bound: bound, fibre_exponent: zero };
        }
        let mut S = Sym([zero; 6]);
        let (mut trace_CS, mut exponent) = (zero, zero);
        for a in fibres {
            let strain = self.eval_fibre_strain(k, a);
            let energy = self.eval_fibre_energy(strain);
            psi += energy.W;
            let aligned = energy.dW * (2.0 - 6.0 * self.kappa);
            let spread = energy.dW * (2.0 * self.kappa);
            let along = [a[0] * aligned, a[1] * aligned, a[2] * aligned];
            S = S.plus_diagonal(spread);
            S.0[0] = along[0].mul_add(a[0], S.0[0]);
            S.0[1] = along[1].mul_add(a[1], S.0[1]);
            S.0[2] = along[2].mul_add(a[2], S.0[2]);
            S.0[3] = along[0].mul_add(a[1], S.0[3]);
            S.0[4] = along[1].mul_add(a[2], S.0[4]);
            S.0[5] = along[0].mul_add(a[2], S.0[5]);
            trace_CS += energy.dW * (strain.E + 1.0) * 2.0;
            bound += self.bound_fibre_term(k, inv, strain, &energy);
            if self.k1 > 0.0 {
                exponent = exponent.max(strain.E * strain.E * self.k2);
            }
        }
        if self.i4 == I4Form::Isochoric {
            // C : ∂E_a/∂C = J^(−2/3) θ = 1 + E_a where the family is on
            S = S.scaled(k.j23_m1() + 1.0);
            matrix = matrix.plus_diagonal(trace_CS * k.J_inverse * (-1.0 / 3.0));
        }
        let response = Response { psi, matrix, fibres: Some(S) };
        BoundedResponse { response, stiffness_bound: bound, fibre_exponent: exponent }
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
}
