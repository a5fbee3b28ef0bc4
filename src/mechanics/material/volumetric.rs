//! The volumetric energy U(J) of a split law.

use crate::real::{Real, ln_1p_defect};

/// Bulk modulus of water, and about that of soft tissue and rubber [Pa].
pub const BULK_MODULUS_OF_WATER: f64 = 2.2e9;
/// K/G from which on a solid is meant to keep its volume [-], as foam is not: Poisson's ratio is 0.4.
pub(super) const KEEPS_ITS_VOLUME: f64 = 5.0;

/// U(J) with its bulk modulus K [Pa]; all three have U″(1) = K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Volumetric {
    /// U = K/2 (ln J)². Softens in tension; U′ falls beyond J = e. The default.
    LnSquared(f64),
    /// U = K/2 (J − 1)². Allows J → 0 at finite energy.
    Quadratic(f64),
    /// U = K/4 (J² − 1 − 2 ln J). Infinite at J → 0 and at J → ∞.
    QuadraticLn(f64),
}

impl Volumetric {
    /// Bulk modulus K at rest [Pa].
    pub fn bulk_modulus(&self) -> f64 {
        match *self {
            Self::LnSquared(K) | Self::Quadratic(K) | Self::QuadraticLn(K) => K,
        }
    }
    /// U [J/m³] at `j = J − 1`.
    #[inline(always)]
    pub fn energy<R: Real>(&self, j: R) -> R {
        match *self {
            Self::LnSquared(K) => {
                let l = j.ln_1p();
                l * l * (0.5 * K)
            }
            Self::Quadratic(K) => j * j * (0.5 * K),
            // J² − 1 − 2 ln J = j² + 2 (j − ln(1 + j))
            Self::QuadraticLn(K) => (j * j + ln_1p_defect(j) * 2.0) * (0.25 * K),
        }
    }
    /// p = U′(J) [Pa], positive in tension, at `j = J − 1`.
    #[inline(always)]
    pub fn pressure<R: Real>(&self, j: R) -> R {
        match *self {
            Self::LnSquared(K) => j.ln_1p() / (j + 1.0) * K,
            Self::Quadratic(K) => j * K,
            Self::QuadraticLn(K) => j * (j + 2.0) / (j + 1.0) * (0.5 * K),
        }
    }
    /// U″(J) [Pa] at `j = J − 1`; negative where `LnSquared` softens (J > e).
    #[inline(always)]
    pub fn stiffness<R: Real>(&self, j: R) -> R {
        let J = j + 1.0;
        match *self {
            Self::LnSquared(K) => (J.constant(1.0) - j.ln_1p()) / (J * J) * K,
            Self::Quadratic(K) => J.constant(K),
            Self::QuadraticLn(K) => (J.constant(1.0) / (J * J) + 1.0) * (0.5 * K),
        }
    }
}
