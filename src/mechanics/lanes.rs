//! SIMD lanes as a [`Real`]: the same laws and kernels, several elements at once.
//!
//! `pulp` picks the instruction set at run time (AVX-512, AVX2 + FMA, or plain `f64`), so one binary serves all.
//! Everything here is inlined into the dispatched function, which has the instruction set; [`Real::outlined`] alone is a call, and enters
//! the instruction set again.

use super::real::{Outlined, Real};
use super::registers::{Exp, ExpM1, Ln, Ln1p, Registers, SeedInverseCbrt1p, Single};
use pulp::{Simd, WithSimd};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

pub use super::row::{Aligned, BATCH, Row};

/// A number in a register of the instruction set and precision `S`.
#[derive(Clone, Copy, Debug)]
pub struct Lane<S: Registers> {
    pub(super) v: S::Numbers,
    pub(super) simd: S,
}

/// Runs what few steps need (tangents, stresses at points) with AVX2 or plain `f64`: registers of AVX-512 would save little time, and
/// each instruction set is one more copy of every pass in the program. The bits are the same.
pub fn dispatch_rare<Op: WithSimd>(op: Op) -> Op::Output {
    #[cfg(target_arch = "x86_64")]
    return match pulp::x86::V3::try_new() {
        Some(simd) => Simd::vectorize(simd, op),
        None => pulp::Scalar::new().vectorize(op),
    };
    #[cfg(not(target_arch = "x86_64"))]
    pulp::Arch::new().dispatch(op)
}

/// Runs it with registers of several numbers.
///
/// # Errors
/// Gives it back where the machine has none: for what is not worth a copy in plain `f64`.
pub fn dispatch_wide<Op: WithSimd>(op: Op) -> Result<Op::Output, Op> {
    #[cfg(target_arch = "x86_64")]
    return match (pulp::x86::V4::try_new(), pulp::x86::V3::try_new()) {
        (Some(simd), _) => Ok(Simd::vectorize(simd, op)),
        (None, Some(simd)) => Ok(Simd::vectorize(simd, op)),
        (None, None) => Err(op),
    };
    #[cfg(not(target_arch = "x86_64"))]
    Ok(pulp::Arch::new().dispatch(op))
}

/// An operation on registers of any instruction set and precision.
pub trait WithRegisters {
    /// Performs it; must be `#[inline(always)]`.
    fn with_registers<S: Registers>(self, simd: S);
}

/// Runs it with single precision, in registers of no more numbers than a batch has.
///
/// # Errors
/// As [`dispatch_wide`].
pub fn dispatch_single<Op: WithRegisters>(op: Op) -> Result<(), Op> {
    struct InSingle<Op>(Op);
    impl<Op: WithRegisters> WithSimd for InSingle<Op> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.0.with_registers(Single(simd));
        }
    }
    #[cfg(target_arch = "x86_64")]
    match pulp::x86::V3::try_new() {
        Some(simd) => Simd::vectorize(simd, InSingle(op)),
        None => return Err(op),
    }
    #[cfg(not(target_arch = "x86_64"))]
    pulp::Arch::new().dispatch(InSingle(op));
    Ok(())
}

impl<S: Registers> Lane<S> {
    /// All lanes equal to `c`.
    #[inline(always)]
    pub fn splat(simd: S, c: f64) -> Self {
        Self { v: simd.splat(c), simd }
    }
    /// Loads the `part`-th register out of a batch.
    #[inline(always)]
    pub fn load(simd: S, batch: &Row, part: usize) -> Self {
        Self { v: simd.load(batch, part), simd }
    }
    /// Stores into the `part`-th register of a batch.
    #[inline(always)]
    pub fn store(self, batch: &mut Row, part: usize) {
        self.simd.store(self.v, batch, part);
    }
    /// Other numbers in registers of the same kind.
    #[inline(always)]
    pub(super) fn with(self, v: S::Numbers) -> Self {
        Self { v, simd: self.simd }
    }
}

impl<S: Registers> Real for Lane<S> {
    #[inline(always)]
    fn constant(self, c: f64) -> Self {
        self.with(self.simd.splat(c))
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.with(self.simd.multiply_add(self.v, b.v, c.v))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.with(self.simd.square_root(self.v))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        self.with(self.simd.elementary::<Exp>(self.v)[0])
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        self.with(self.simd.elementary::<ExpM1>(self.v)[0])
    }
    #[inline(always)]
    fn exp_m1_and_defect(self) -> (Self, Self) {
        let [value, defect] = self.simd.elementary::<ExpM1>(self.v);
        (self.with(value), self.with(defect))
    }
    #[inline(always)]
    fn ln_1p(self) -> Self {
        self.with(self.simd.elementary::<Ln1p>(self.v)[0])
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.with(self.simd.elementary::<Ln>(self.v)[0])
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        self.with(self.simd.larger(self.v, o.v))
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        self.with(self.simd.smaller(self.v, o.v))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // pulp's own abs and neg are not always inlined, and a call in a kernel costs more than the kernel's
        // arithmetic.
        self.max(-self)
    }
    #[inline(always)]
    fn select_positive(self, yes: Self, no: Self) -> Self {
        self.with(self.simd.where_positive(self.v, yes.v, no.v))
    }
    #[inline(always)]
    fn seed_inverse_cbrt_1p(self) -> Self {
        self.with(self.simd.elementary::<SeedInverseCbrt1p>(self.v)[0])
    }
    #[inline(never)]
    fn outlined<Op: Outlined>(self, op: Op) -> Op::Output {
        self.simd.enter(op)
    }
}

/// The binary operators, between lanes and with a constant.
macro_rules! operator {
    ($trait:ident, $name:ident, $op:ident) => {
        impl<S: Registers> $trait for Lane<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                self.with(self.simd.$op(self.v, o.v))
            }
        }
        impl<S: Registers> $trait<f64> for Lane<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, c: f64) -> Self {
                self.with(self.simd.$op(self.v, self.simd.splat(c)))
            }
        }
    };
}
operator!(Add, add, plus);
operator!(Sub, sub, minus);
operator!(Mul, mul, times);
operator!(Div, div, over);

impl<S: Registers> Neg for Lane<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.with(self.simd.minus(self.simd.splat(-0.0), self.v))
    }
}
impl<S: Registers> AddAssign for Lane<S> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<S: Registers> SubAssign for Lane<S> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::inverse_cbrt_m1;

    /// Evaluates a function over lanes of the best instruction set and in plain `f64`, and compares.
    struct Compare<'a, L, P>(&'a [f64], L, P);

    trait Function {
        fn eval<R: Real>(&self, x: R) -> R;
    }
    struct Exp;
    struct ExpM1;
    struct Defect;
    struct Ln1p;
    struct Ln;
    struct InverseCbrt;
    impl Function for Exp {
        fn eval<R: Real>(&self, x: R) -> R {
            x.exp()
        }
    }
    impl Function for ExpM1 {
        fn eval<R: Real>(&self, x: R) -> R {
            x.exp_m1()
        }
    }
    impl Function for Defect {
        fn eval<R: Real>(&self, x: R) -> R {
            x.exp_m1_and_defect().1
        }
    }
    impl Function for Ln1p {
        fn eval<R: Real>(&self, x: R) -> R {
            x.ln_1p()
        }
    }
    impl Function for Ln {
        fn eval<R: Real>(&self, x: R) -> R {
            x.ln()
        }
    }
    impl Function for InverseCbrt {
        fn eval<R: Real>(&self, x: R) -> R {
            inverse_cbrt_m1(x)
        }
    }

    impl<F: Function> pulp::WithSimd for Compare<'_, F, f64> {
        type Output = ();
        fn with_simd<S: Simd>(self, simd: S) {
            for x in self.0 {
                let mut out = Row::default();
                self.1.eval(Lane::splat(simd, *x)).store(&mut out, 0);
                let out = out.0;
                let expected = self.1.eval(*x);
                let error = (out[0] - expected).abs();
                assert!(
                    error <= self.2 * f64::EPSILON * expected.abs(),
                    "at {x}: {} against {expected}",
                    out[0]
                );
            }
        }
    }

    impl<F: Function> WithRegisters for Compare<'_, F, f64> {
        fn with_registers<S: Registers>(self, simd: S) {
            for x in self.0 {
                let (mut out, x) = (Row::default(), f64::from(*x as f32));
                self.1.eval(Lane::splat(simd, x)).store(&mut out, 0);
                let expected = self.1.eval(x);
                let error = (out.0[0] - expected).abs();
                let ulp = f64::from(f32::EPSILON) * expected.abs();
                assert!(error <= self.2 * ulp, "at {x}: {} against {expected}", out.0[0]);
            }
        }
    }

    #[test]
    fn functions_in_single_precision_agree_within_a_few_ulp() {
        let numbers: Vec<f64> = (-800..3000).map(|i| f64::from(i) * 0.001).filter(|x| *x != 0.0).collect();
        // Squares of what is smaller are no normal numbers.
        let tiny: Vec<f64> = (0..18).map(|i| 10f64.powi(-i) * 0.7).flat_map(|x| [x, -x]).collect();
        let all: Vec<f64> = numbers.into_iter().chain(tiny).collect();
        assert!(dispatch_single(Compare(&all, Exp, 1.0)).is_ok());
        assert!(dispatch_single(Compare(&all, ExpM1, 1.0)).is_ok());
        assert!(dispatch_single(Compare(&all, Defect, 1.0)).is_ok());
        assert!(dispatch_single(Compare(&all, Ln1p, 1.0)).is_ok());
        assert!(dispatch_single(Compare(&all, InverseCbrt, 4.0)).is_ok());
    }

    #[test]
    fn lane_functions_agree_with_the_standard_library_within_a_few_ulp() {
        let spread: Vec<f64> = (-3000..3000).map(|i| f64::from(i) * 0.01).collect();
        let tiny: Vec<f64> = (0..40).map(|i| 10f64.powi(-i) * 0.7).flat_map(|x| [x, -x]).collect();
        let above_minus_one: Vec<f64> =
            (1..4000).map(|i| f64::from(i) * 0.003 - 0.999).chain(tiny.clone()).collect();
        let positive: Vec<f64> =
            (-300..300).map(|i| 1.37 * 10f64.powi(i)).chain([f64::MIN_POSITIVE, 1.0, 0.999]).collect();
        for arch in [pulp::Arch::Scalar, pulp::Arch::new()] {
            arch.dispatch(Compare(&spread, Exp, 3.0));
            arch.dispatch(Compare(&tiny, ExpM1, 3.0));
            arch.dispatch(Compare(&spread, ExpM1, 4.0));
            // Beyond the series three numbers of order 1 nearly cancel.
            arch.dispatch(Compare(&tiny, Defect, 4.0));
            arch.dispatch(Compare(&spread, Defect, 24.0));
            arch.dispatch(Compare(&above_minus_one, Ln1p, 3.0));
            arch.dispatch(Compare(&positive, Ln, 3.0));
            arch.dispatch(Compare(&above_minus_one, InverseCbrt, 4.0));
        }
    }
}
