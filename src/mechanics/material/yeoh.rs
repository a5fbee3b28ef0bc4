//! Yeoh rubber: a polynomial in the first invariant.

use super::isochoric::{bound_function_of_first, eval_first_invariant};
use super::validity::NEARLY_INCOMPRESSIBLE;
use super::{BoundedResponse, Deformations, ElementTime, Invariants, Kinematics, Law, Response, Volumetric};
use crate::real::Real;

/// ψ = C10 (Ī1 − 3) + C20 (Ī1 − 3)² + C30 (Ī1 − 3)³ + U(J)      (Yeoh 1993)
///
/// Shear modulus at rest 2 C10. A negative C20 softens at moderate stretches, which filled rubber does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yeoh {
    /// C10 [Pa], > 0.
    pub c10: f64,
    /// C20 [Pa], of either sign.
    pub c20: f64,
    /// C30 [Pa], ≥ 0.
    pub c30: f64,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for Yeoh {
    const NAME: &'static str = "Yeoh";
    const FITTED: Deformations = Deformations { stretch: [0.5, 2.5], jacobian: NEARLY_INCOMPRESSIBLE };

    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        _fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (x, factor) = eval_first_invariant(1.0, k);
        let psi = x.scale_add(self.c30, self.c20).mul_add(x, x.constant(self.c10)) * x;
        let slope = x.scale_add(3.0 * self.c30, 2.0 * self.c20).mul_add(x, x.constant(self.c10));
        let curvature = x.scale_add(6.0 * self.c30, 2.0 * self.c20);
        BoundedResponse {
            response: Response { psi, matrix: k.dev_C.scaled(slope * factor), fibres: None },
            stiffness_bound: bound_function_of_first(slope, curvature, k, inv),
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
    fn element_time(&self) -> ElementTime {
        ElementTime::neo_hookean_and(1.0)
    }
    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self { c10: self.c10 * factor, c20: self.c20 * factor, c30: self.c30 * factor, ..self })
    }
}
