//! The number type that constitutive laws and element kernels are generic over.
//!
//! A law is written once, over `R: Real`, and serves as plain `f64` (evaluation at a point), as SIMD lanes (the
//! internal force evaluation) and as a dual number (the exact tangent). So there is no second copy of any formula.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number, several in SIMD lanes, or one with its derivative.
///
/// Comparisons are by [`Real::select_positive`], never by `if`, because lanes may differ.
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
    /// Whether it carries a derivative.
    const HAS_SLOPE: bool = false;

    /// The constant `c` in the same lanes as `self`.
    #[must_use]
    fn constant(self, c: f64) -> Self;
    /// `self * b + c`, fused where the machine supports it.
    #[must_use]
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// Square root, `√self`, for `self ≥ 0`.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Exponential function `exp(self)`, lane by lane.
    #[must_use]
    fn exp(self) -> Self;
    /// `exp(self) − 1`, accurate near 0.
    #[must_use]
    fn exp_m1(self) -> Self;
    /// `exp(self) − 1`, and how much that exceeds `self`, both accurate near 0.
    #[must_use]
    fn exp_m1_and_defect(self) -> (Self, Self);
    /// `ln(1 + self)`, accurate near 0.
    #[must_use]
    fn ln_1p(self) -> Self;
    /// `ln(self)`, of a positive normal number.
    #[must_use]
    fn ln(self) -> Self;
    /// The larger of two numbers, lane by lane.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// The smaller of two numbers, lane by lane.
    #[must_use]
    fn min(self, other: Self) -> Self;
    /// Absolute value, `|self|`, lane by lane.
    #[must_use]
    fn abs(self) -> Self;
    /// `if self > 0 { yes } else { no }`, lane by lane.
    #[must_use]
    fn select_positive(self, yes: Self, no: Self) -> Self;
    /// Approximate `(1 + self)^(−1/3)` (within 5 %), the initial guess of [`inverse_cbrt_m1`].
    #[must_use]
    fn seed_inverse_cbrt_1p(self) -> Self;
    /// Runs what is large beside the cost of a call as a function that the program has once for this kind of number, with its
    /// instruction set.
    fn outlined<Op: Outlined>(self, op: Op) -> Op::Output;
    /// The same value as a constant, for formulas in which value and derivative are computed separately.
    #[must_use]
    #[inline(always)]
    fn detached(self) -> Self {
        self
    }

    /// `self * b − c`, fused where the machine supports it.
    #[must_use]
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self.mul_add(b, -c)
    }
    /// `self * b + c` with constants.
    #[must_use]
    #[inline(always)]
    fn scale_add(self, b: f64, c: f64) -> Self {
        self.mul_add(self.constant(b), self.constant(c))
    }
    /// Zero in the same lanes as `self`.
    #[must_use]
    #[inline(always)]
    fn zero(self) -> Self {
        self.constant(0.0)
    }
}

/// What [`Real::outlined`] runs: a closure would be compiled without the instruction set of lanes.
pub trait Outlined {
    /// Type of the result.
    type Output;
    /// Computes it; must be `#[inline(always)]`, else it is compiled without the instruction set.
    fn run(self) -> Self::Output;
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
    fn exp_m1_and_defect(self) -> (Self, Self) {
        let e = f64::exp_m1(self);
        // x²/2 + x³/6 + … where e − x would lose digits.
        let series = (2..=14).rev().fold(0.0, |sum, n| (sum + 1.0) * self / f64::from(n)) * self;
        (e, if f64::abs(self) < 0.35 { series } else { e - self })
    }
    #[inline(always)]
    fn ln_1p(self) -> Self {
        f64::ln_1p(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        f64::ln(self)
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
    #[inline(never)]
    fn outlined<Op: Outlined>(self, op: Op) -> Op::Output {
        op.run()
    }
}

/// `(1 + j)^(−1/3) − 1` to full *relative* accuracy also for tiny `j`, and exactly 0 at `j = 0`; `j > −1`.
///
/// First y = J^(−1/3): from an initial guess within 5 %, two steps `y ← y (1 + r)^(−1/3)` with `r = J y³ − 1` and the
/// power expanded to r⁴ (order 5, no division), which leaves only rounding. Then `J (y³ − 1) = −j` is solved for y −
/// 1. Iterating on y − 1 itself would leave the last error of the iteration at j = 0 instead of 0.
#[inline(always)]
pub fn inverse_cbrt_m1<R: Real>(j: R) -> R {
    let J = j + 1.0;
    let mut y = j.seed_inverse_cbrt_1p();
    for _ in 0..2 {
        let r = (J * (y * y)).mul_sub(y, j.constant(1.0));
        // (1 + r)^(−1/3) − 1 = −r/3 + 2 r²/9 − 14 r³/81 + 35 r⁴/243 − …
        let series = r.scale_add(35.0 / 243.0, -14.0 / 81.0).mul_add(r, j.constant(2.0 / 9.0));
        let series = series.mul_add(r, j.constant(-1.0 / 3.0)) * r;
        y = y.mul_add(series, y);
    }
    let one = j.constant(1.0);
    -j / (J * (y + 1.0).mul_add(y, one))
}

/// `x − ln(1 + x)` to nearly full relative accuracy also for tiny `x`; `x > −1`.
///
/// For |x| < 0.1 from `ln(1 + x) = 2 artanh u`, u = x/(2 + x), whose first term is subtracted analytically; the plain
/// difference would keep only the digits of x² that remain beside x.
#[inline(always)]
pub fn ln_1p_defect<R: Real>(x: R) -> R {
    let u = x / (x + 2.0);
    let v = u * u;
    let mut tail = v.constant(1.0 / 13.0);
    // A loop, not a fold: a closure would be compiled without the instruction set of the lanes.
    for c in [1.0 / 11.0, 1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0] {
        tail = tail.mul_add(v, v.constant(c));
    }
    let near_zero = u * (x - v * tail * 2.0);
    (x.abs() - 0.1).select_positive(x - x.ln_1p(), near_zero)
}

/// `J^(−1/3)` within 4 % for a positive, normal `J`, by dividing its exponent (and mantissa) by −3.
///
/// The upper half of the bits suffices, and a third of it is a 32-bit product, which every instruction set has for
/// lanes; a 64-bit division would be done lane by lane.
#[inline(always)]
pub fn seed_inverse_cbrt(J: f64) -> f64 {
    let third = ((J.to_bits() >> 32) * 0x5555_5556) & 0xffff_ffff_0000_0000;
    f64::from_bits(0x553e_f0ff_289d_d796_u64.wrapping_sub(third))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seed_of_the_inverse_cube_root_is_within_five_percent() {
        for i in -4000..4000 {
            let J = f64::exp(f64::from(i) * 0.01);
            let relative = seed_inverse_cbrt(J) * J.cbrt() - 1.0;
            assert!(relative.abs() < 0.05, "J = {J}: {relative}");
        }
    }

    #[test]
    #[allow(clippy::float_cmp)] // exact equality is intended
    fn inverse_cube_root_is_exactly_one_at_rest() {
        assert!(inverse_cbrt_m1(0.0) == 0.0);
    }

    #[test]
    fn ln_1p_defect_keeps_relative_accuracy_down_to_rest() {
        // x²/2 − x³/3 + x⁴/4 − … summed for tiny x, the plain difference for large x.
        for x in [1e-150, 1e-9, -1e-6, 3e-4, -2e-3] {
            let series: f64 = (2..12).rev().map(|n| f64::powi(-x, n) / f64::from(n)).sum();
            let got = ln_1p_defect(x);
            assert!((got - series).abs() <= 8.0 * f64::EPSILON * series, "x = {x}: {got} against {series}");
        }
        for x in [0.05, -0.0999, 0.0999, 0.11, -0.11, 0.7, -0.9, 30.0] {
            let plain = x - f64::ln_1p(x);
            assert!((ln_1p_defect(x) - plain).abs() <= 1e-14 * plain.max(x.abs()), "x = {x}");
        }
        assert!(ln_1p_defect(0.0) == 0.0);
    }

    #[test]
    fn the_defect_of_exp_keeps_relative_accuracy_down_to_rest() {
        // cosh x − 1 = 2 sinh² ½x and sinh x − x, of which the defect is the sum: no cancellation for x > 0.
        for x in [1e-100, 1e-20, 1e-9, 3e-5, 0.01, 0.3, 0.349, 0.351, 1.0, 5.0] {
            let odd: f64 = (1..16).rev().fold(0.0, |sum, n| {
                let (a, b) = (2.0 * f64::from(n), 2.0 * f64::from(n) + 1.0);
                (sum + 1.0) * x * x / (a * b)
            }) * x;
            let exact = 2.0 * f64::sinh(0.5 * x).powi(2) + odd;
            let (e, defect) = x.exp_m1_and_defect();
            assert!(
                (defect - exact).abs() <= 8.0 * f64::EPSILON * exact,
                "x = {x}: {defect} against {exact}"
            );
            assert!((e - f64::exp_m1(x)).abs() == 0.0);
            // e^−x − 1 + x
            let exact = 2.0 * f64::sinh(0.5 * x).powi(2) - odd;
            let defect = (-x).exp_m1_and_defect().1;
            assert!(
                (defect - exact).abs() <= 24.0 * f64::EPSILON * exact.max(odd),
                "x = −{x}: {defect} {exact}"
            );
        }
    }

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
