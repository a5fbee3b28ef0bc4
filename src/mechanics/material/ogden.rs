//! Ogden rubber: powers of the principal stretches.

use super::logarithm::{Logarithm, Multiple};
use super::validity::NEARLY_INCOMPRESSIBLE;
use super::{BoundedResponse, Deformations, ElementTime, Invariants, Kinematics, Law, Response, Volumetric};
use crate::mechanics::real::Real;

/// Largest number of terms of an Ogden law.
pub const MAX_OGDEN_TERMS: usize = 6;

/// One term of an Ogden law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OgdenTerm {
    /// μ [Pa], of the same sign as α.
    pub mu: f64,
    /// α [-], not 0.
    pub alpha: f64,
}

/// ψ = Σ_p μ_p/α_p (λ̄1^α_p + λ̄2^α_p + λ̄3^α_p − 3) + U(J)      (Ogden 1972), λ̄ = J^(−1/3) λ
///
/// Shear modulus at rest ½ Σ μ_p α_p. FEBio's constants c_p, m_p are α_p = m_p, μ_p = c_p/m_p.
///
/// With L = ln C̄ the sum of powers is tr exp(½ α L), and the stress `Σ μ dev exp(½ α L)` (Kirchhoff, in C's axes) is
/// expressed by dev C and dev cof C as that of Mooney–Rivlin, see `logarithm.rs`: coinciding stretches are no
/// special case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ogden {
    terms: [OgdenTerm; MAX_OGDEN_TERMS],
    /// The multiple ½ α of L in each term.
    half_powers: [Multiple; MAX_OGDEN_TERMS],
    count: usize,
    volumetric: Volumetric,
}

impl Ogden {
    /// With up to [`MAX_OGDEN_TERMS`] terms, else `None`.
    pub fn new(terms: &[OgdenTerm], volumetric: Volumetric) -> Option<Self> {
        let mut all = [OgdenTerm::default(); MAX_OGDEN_TERMS];
        all.get_mut(..terms.len())?.copy_from_slice(terms);
        let half_powers = all.map(|term| Multiple::new(0.5 * term.alpha));
        Some(Self { terms: all, half_powers, count: terms.len(), volumetric })
    }
    /// Terms of the law, at most [`MAX_OGDEN_TERMS`].
    #[inline(always)]
    pub fn terms(&self) -> &[OgdenTerm] {
        &self.terms[..self.count]
    }

    /// Bound [Pa] of the Hessian, from the mean m of `Σ μ λ̄^α`; 2 G at rest.
    ///
    /// With τ = Σ μ λ̄^α − m the principal Kirchhoff stresses and n = Σ μ α λ̄^α, the 3×3 block in principal
    /// stretches is `D (Q diag(n) Q − diag(τ)) D`, D = diag(1/λ), Q the isochoric projector: at most ⟨−τ/λ²⟩ plus the
    /// lesser of the largest n/λ² and the trace. Rotation modes are means of `(n − τ)/λ²` between two stretches,
    /// whose terms are largest at one of the ends, and `(τᵢ/λᵢ + τⱼ/λⱼ)/(λᵢ + λⱼ)`.
    #[inline(always)]
    fn bound<R: Real>(&self, k: &Kinematics<R>, log: &Logarithm<R>, m: R) -> R {
        let zero = m.zero();
        let [most, least] = log.extremes;
        let logs = [most, -(most + least), least];
        let y2 = [(-logs[0]).exp(), (-logs[1]).exp(), (-logs[2]).exp()];
        let (mut tau, mut n, mut turning) = ([-m; 3], [zero; 3], m * y2[2]);
        for term in self.terms() {
            let mut power = [zero; 3];
            for i in 0..3 {
                power[i] = (logs[i] * (0.5 * term.alpha)).exp() * term.mu;
                tau[i] += power[i];
                n[i] += power[i] * term.alpha;
            }
            turning += (power[0] * y2[0] * (term.alpha - 1.0)).max(power[2] * y2[2] * (term.alpha - 1.0));
        }
        let (mut pressed, mut pulled, mut largest, mut trace) = (zero, zero, zero, zero);
        let sum = n[0].max(zero) + n[1].max(zero) + n[2].max(zero);
        for i in 0..3 {
            pressed = pressed.max(-(tau[i] * y2[i]));
            pulled += (tau[i] * y2[i]).max(zero);
            largest = largest.max(n[i]);
            trace += y2[i] * (n[i].max(zero) * (1.0 / 3.0) + sum * (1.0 / 9.0));
        }
        let block = (largest * y2[2]).min(trace) + pressed;
        block.max(turning).max(pulled) * (k.j23_m1() + 1.0)
    }
}

impl Law for Ogden {
    const NAME: &'static str = "Ogden";
    const FITTED: Deformations = Deformations { stretch: [0.5, 2.5], jacobian: NEARLY_INCOMPRESSIBLE };

    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        _inv: &Invariants<R>,
        _fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        let log = Logarithm::new(k);
        let zero = k.j.zero();
        let (mut psi, mut a, mut b, mut mean) = (zero, zero, zero, zero);
        for (term, half_power) in self.terms().iter().zip(&self.half_powers) {
            let (power, trace) = log.exponential(*half_power);
            psi += trace * (term.mu / term.alpha);
            a += power.a * term.mu;
            b += power.b * term.mu;
            mean += trace.scale_add(term.mu / 3.0, term.mu);
        }
        let (first, second) = log.in_strain(k, a, b);
        let matrix = k.dev_C.scaled(first * k.J_inverse).plus_scaled(second * k.J_inverse, &k.dev_cof_C);
        BoundedResponse {
            response: Response { psi, matrix, fibres: None },
            stiffness_bound: self.bound(k, &log, mean),
            fibre_exponent: zero,
        }
    }
    #[inline(always)]
    fn volumetric(&self) -> Option<Volumetric> {
        Some(self.volumetric)
    }
    #[inline(always)]
    fn moduli_at_rest(&self) -> (f64, f64) {
        let G = self.terms().iter().map(|term| 0.5 * term.mu * term.alpha).sum();
        (G, self.volumetric.bulk_modulus())
    }
    fn element_time(&self) -> ElementTime {
        ElementTime::neo_hookean_and(35.0 + 15.0 * self.count as f64)
    }
    fn with_isochoric_scaled(mut self, factor: f64) -> Option<Self> {
        for term in &mut self.terms {
            term.mu *= factor;
        }
        Some(self)
    }
}
