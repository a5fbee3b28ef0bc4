//! The exponential of stiffening laws, continued before it overflows.

use crate::real::Real;

/// The largest exponent [-] up to which a law is its exponential.
///
/// Beyond it the energy continues linearly in the exponent (with continuous stress): no lane can overflow. e²⁰⁰ ≈
/// 7·10⁸⁶ is far beyond any tissue: a point that gets there has failed, as [`super::BoundedResponse::fibre_exponent`]
/// shows.
pub const FIBRE_EXPONENT_LIMIT: f64 = 200.0;

/// The continued exponential at an exponent q.
#[derive(Clone, Copy)]
pub(super) struct BoundedExponential<R> {
    /// The exponent q, at most the limit.
    pub exponent: R,
    /// exp(q) − 1, linear beyond the limit.
    pub minus_one: R,
    /// Its derivative, exp(q) up to the limit; no less than its second derivative.
    pub slope: R,
}

impl<R: Real> BoundedExponential<R> {
    /// At an exponent `q` [-].
    #[inline(always)]
    pub fn new(q: R) -> Self {
        let exponent = q.min(q.constant(FIBRE_EXPONENT_LIMIT));
        let e_m1 = exponent.exp_m1();
        let slope = e_m1 + 1.0;
        Self { exponent, minus_one: slope.mul_add(q - exponent, e_m1), slope }
    }
}
