//! Isotropic exponential tissue: Demiray's law of the first invariant, Veronda–Westmann's of both.

use super::exponential::BoundedExponential;
use super::isochoric::{
    bound_first_less_second, bound_function_of_first, eval_first_invariant, eval_second_invariant,
};
use super::validity::TISSUE;
use super::{BoundedResponse, Deformations, ElementTime, Invariants, Kinematics, Law, Response, Volumetric};
use crate::real::Real;

/// ψ = μ/(2b) (exp[b (Ī1 − 3)] − 1) + U(J)      (Demiray 1972)
///
/// Shear modulus at rest μ. Skin, fat and other tissue without a preferred direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demiray {
    /// μ [Pa], > 0.
    pub mu: f64,
    /// Exponent b [-], > 0.
    pub b: f64,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for Demiray {
    const NAME: &'static str = "Demiray";
    const FITTED: Deformations = TISSUE;

    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        _fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (x, factor) = eval_first_invariant(1.0, k);
        let q = x * self.b;
        let e = BoundedExponential::new(q);
        let slope = e.slope * (0.5 * self.mu);
        let psi = e.minus_one * (0.5 * self.mu / self.b);
        BoundedResponse {
            response: Response { psi, matrix: k.dev_C.scaled(slope * factor), fibres: None },
            stiffness_bound: bound_function_of_first(slope, slope * self.b, k, inv),
            fibre_exponent: q,
        }
    }
    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }
    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (self.mu, self.volumetric.bulk_modulus())
    }
    fn element_time(&self) -> ElementTime {
        ElementTime::neo_hookean_and(3.0)
    }
    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self { mu: self.mu * factor, ..self })
    }
}

/// ψ = C1 (exp[C2 (Ī1 − 3)] − 1) − C1 C2/2 (Ī2 − 3) + U(J)      (Veronda & Westmann 1970)
///
/// Shear modulus at rest C1 C2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerondaWestmann {
    /// C1 [Pa], > 0.
    pub c1: f64,
    /// C2 [-], > 0.
    pub c2: f64,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for VerondaWestmann {
    const NAME: &'static str = "Veronda–Westmann";
    const FITTED: Deformations = TISSUE;

    /// For the bound the energy is decomposed as `C1 (e^(C2 x) − 1 − C2 x) + C1 C2 (x − ½ (Ī2 − 3))`, x = Ī1 − 3:
    /// exact at rest.
    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        _fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let c12 = self.c1 * self.c2;
        let (x, first) = eval_first_invariant(1.0, k);
        let (psi2, second) = eval_second_invariant(-0.5 * c12, k);
        let q = x * self.c2;
        let e = BoundedExponential::new(q);
        let slope = e.slope * c12;
        let stiffening = bound_function_of_first(slope - c12, slope * self.c2, k, inv);
        BoundedResponse {
            response: Response {
                psi: e.minus_one * self.c1 + psi2,
                matrix: k.dev_C.scaled(slope * first).plus_scaled(second, &k.dev_cof_C),
                fibres: None,
            },
            stiffness_bound: bound_first_less_second(k, inv) * c12 + stiffening,
            fibre_exponent: q,
        }
    }
    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }
    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (self.c1 * self.c2, self.volumetric.bulk_modulus())
    }
    fn element_time(&self) -> ElementTime {
        ElementTime::neo_hookean_and(7.0)
    }
    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self { c1: self.c1 * factor, ..self })
    }
}
