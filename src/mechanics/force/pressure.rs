//! Pressure with bulk viscosity, and the stable step that stress and viscosity leave: what all formulations share.

use super::block::BlockParameters;
use crate::mechanics::material::{Invariants, Volumetric};
use crate::mechanics::real::Real;

/// The volumetric part of an element at one state.
#[derive(Clone, Copy)]
pub(super) struct Pressure<R> {
    /// p = U′ − q [Pa], positive in tension.
    pub p: R,
    /// U″ [Pa], not negative.
    pub stiffness: R,
}

#[inline(always)]
pub(super) fn pressure_at<R: Real>(U: Volumetric, j: R, viscous: R) -> Pressure<R> {
    Pressure { p: U.pressure(j) - viscous, stiffness: U.stiffness(j).max(j.zero()) }
}

/// (q, η/J̄): viscous pressure `q = ρ L |ε̇| (b1 c + b2² L |ε̇|)` in compression, zero else [Pa], and its slope against ε̇
/// [Pa s], with ε̇ the volumetric rate over the last step (Landshoff 1955; von Neumann & Richtmyer 1950).
///
/// `inverse_step` is the reciprocal of that step [1/s], `mean` J̄ − 1 now and `before` then [-].
#[inline(always)]
pub(super) fn viscous_pressure<R: Real>(
    p: &BlockParameters,
    inverse_step: f64,
    length: R,
    mean: R,
    before: R,
) -> (R, R) {
    let J = mean + 1.0;
    let rate = ((before - mean) * inverse_step / J).max(mean.zero());
    let density = J.constant(p.density) / J;
    let linear = p.linear_viscosity * p.wave_speed();
    let quadratic = p.quadratic_viscosity * p.quadratic_viscosity;
    let scaled_rate = length * rate * quadratic;
    let q = density * length * rate * (scaled_rate + linear);
    (q, density * length * (scaled_rate * 2.0 + linear) / J)
}

/// Upper bound of the tangent's norm at a point [Pa]: the law's, and the pressure of its element.
#[inline(always)]
pub(super) fn tangent_bound<R: Real>(bound: R, invariants: &Invariants<R>, pressure: &Pressure<R>) -> R {
    // |cof F|² = I2
    let bound = pressure.stiffness.mul_add(invariants.I2, bound);
    (pressure.p.abs() * 2.0).mul_add(invariants.max_C.sqrt(), bound)
}

/// h = (2/ω)(√(1 + ζ²) − ζ) with ω² and the viscous eigenvalue λ_C = 2 ζ ω; without overflow where ω = 0 (padding).
#[inline(always)]
pub(super) fn stable_step<R: Real>(omega_squared: R, viscous_eigenvalue: R) -> R {
    let half = viscous_eigenvalue * 0.5;
    let root = half.mul_add(half, omega_squared).sqrt();
    // 2 (√(ω² + a²) − a)/ω² = 2/(√(ω² + a²) + a)
    root.constant(2.0) / (root + half + 1e-30)
}
