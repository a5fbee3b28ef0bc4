//! Mooney–Rivlin rubber: linear in both isochoric invariants.

use super::isochoric::{
    bound_first_invariant, bound_second_invariant, eval_first_invariant, eval_second_invariant,
};
use super::validity::NEARLY_INCOMPRESSIBLE;
use super::{BoundedResponse, Deformations, ElementTime, Invariants, Kinematics, Law, Response, Volumetric};
use crate::real::Real;

/// ψ = C10 (Ī1 − 3) + C01 (Ī2 − 3) + U(J)      (Mooney 1940; Rivlin 1948; isochoric split)
///
/// Ī1 = J^(−2/3) I1, Ī2 = J^(−4/3) I2. Shear modulus at rest 2 (C10 + C01).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlin {
    /// C10 [Pa], ≥ 0.
    pub c10: f64,
    /// C01 [Pa], ≥ 0 (the stiffness bound needs both signs).
    pub c01: f64,
    /// The volumetric energy, with its bulk modulus K [Pa].
    pub volumetric: Volumetric,
}

impl Law for MooneyRivlin {
    const NAME: &'static str = "Mooney–Rivlin";
    const FITTED: Deformations = Deformations { stretch: [0.5, 2.0], jacobian: NEARLY_INCOMPRESSIBLE };
    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        _fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (psi1, first) = eval_first_invariant(self.c10, k);
        let (psi2, second) = eval_second_invariant(self.c01, k);
        let matrix = k.dev_C.scaled(first).plus_scaled(second, &k.dev_cof_C);
        BoundedResponse {
            response: Response { psi: psi1 + psi2, matrix, fibres: None },
            stiffness_bound: bound_first_invariant(self.c10, k, inv)
                + bound_second_invariant(self.c01, k, inv),
            fibre_exponent: k.J.zero(),
        }
    }
    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }
    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (2.0 * (self.c10 + self.c01), self.volumetric.bulk_modulus())
    }
    fn element_time(&self) -> ElementTime {
        ElementTime {
            mean_dilatation: [186.0, 246.0],
            full: [204.0, 274.0],
            reduced: [84.0, 156.0],
            ..ElementTime::NEO_HOOKEAN
        }
    }
    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        Some(Self { c10: self.c10 * factor, c01: self.c01 * factor, ..self })
    }
}
