//! Blatz–Ko foam rubber: a coupled law of highly compressible solids.

use super::isochoric::eval_second_invariant;
use super::{BoundedResponse, Deformations, ElementTime, Invariants, Kinematics, Law, Response, Volumetric};
use crate::real::Real;

/// ψ = μ/2 (I2/I3 + 2 √I3 − 5)      (Blatz & Ko 1962, the foamed rubber)
///
/// Coupled, with Poisson's ratio ¼ at rest: its bulk modulus is 5/3 μ. `C S/J = μ (I − C⁻¹/J)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlatzKo {
    /// Shear modulus μ [Pa], > 0.
    pub mu: f64,
}

impl Law for BlatzKo {
    const NAME: &'static str = "Blatz–Ko";
    const FITTED: Deformations = Deformations { stretch: [0.4, 2.0], jacobian: [0.4, 2.0] };

    /// With r = J^(−1/3) the energy is `μ/2 [r² (Ī2 − 3) + (r − 1)² (3r³ + 6r² + 4r + 2)/r³]`, accurate near rest.
    ///
    /// The bound is `μ (3 y⁴ + √(4/3 I1))`, y² the largest eigenvalue of C⁻¹; 5 μ at rest. In principal stretches tr C⁻¹ has the
    /// block `6 diag(y⁴)` and rotation modes up to `6 y⁴`, J a traceless block of norm² 2 I1, whose largest eigenvalue is at most
    /// √(2/3) of the norm, and rotation modes ±λ.
    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        _fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let (x2, _) = eval_second_invariant(0.5 * self.mu, k);
        let r = k.a + 1.0;
        let cubic = r.scale_add(3.0, 6.0).mul_add(r, r.constant(4.0)).mul_add(r, r.constant(2.0));
        let volume = k.a * k.a * cubic * k.J * (0.5 * self.mu);
        // I − C⁻¹/J = [(J³ − 1) − (mean cof C − 1)] I/J³ − dev cof C/J³
        let J3_m1 = k.j * (k.j * (k.j + 3.0) + 3.0);
        let factor = k.J_inverse * k.J_inverse * k.J_inverse * self.mu;
        let matrix = k.dev_cof_C.scaled(-factor).plus_diagonal((J3_m1 - k.mean_cof_C_m1()) * factor);
        let y2 = inv.max_C_inverse;
        BoundedResponse {
            response: Response { psi: (r * r).mul_add(x2, volume), matrix, fibres: None },
            stiffness_bound: (y2 * y2 * 3.0 + (inv.I1 * (4.0 / 3.0)).sqrt()) * self.mu,
            fibre_exponent: k.J.zero(),
        }
    }
    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        None
    }
    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        (self.mu, 5.0 / 3.0 * self.mu)
    }
    fn element_time(&self) -> ElementTime {
        ElementTime::neo_hookean_and(0.0)
    }
    fn with_isochoric_scaled(self, _factor: f64) -> Option<Self> {
        None
    }
}
