//! Ogden rubber: powers of the principal stretches.

use super::logarithm::{Logarithm, Multiple};
use super::principal_strain::PrincipalStrain;
use super::validity::NEARLY_INCOMPRESSIBLE;
use super::{BoundedResponse, Deformations, ElementTime, Invariants, Kinematics, Law, Response, Volumetric};
use crate::real::Real;

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
/// The stress `Σ μ dev C̄^(½ α)` (Kirchhoff, in C's axes) is expressed by dev C and dev cof C as that of Mooney–Rivlin, see
/// `principal_strain.rs`, and for derivatives `logarithm.rs`: coinciding stretches are no special case.
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
}

/// Sums over the terms at the principal stretches, from the largest on.
struct Sums<R> {
    /// Strain energy ψ without U(J) [J/m³].
    psi: R,
    /// Σ μ λ̄^α [Pa], its differences as [`Power::differences`](super::principal_strain::Power::differences), and its mean m.
    powers: [R; 3],
    differences: [R; 2],
    mean: R,
    /// Σ μ α λ̄^α [Pa].
    slopes: [R; 3],
    /// Σ of the larger of μ (α − 1) λ̄^(α − 2) at the ends [Pa].
    turning: R,
}

impl<R: Real> Sums<R> {
    #[inline(always)]
    fn new(terms: &[OgdenTerm], strain: &PrincipalStrain<R>) -> Self {
        let zero = strain.logs[0].zero();
        let y2 = strain.reciprocals();
        let mut sums = Self {
            psi: zero,
            powers: [zero; 3],
            differences: [zero; 2],
            mean: zero,
            slopes: [zero; 3],
            turning: zero,
        };
        for term in terms {
            let power = strain.power(0.5 * term.alpha);
            sums.psi += power.excess * (term.mu / term.alpha);
            sums.mean += power.excess.scale_add(term.mu / 3.0, term.mu);
            for i in 0..2 {
                sums.differences[i] += power.differences[i] * term.mu;
            }
            for i in 0..3 {
                sums.powers[i] += power.of[i] * term.mu;
                sums.slopes[i] += power.of[i] * (term.mu * term.alpha);
            }
            let factor = term.mu * (term.alpha - 1.0);
            sums.turning += (power.of[0] * y2[0] * factor).max(power.of[2] * y2[2] * factor);
        }
        sums
    }
}

impl Ogden {
    /// ψ [J/m³], and the factors of dev C and dev cof C in the stress times J [Pa], with their derivatives.
    #[inline(always)]
    fn differentiable<R: Real>(&self, k: &Kinematics<R>, strain: &PrincipalStrain<R>) -> (R, (R, R)) {
        let log = Logarithm::new(k, strain);
        let zero = k.j.zero();
        let (mut psi, mut a, mut b) = (zero, zero, zero);
        for (term, half_power) in self.terms().iter().zip(&self.half_powers) {
            let (power, trace) = log.exponential(*half_power);
            psi += trace * (term.mu / term.alpha);
            a += power.a * term.mu;
            b += power.b * term.mu;
        }
        (psi, log.in_strain(k, a, b))
    }
}

/// A value with the derivative of another number.
#[inline(always)]
fn with_slope_of<R: Real>(value: R, smooth: R) -> R {
    value.detached() + (smooth - smooth.detached())
}

/// Bound [Pa] of the Hessian, from the mean m of `Σ μ λ̄^α`; 2 G at rest.
///
/// With τ = Σ μ λ̄^α − m the principal Kirchhoff stresses and n = Σ μ α λ̄^α, the 3×3 block in principal
/// stretches is `D (Q diag(n) Q − diag(τ)) D`, D = diag(1/λ), Q the isochoric projector: at most ⟨−τ/λ²⟩ plus the
/// lesser of the largest n/λ² and the trace. Rotation modes are means of `(n − τ)/λ²` between two stretches,
/// whose terms are largest at one of the ends, and `(τᵢ/λᵢ + τⱼ/λⱼ)/(λᵢ + λⱼ)`.
#[inline(always)]
fn bound<R: Real>(k: &Kinematics<R>, strain: &PrincipalStrain<R>, sums: &Sums<R>) -> R {
    let zero = k.j.zero();
    let m = sums.mean;
    let y2 = strain.reciprocals();
    // No closure: that would be compiled without the instruction set of the lanes.
    let tau = [sums.powers[0] - m, sums.powers[1] - m, sums.powers[2] - m];
    let (n, turning) = (sums.slopes, m.mul_add(y2[2], sums.turning));
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
        let strain = PrincipalStrain::new(k);
        let sums = Sums::new(self.terms(), &strain);
        let (mut psi, (mut first, mut second)) = (sums.psi, strain.in_strain(k, sums.differences));
        if R::HAS_SLOPE {
            let (smooth_psi, (smooth_first, smooth_second)) = self.differentiable(k, &strain);
            psi = with_slope_of(psi, smooth_psi);
            first = with_slope_of(first, smooth_first);
            second = with_slope_of(second, smooth_second);
        }
        let matrix = k.dev_C.scaled(first * k.J_inverse).plus_scaled(second * k.J_inverse, &k.dev_cof_C);
        BoundedResponse {
            response: Response { psi, matrix, fibres: None },
            stiffness_bound: bound(k, &strain, &sums),
            fibre_exponent: k.j.zero(),
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
        ElementTime::neo_hookean_and(20.0 + 4.0 * self.count as f64)
    }
    fn with_isochoric_scaled(mut self, factor: f64) -> Option<Self> {
        for term in &mut self.terms {
            term.mu *= factor;
        }
        Some(self)
    }
}
