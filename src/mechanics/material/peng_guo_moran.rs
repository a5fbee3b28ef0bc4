//! Tissue whose fibres are sheared against their matrix, after Peng, Guo and Moran.

use super::fibre_terms::{FibreEnergy, FibreInvariant, FibreTerms, I4Form};
use super::isochoric::{bound_first_invariant, eval_first_invariant};
use super::validity::TISSUE;
use super::{
    BoundedResponse, Deformations, ElementTime, FibreFamilies, Invariants, Kinematics, Law, Response,
    Volumetric,
};
use crate::real::Real;
use crate::tensor::Sym;

/// Largest exponent of the logistic function [-]: it is 0 beyond.
const MOST_EXPONENT: f64 = 300.0;

/// ψ = C10 (Ī1 − 3) + Σ_a [C2 ⟨I4 − 1⟩² + C3 ⟨I4 − 1⟩⁴ + f(λ) χ²] + U(J), f = γ/(1 + e^(−β (λ − λ*))), λ = √I4
///
/// (Peng, Guo & Moran 2006.) `χ = I4/I3 (I5 − I1 I4 + I2) − 1 = (a·C a)(a·C⁻¹ a) − 1 = |F a × F⁻ᵀ a|²` is the square of the
/// tangent of the angle between a fibre and the normal of the plane that it was normal to: γ² in simple shear of the amount γ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PengGuoMoran {
    /// C10 [Pa], > 0.
    pub c10: f64,
    /// C2 and C3 of the fibres [Pa], ≥ 0.
    pub fibre: [f64; 2],
    /// Shear of fibres against the matrix.
    pub shear: FibreShear,
    /// Fibre families, at most [`super::MAX_FAMILIES`].
    pub families: FibreFamilies,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

/// The function f of the stretch of a fibre: 0 in the slack fibre, γ in the taut one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreShear {
    /// γ [Pa], ≥ 0.
    pub gamma: f64,
    /// β [-], ≥ 0.
    pub beta: f64,
    /// λ* [-], the stretch at which f is half of γ.
    pub stretch: f64,
}

impl FibreShear {
    /// f and its derivative by the stretch [Pa].
    #[inline(always)]
    fn eval<R: Real>(&self, stretch: R) -> [R; 2] {
        let exponent = (-stretch + self.stretch) * self.beta;
        let slack = exponent.min(exponent.constant(MOST_EXPONENT)).exp();
        let taut = slack.constant(1.0) / (slack + 1.0);
        let f = taut * self.gamma;
        [f, f * (-taut + 1.0) * self.beta]
    }

    /// Energy, S and a bound of the Hessian of f χ² of the family `a`.
    ///
    /// S = (f′/λ) χ² a⊗a + 4 f χ (Q a⊗a − I4 c⊗c), c = C⁻¹ a, Q = a·c.
    ///
    /// Bound: `χ² f′ (β + 1/λ) + 4 χ f′ |∂χ| + 2 f |∂χ|² + 2 f χ |∂²χ|` with `|∂χ|² = 4 Q I4 (I4 |c|² − Q)` and `|∂²χ| ≤ Q (2 +
    /// 8 λ y + 6 I4 y²)`, y² the largest eigenvalue of C⁻¹: |∂λ| ≤ 1, ∂²λ ≤ 1/λ, f″ ≤ β f′.
    #[inline(always)]
    fn term<R: Real>(&self, k: &Kinematics<R>, inv: &Invariants<R>, a: &[R; 3]) -> (R, Sym<R>, R) {
        let one = k.J.constant(1.0);
        let fibre = k.F.apply(a);
        let normal = k.cof.apply(a);
        // F a × F⁻ᵀ a: parallel at rest, so that χ has no rounding of its terms.
        let cross = |i: usize, j: usize| (fibre[i] * normal[j] - fibre[j] * normal[i]) * k.J_inverse;
        let [x, y, z] = [cross(1, 2), cross(2, 0), cross(0, 1)];
        let chi = x * x + y * y + z * z;
        let I4 = k.C_minus_I.quadratic_form(a) + 1.0;
        let J2_inverse = k.J_inverse * k.J_inverse;
        let cof_C = k.dev_cof_C.plus_diagonal(k.mean_cof_C);
        let c = cof_C.apply(a).map(|c| c * J2_inverse);
        let Q = cof_C.quadratic_form(a) * J2_inverse;

        let stretch = I4.sqrt();
        let [f, slope] = self.eval(stretch);
        let twice = f * chi * 4.0;
        let along = slope / stretch * chi * chi + twice * Q;
        let S = Sym([one.zero(); 6]).plus_dyads(along * 0.5, a, a).plus_dyads(-(twice * I4) * 0.5, &c, &c);

        let c2 = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
        let gradient_squared = (Q * I4 * (I4 * c2 - Q) * 4.0).max(one.zero());
        let stretched = stretch * inv.max_C_inverse.sqrt();
        let curvature = Q * (stretched * stretched * 6.0 + stretched * 8.0 + 2.0);
        let of_f = chi * slope * (chi * (one / stretch + self.beta) + gradient_squared.sqrt() * 4.0);
        (f * chi * chi, S, of_f + f * (gradient_squared + chi * curvature) * 2.0)
    }
}

impl Law for PengGuoMoran {
    const NAME: &'static str = "Peng–Guo–Moran";
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
        let (psi, factor) = eval_first_invariant(self.c10, k);
        let (matrix, bound) = (k.dev_C.scaled(factor), bound_first_invariant(self.c10, k, inv));
        let zero = psi.zero();
        if fibres.is_empty() {
            let response = Response { psi, matrix, fibres: None };
            return BoundedResponse { response, stiffness_bound: bound, fibre_exponent: zero };
        }
        let invariant = FibreInvariant { kappa: 0.0, form: I4Form::Full };
        let mut terms = FibreTerms::new(invariant, psi, bound);
        let [c2, c3] = self.fibre;
        for a in fibres {
            let strain = invariant.strain(k, a);
            let E2 = strain.E * strain.E;
            let energy = FibreEnergy {
                W: E2 * E2.scale_add(c3, c2),
                dW: strain.E * E2.scale_add(4.0 * c3, 2.0 * c2),
                ddW: E2.scale_add(12.0 * c3, 2.0 * c2),
            };
            terms.add(k, inv, a, (strain, energy));
            terms.add_term(self.shear.term(k, inv, a));
        }
        terms.response(k, matrix, zero)
    }

    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }

    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (2.0 * self.c10, self.volumetric.bulk_modulus())
    }

    /// A strain ε along a family adds C2 (2 ε)²; its shear against the matrix is of the fourth order.
    fn fibre_modulus_at_rest(&self) -> f64 {
        8.0 * self.fibre[0] * self.families.directions().len() as f64
    }

    fn element_time(&self) -> ElementTime {
        ElementTime { family: [90.0, 70.0], ..ElementTime::NEO_HOOKEAN }
    }

    fn without_idle_fibres(self) -> Self {
        let idle = [self.fibre[0], self.fibre[1], self.shear.gamma].iter().all(|&c| c == 0.0);
        if idle { Self { families: FibreFamilies::NONE, ..self } } else { self }
    }

    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self {
            c10: self.c10 * factor,
            fibre: self.fibre.map(|c| c * factor),
            shear: FibreShear { gamma: self.shear.gamma * factor, ..self.shear },
            ..self
        })
    }
}
