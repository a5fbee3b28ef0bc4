//! Fibre families with an energy W(E) each: stress and stiffness bound, for any W.

use super::{BoundedResponse, Invariants, Kinematics, Response};
use crate::real::Real;
use crate::tensor::Sym;

/// Invariants used in a fibre term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum I4Form {
    /// The full I1, I4: a compressible tissue does not swell under fibre tension (the default).
    Full,
    /// J^(−2/3) I1, J^(−2/3) I4, for comparison with codes that use them.
    Isochoric,
}

/// The strain of a family: `E_a = κ (I1 − 3) + (1 − 3κ)(I4a − 1)`, I1 and I4 full or isochoric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FibreInvariant {
    /// Dispersion κ, 0 (aligned) … 1/3 (isotropic) [-].
    pub kappa: f64,
    /// Full or isochoric I1 and I4.
    pub form: I4Form,
}

/// Strain and stretch of one family.
#[derive(Clone, Copy)]
pub(super) struct FibreStrain<R> {
    /// Positive part ⟨E_a⟩ of the strain [-].
    pub E: R,
    /// The square of its stretch, a·C a [-].
    I4: R,
}

/// The energy W(E) of one family and its derivatives, at E ≥ 0.
pub(super) struct FibreEnergy<R> {
    /// Energy W(E) per reference volume [J/m³].
    pub W: R,
    /// First derivative W′ ≥ 0 [Pa].
    pub dW: R,
    /// Non-negative upper bound of W″ [Pa]; the right-hand limit at E = 0.
    pub ddW: R,
}

impl FibreInvariant {
    /// Strain of the family `a`; exactly 0 at rest.
    ///
    /// With `θ = κ I1 + (1 − 3κ) I4 = 1 + E_a` of the full invariants, the isochoric ones give `J^(−2/3) θ − 1`.
    #[inline(always)]
    pub fn strain<R: Real>(&self, k: &Kinematics<R>, a: &[R; 3]) -> FibreStrain<R> {
        let I4_m1 = k.C_minus_I.quadratic_form(a);
        let aligned = I4_m1 * (1.0 - 3.0 * self.kappa);
        let full = k.C_minus_I.trace().mul_add(aligned.constant(self.kappa), aligned);
        let strain = match self.form {
            I4Form::Full => full,
            I4Form::Isochoric => k.j23_m1().mul_add(full + 1.0, full),
        };
        FibreStrain { E: strain.max(strain.zero()), I4: I4_m1 + 1.0 }
    }

    /// Bound [Pa] of the Hessian of one family's term: `W″ |∂E_a/∂F|² + W′ max(∂²E_a/∂F²)`.
    ///
    /// An inactive family enters with W″(0⁺): that is the one-sided value at rest, and the critical time step must
    /// hold if the family becomes active within the step.
    ///
    /// With `B = κ F + (1 − 3κ) F a⊗a`, `|B|² = κ² I1 + (1 − 3κ)(1 − κ) I4`, `θ = κ I1 + (1 − 3κ) I4`:
    /// full: ∂E = 2B, ∂²E ≤ 2 (1 − 2κ); isochoric: ∂E = 2 J^(−2/3) (B − θ/3 F⁻ᵀ) and, by completing the square,
    /// `∂²E ≤ J^(−2/3) [4/9 θ |F⁻ᵀ − 3B/θ|² + 2 (1 − 2κ) + ⅔ θ y²]`, y² the largest eigenvalue of C⁻¹.
    #[inline(always)]
    fn bound<R: Real>(
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
        match self.form {
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

/// Sums the terms of the families, starting from the energy and the bound of a matrix.
pub(super) struct FibreTerms<R> {
    invariant: FibreInvariant,
    psi: R,
    bound: R,
    /// S [Pa], without the volumetric correction of isochoric invariants.
    S: Sym<R>,
    trace_CS: R,
}

impl<R: Real> FibreTerms<R> {
    /// Starts with the matrix alone: its energy `psi` and stiffness `bound`.
    #[inline(always)]
    pub fn new(invariant: FibreInvariant, psi: R, bound: R) -> Self {
        let zero = psi.zero();
        Self { invariant, psi, bound, S: Sym([zero; 6]), trace_CS: zero }
    }

    /// Adds the family `a`: S = 2 W′ [κ I + (1 − 3κ) a⊗a].
    #[inline(always)]
    pub fn add(
        &mut self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        a: &[R; 3],
        (strain, energy): (FibreStrain<R>, FibreEnergy<R>),
    ) {
        let kappa = self.invariant.kappa;
        self.psi += energy.W;
        let aligned = energy.dW * (2.0 - 6.0 * kappa);
        let spread = energy.dW * (2.0 * kappa);
        let along = [a[0] * aligned, a[1] * aligned, a[2] * aligned];
        let mut S = self.S.plus_diagonal(spread);
        S.0[0] = along[0].mul_add(a[0], S.0[0]);
        S.0[1] = along[1].mul_add(a[1], S.0[1]);
        S.0[2] = along[2].mul_add(a[2], S.0[2]);
        S.0[3] = along[0].mul_add(a[1], S.0[3]);
        S.0[4] = along[1].mul_add(a[2], S.0[4]);
        S.0[5] = along[0].mul_add(a[2], S.0[5]);
        self.S = S;
        self.trace_CS += energy.dW * (strain.E + 1.0) * 2.0;
        self.bound += self.invariant.bound(k, inv, strain, &energy);
    }

    /// Adds another term: its energy, S and stiffness bound; of full invariants.
    #[inline(always)]
    pub fn add_term(&mut self, (psi, S, bound): (R, Sym<R>, R)) {
        self.psi += psi;
        self.S = self.S.plus_scaled(psi.constant(1.0), &S);
        self.bound += bound;
    }

    /// The complete response, with the stress of the matrix (which includes −⅓ tr(C S)/J I for isochoric invariants).
    #[inline(always)]
    pub fn response(self, k: &Kinematics<R>, mut matrix: Sym<R>, exponent: R) -> BoundedResponse<R> {
        let mut S = self.S;
        if self.invariant.form == I4Form::Isochoric {
            // C : ∂E_a/∂C = J^(−2/3) θ = 1 + E_a where the family is active
            S = S.scaled(k.j23_m1() + 1.0);
            matrix = matrix.plus_diagonal(self.trace_CS * k.J_inverse * (-1.0 / 3.0));
        }
        let response = Response { psi: self.psi, matrix, fibres: Some(S) };
        BoundedResponse { response, stiffness_bound: self.bound, fibre_exponent: exponent }
    }
}
