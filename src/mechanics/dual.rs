//! Dual numbers `value + ε slope`, ε² = 0: the exact derivative of any law along one direction.
//!
//! They give `A : dF = dP/dε` of `P(F + ε dF)`, exact to rounding, without a second copy of the law.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register. Laws are called
// (`Real::outlined`), which are large beside that cost.

use super::real::{Outlined, Real};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A value and its derivative along the direction of differentiation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<R> {
    /// Value at the point of differentiation.
    pub value: R,
    /// Derivative along the direction.
    pub slope: R,
}

impl<R: Real> Add for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { value: self.value + o.value, slope: self.slope + o.slope }
    }
}
impl<R: Real> Sub for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { value: self.value - o.value, slope: self.slope - o.slope }
    }
}
impl<R: Real> Mul for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self { value: self.value * o.value, slope: self.slope.mul_add(o.value, self.value * o.slope) }
    }
}
impl<R: Real> Div for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        Self { value, slope: (self.slope - value * o.slope) / o.value }
    }
}
impl<R: Real> Neg for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, slope: -self.slope }
    }
}
impl<R: Real> Add<f64> for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, c: f64) -> Self {
        Self { value: self.value + c, slope: self.slope }
    }
}
impl<R: Real> Sub<f64> for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, c: f64) -> Self {
        Self { value: self.value - c, slope: self.slope }
    }
}
impl<R: Real> Mul<f64> for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, c: f64) -> Self {
        Self { value: self.value * c, slope: self.slope * c }
    }
}
impl<R: Real> AddAssign for Dual<R> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<R: Real> SubAssign for Dual<R> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<R: Real> Real for Dual<R> {
    const HAS_SLOPE: bool = true;

    #[inline(always)]
    fn constant(self, c: f64) -> Self {
        Self { value: self.value.constant(c), slope: self.value.zero() }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        Self { value: root, slope: self.slope / (root + root) }
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = self.value.exp();
        Self { value: e, slope: self.slope * e }
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        let e = self.value.exp_m1();
        Self { value: e, slope: self.slope * (e + 1.0) }
    }
    #[inline(always)]
    fn exp_m1_and_defect(self) -> (Self, Self) {
        let (e, defect) = self.value.exp_m1_and_defect();
        (Self { value: e, slope: self.slope * (e + 1.0) }, Self { value: defect, slope: self.slope * e })
    }
    #[inline(always)]
    fn ln_1p(self) -> Self {
        Self { value: self.value.ln_1p(), slope: self.slope / (self.value + 1.0) }
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Self { value: self.value.ln(), slope: self.slope / self.value }
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        (self - o).select_positive(self, o)
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        (self - o).select_positive(o, self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.select_positive(self, -self)
    }
    #[inline(always)]
    fn select_positive(self, yes: Self, no: Self) -> Self {
        Self {
            value: self.value.select_positive(yes.value, no.value),
            slope: self.value.select_positive(yes.slope, no.slope),
        }
    }
    #[inline(always)]
    fn seed_inverse_cbrt_1p(self) -> Self {
        // Only an initial guess: Halley's iteration rebuilds the derivative together with the value.
        Self { value: self.value.seed_inverse_cbrt_1p(), slope: self.value.zero() }
    }
    #[inline(always)]
    fn outlined<Op: Outlined>(self, op: Op) -> Op::Output {
        self.value.outlined(op)
    }
    #[inline(always)]
    fn detached(self) -> Self {
        Self { value: self.value, slope: self.value.zero() }
    }
}
