//! Polyconvex tissue after Schröder, Neff & Balzani: fibres by a power of the stretch of their surroundings.

use super::isochoric::{bound_first_invariant, eval_first_invariant};
use super::validity::TISSUE;
use super::{
    BoundedResponse, Deformations, ElementTime, FibreFamilies, Invariants, Kinematics, Law, Response,
    Volumetric,
};
use crate::real::Real;
use crate::tensor::Sym;

/// ψ = c1 (Ī1 − 3) + Σ_a α1 ⟨I1 I4a − I5a − 2⟩^α2 + U(J)
///
/// (Schröder, Neff & Balzani 2005; Balzani, Neff, Schröder & Holzapfel 2006.) `I1 I4 − I5 = tr[cof C (I − a⊗a)]` is
/// the sum of the squared stretches of two faces that contain the fibre. With α2 > 2 the tangent is continuous where
/// a family becomes active.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balzani {
    /// c1 [Pa], > 0.
    pub c1: f64,
    /// α1 [Pa], ≥ 0.
    pub alpha1: f64,
    /// α2 [-], > 2.
    pub alpha2: f64,
    /// Fibre families, at most [`super::MAX_FAMILIES`].
    pub families: FibreFamilies,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for Balzani {
    const NAME: &'static str = "Balzani";
    const FITTED: Deformations = TISSUE;

    #[inline(always)]
    fn fibre_directions(&self) -> &[[f64; 3]] {
        self.families.directions()
    }

    /// With x = I1 I4 − I5 − 2, S = 2 W′ M, M = ∂x/∂C = I1 a⊗a + I4 I − (a⊗C a + C a⊗a).
    ///
    /// The bound of a family is `W″ 4 x² |M|² + 12 W′ x²`, x² here the largest eigenvalue of C: `|2 F M|² ≤ 4 x²
    /// |M|²`, and with the sides u, v, w of the faces the second derivative of `|u×v|² + |w×u|²` is at most `2 (2 u²
    /// + v² + w² + |u×v| + |w×u|)`.
    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (mut psi, factor) = eval_first_invariant(self.c1, k);
        let mut bound = bound_first_invariant(self.c1, k, inv);
        let zero = psi.zero();
        let mut S = Sym([zero; 6]);
        let C = k.C_minus_I.plus_diagonal(zero.constant(1.0));
        // Each family with its invariant x, energy W(x) and derivatives.
        for a in fibres {
            let x = k.mean_cof_C_m1() * 2.0 - k.dev_cof_C.quadratic_form(a);
            // x^(α2 − 2), 0 where the family is inactive
            let on = x.max(x.constant(f64::MIN_POSITIVE));
            let power = x.select_positive((on.ln() * (self.alpha2 - 2.0)).exp(), zero);
            let ddW = power * (self.alpha1 * self.alpha2 * (self.alpha2 - 1.0));
            let dW = power * on * (self.alpha1 * self.alpha2);
            psi += power * on * on * self.alpha1;
            let Ca = C.apply(a);
            let I4 = C.quadratic_form(a);
            let M = Sym([zero; 6]).plus_dyads(inv.I1 * 0.5, a, a).plus_diagonal(I4).plus_dyads(
                -I4.constant(1.0),
                a,
                &Ca,
            );
            S = S.plus_scaled(dW * 2.0, &M);
            bound += (ddW * M.norm_squared()).mul_add(zero.constant(4.0), dW * 12.0) * inv.max_C;
        }
        let fibres = (!fibres.is_empty()).then_some(S);
        BoundedResponse {
            response: Response { psi, matrix: k.dev_C.scaled(factor), fibres },
            stiffness_bound: bound,
            fibre_exponent: zero,
        }
    }

    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }

    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (2.0 * self.c1, self.volumetric.bulk_modulus())
    }

    fn element_time(&self) -> ElementTime {
        ElementTime { family: [60.0, 40.0], ..ElementTime::NEO_HOOKEAN }
    }

    fn without_idle_fibres(self) -> Self {
        if self.alpha1 == 0.0 { Self { families: FibreFamilies::NONE, ..self } } else { self }
    }

    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self { c1: self.c1 * factor, alpha1: self.alpha1 * factor, ..self })
    }
}
