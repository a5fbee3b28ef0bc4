//! The number that a constitutive law or an element kernel is written for.
//!
//! A law is written once, over `R: Real`, and serves as plain `f64` (evaluation at a point), as SIMD lanes (the
//! force sweep) and as a dual number (the exact tangent). So there is no second copy of any formula.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number, or several at once in SIMD lanes, or one with its derivative.
///
/// Comparisons are by [`Real::select_positive`], never by `if`, because each lane may go its own way.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + SubAssign
{
    /// The constant `c` in the same lanes as `self`.
    fn constant(self, c: f64) -> Self;
    /// `self * b + c`, fused where the machine can.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `√self`.
    fn sqrt(self) -> Self;
    /// `exp(self)`.
    fn exp(self) -> Self;
    /// `exp(self) − 1`, accurate near 0.
    fn exp_m1(self) -> Self;
    /// `ln(1 + self)`, accurate near 0.
    fn ln_1p(self) -> Self;
    /// The larger of two.
    fn max(self, other: Self) -> Self;
    /// The smaller of two.
    fn min(self, other: Self) -> Self;
    /// `|self|`.
    fn abs(self) -> Self;
    /// `if self > 0 { yes } else { no }`, lane by lane.
    fn select_positive(self, yes: Self, no: Self) -> Self;
    /// A rough `(1 + self)^(−1/3)` (within 5 %), the seed of [`inverse_cbrt_m1`].
    fn seed_inverse_cbrt_1p(self) -> Self;

    /// Zero in the same lanes as `self`.
    #[inline(always)]
    fn zero(self) -> Self {
        self.constant(0.0)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn constant(self, c: f64) -> Self {
        c
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        f64::exp_m1(self)
    }
    #[inline(always)]
    fn ln_1p(self) -> Self {
        f64::ln_1p(self)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn select_positive(self, yes: Self, no: Self) -> Self {
        if self > 0.0 { yes } else { no }
    }
    #[inline(always)]
    fn seed_inverse_cbrt_1p(self) -> Self {
        seed_inverse_cbrt(1.0 + self)
    }
}

/// `(1 + j)^(−1/3) − 1` to full *relative* accuracy also for tiny `j`; `j > −1`.
///
/// Halley's iteration on `ρ(δ) = (1+j)(1+δ)³ − 1 = j + (1+j) δ (3 + 3δ + δ²)`, in which nothing cancels when
/// j and δ are small, so that `J^(−2/3) − 1` is exactly 0 at rest.
#[inline(always)]
pub fn inverse_cbrt_m1<R: Real>(j: R) -> R {
    let J = j + 1.0;
    let mut delta = j.seed_inverse_cbrt_1p() - 1.0;
    for _ in 0..3 {
        let residual = j + J * delta * ((delta + 3.0) * delta + 3.0);
        // Halley for y⁻³ = J in the variable δ = y − 1, with J y³ = 1 + residual:
        // y ← y (1 − residual · 1 / (3 + 2 residual)).
        delta = delta - (delta + 1.0) * residual / (residual * 2.0 + 3.0);
    }
    delta
}

/// `J^(−1/3)` within 4 % for a positive, normal `J`, by dividing its exponent (and mantissa) by −3.
#[inline(always)]
pub fn seed_inverse_cbrt(J: f64) -> f64 {
    f64::from_bits(0x553e_f0ff_289d_d796_u64.wrapping_sub(J.to_bits() / 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_cube_root_keeps_relative_accuracy_down_to_rest() {
        for j in [0.0, 1e-300, 1e-18, -1e-12, 1e-6, -0.3, 0.5, -0.99, 20.0, 1e3] {
            let expected = f64::exp_m1(-f64::ln_1p(j) / 3.0);
            let got = inverse_cbrt_m1(j);
            assert!(
                (got - expected).abs() <= 8.0 * f64::EPSILON * expected.abs(),
                "j = {j}: {got} against {expected}"
            );
        }
    }
}
