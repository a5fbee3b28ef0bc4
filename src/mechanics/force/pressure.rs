//! Pressure with bulk viscosity, and the critical time step that stress and viscosity leave: what all formulations share.

use super::parameters::BlockParameters;
use crate::lanes::{Lane, Row};
use crate::material::{Invariants, Volumetric};
use crate::real::Real;
use crate::registers::Registers;

/// The volumetric part of an element at one state.
#[derive(Clone, Copy)]
pub(super) struct Pressure<R> {
    /// p = U′ − q [Pa], positive in tension.
    pub p: R,
    /// U″ [Pa], not negative.
    pub stiffness: R,
}

/// Jacobian of a point below which the barrier acts [-].
const BARRIER_THRESHOLD: f64 = 0.2;

/// Stiffness of the barrier over μ [-].
const BARRIER_STIFFNESS: f64 = 20.0;

/// What keeps the points of an element of mean dilatation from turning inside out: the energy `½ k ln²(J/θ)` per volume where J < θ,
/// without bound as J → 0.
///
/// The element's pressure knows the mean of J alone, and the isochoric energy of a point grows like J^(−2/3) only.
#[derive(Clone, Copy, Debug)]
pub(super) struct Barrier {
    /// Modulus k of the barrier [Pa].
    stiffness: f64,
}

impl Barrier {
    /// Barrier of a law with the shear modulus μ at rest [Pa].
    pub fn new(mu: f64) -> Self {
        Self { stiffness: BARRIER_STIFFNESS * mu }
    }

    /// Whether a J − 1 is below the threshold.
    #[inline(always)]
    pub fn reaches(j: f64) -> bool {
        j < BARRIER_THRESHOLD - 1.0
    }

    /// ln(J/θ) where it is negative, else 0, at J − 1.
    #[inline(always)]
    fn log<R: Real>(j: R) -> R {
        j.scale_add(1.0 / BARRIER_THRESHOLD, 1.0 / BARRIER_THRESHOLD - 1.0).min(j.zero()).ln_1p()
    }

    /// Energy per volume [J/m³] at J − 1 > −1.
    #[inline(always)]
    pub fn energy<R: Real>(self, j: R) -> R {
        let log = Self::log(j);
        log * log * (0.5 * self.stiffness)
    }

    /// Its slope by J, positive in tension [Pa].
    #[inline(always)]
    pub fn pressure<R: Real>(self, j: R) -> R {
        Self::log(j) / (j + 1.0) * self.stiffness
    }

    /// Its second derivative [Pa].
    #[inline(always)]
    fn slope<R: Real>(self, j: R) -> R {
        let (log, J) = (Self::log(j), j + 1.0);
        let value = (log.constant(1.0) - log) / (J * J) * self.stiffness;
        (-log).select_positive(value, log.zero())
    }

    /// Adds it to the pressure of a point.
    #[inline(always)]
    pub fn add_to<R: Real>(self, j: R, pressure: &mut Pressure<R>) {
        pressure.p += self.pressure(j);
        pressure.stiffness += self.slope(j);
    }
}

/// Fraction of the mean J of an element, taken as 1 where it is less, above which all its points leave no corner below the threshold of the
/// penalty.
const LEAST_WITHOUT_FOLD: f64 = 0.9;

/// Whether a corner of an element of a register may be folding, from the least and the mean J − 1 of the points of each element: one that
/// expands may have a corner crushed, too.
#[inline(always)]
pub(super) fn corners_may_fold<S: Registers>(smallest: Lane<S>, mean: Lane<S>, part: usize) -> bool {
    let lanes = S::LANES;
    let mut excess = Row::default();
    (smallest - mean.max(mean.zero()) * LEAST_WITHOUT_FOLD).store(&mut excess, part);
    excess.0[part * lanes..(part + 1) * lanes].iter().any(|j| *j < LEAST_WITHOUT_FOLD - 1.0)
}

/// Whether a point of an element of a register is in reach of the barrier.
#[inline(always)]
pub(super) fn point_is_crushed<S: Registers>(smallest_j: &Row, part: usize) -> bool {
    let lanes = S::LANES;
    smallest_j.0[part * lanes..(part + 1) * lanes].iter().any(|j| Barrier::reaches(*j))
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
    if !p.has_bulk_viscosity() {
        return (mean.zero(), mean.zero());
    }
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
