//! SIMD lanes as a [`Real`]: the same laws and kernels, several elements at once.
//!
//! `pulp` picks the instruction set at run time (AVX-512, AVX2 + FMA, or plain `f64`), so one binary serves all.
//! Everything here is inlined into the dispatched function, which has the instruction set; [`Real::outlined`] alone is a call, and enters
//! the instruction set again.

use super::real::{Outlined, Real, seed_inverse_cbrt};
use pulp::{Simd, WithSimd};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A number in a register of the instruction set `S`.
#[derive(Clone, Copy, Debug)]
pub struct Lane<S: Simd> {
    v: S::f64s,
    simd: S,
}

/// Width of a batch of elements: that of the widest register of any instruction set, in `f64`.
pub const BATCH: usize = 8;

/// One number of each element of a batch, aligned to the widest register: a load or store across two cache lines
/// takes twice as long, and without alignment most would be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Row(pub [f64; BATCH]);

impl std::ops::Index<usize> for Row {
    type Output = f64;
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl std::ops::IndexMut<usize> for Row {
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

/// A value on the stack, aligned to the widest register, see [`Row`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Aligned<T>(pub T);

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

impl<S: Simd> Lane<S> {
    /// All lanes equal to `c`.
    #[inline(always)]
    pub fn splat(simd: S, c: f64) -> Self {
        Self { v: simd.splat_f64s(c), simd }
    }
    /// Loads the `part`-th register out of a batch.
    #[inline(always)]
    pub fn load(simd: S, batch: &Row, part: usize) -> Self {
        Self { v: S::as_simd_f64s(&batch.0).0[part], simd }
    }
    /// Stores into the `part`-th register of a batch.
    #[inline(always)]
    pub fn store(self, batch: &mut Row, part: usize) {
        S::as_mut_simd_f64s(&mut batch.0).0[part] = self.v;
    }
    /// Applies an integer operation to the bits of every lane.
    #[inline(always)]
    fn map_bits(self, f: impl Fn(u64) -> u64) -> Self {
        let mut bits = self.v;
        for b in bytemuck::cast_slice_mut::<S::f64s, u64>(std::slice::from_mut(&mut bits)) {
            *b = f(*b);
        }
        Self { v: bits, simd: self.simd }
    }
    #[inline(always)]
    fn with(self, v: S::f64s) -> Self {
        Self { v, simd: self.simd }
    }
    /// ln(self + lost), `lost` of the order of the last digit of self.
    #[inline(always)]
    fn ln_of_sum(self, lost: Self) -> Self {
        // self = 2^k (1 + f) with √½ ≤ 1 + f < √2; for k = 0, f = x to all digits.
        let sqrt_half = std::f64::consts::FRAC_1_SQRT_2.to_bits();
        let exponent = |b: u64| b.wrapping_sub(sqrt_half).cast_signed() >> 52;
        let scale = self.map_bits(|b| (1023 - exponent(b)).cast_unsigned() << 52);
        // k as a number: put k + bias into the low bits of 2^52 · 1.5 and subtract.
        let k = self.map_bits(|b| 6_755_399_441_055_744.0_f64.to_bits().wrapping_add_signed(exponent(b)))
            - 6_755_399_441_055_744.0;
        let f = scale.mul_add(lost, scale * self - 1.0);
        let s = f / (f + 2.0);
        let s2 = s * s;
        let mut p = self.constant(LN_SERIES[0]);
        for c in &LN_SERIES[1..] {
            p = p.mul_add(s2, self.constant(*c));
        }
        let low = k.mul_add(self.constant(LN_2_LOW), p * s);
        k.mul_add(self.constant(LN_2_HIGH), low)
    }
    /// 2^k, r and (expm1(r) − r)/r with self = k ln 2 + r, |r| ≤ ½ ln 2; self is clamped to ±708, the range of f64.
    #[inline(always)]
    fn split_exp(self) -> (Self, Self, Self) {
        let x = self.max(self.constant(-708.0)).min(self.constant(708.0));
        // Adding 1.5 · 2^52 rounds to the nearest integer and leaves it in the low bits.
        let magic = 6_755_399_441_055_744.0;
        let t = x.mul_add(self.constant(std::f64::consts::LOG2_E), self.constant(magic));
        let k = t - magic;
        let r = k.mul_add(self.constant(-LN_2_HIGH), x);
        let r = k.mul_add(self.constant(-LN_2_LOW), r);
        let mut p = self.constant(EXP_SERIES[0]);
        for c in &EXP_SERIES[1..] {
            p = p.mul_add(r, self.constant(*c));
        }
        (t.map_bits(|b| (b << 52).wrapping_add(1023 << 52)), r, p * r)
    }
}

/// ln 2 in two parts, the high one with trailing zeros so that k · high is exact.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// 1/13! … 1/2!: expm1(r) = r + r² Σ, error below 1e-17 relative for |r| ≤ ½ ln 2.
const EXP_SERIES: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
];

/// 2/21, 2/19 … 2/3, 2: ln(1 + f) = s Σ c (s²)^i with s = f / (2 + f), |s| ≤ 0.172.
const LN_SERIES: [f64; 11] = [
    2.0 / 21.0,
    2.0 / 19.0,
    2.0 / 17.0,
    2.0 / 15.0,
    2.0 / 13.0,
    2.0 / 11.0,
    2.0 / 9.0,
    2.0 / 7.0,
    2.0 / 5.0,
    2.0 / 3.0,
    2.0,
];

impl<S: Simd> Real for Lane<S> {
    #[inline(always)]
    fn constant(self, c: f64) -> Self {
        self.with(self.simd.splat_f64s(c))
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // The variant that is fused where that is fast, and two operations elsewhere.
        self.with(self.simd.mul_add_e_f64s(self.v, b.v, c.v))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.with(self.simd.sqrt_f64s(self.v))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let (scale, r, p) = self.split_exp();
        scale.mul_add(p.mul_add(r, r), scale)
    }
    #[inline(always)]
    fn exp_m1(self) -> Self {
        let (scale, r, p) = self.split_exp();
        scale.mul_add(p.mul_add(r, r), scale - 1.0)
    }
    #[inline(always)]
    fn exp_m1_and_defect(self) -> (Self, Self) {
        let (scale, r, p) = self.split_exp();
        // For k = 0 the defect is r² Σ alone: 2^k r − self and 2^k − 1 are zero.
        let defect = scale.mul_add(p * r, scale.mul_sub(r, self) + (scale - 1.0));
        (scale.mul_add(p.mul_add(r, r), scale - 1.0), defect)
    }
    #[inline(always)]
    fn ln_1p(self) -> Self {
        // x − (u − 1) is what rounding 1 + x has lost.
        let u = self + 1.0;
        u.ln_of_sum(self - (u - 1.0))
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.ln_of_sum(self.zero())
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        self.with(self.simd.max_f64s(self.v, o.v))
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        self.with(self.simd.min_f64s(self.v, o.v))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // pulp's own abs and neg are not always inlined, and a call in a kernel costs more than the kernel's
        // arithmetic.
        self.max(-self)
    }
    #[inline(always)]
    fn select_positive(self, yes: Self, no: Self) -> Self {
        let mask = self.simd.greater_than_f64s(self.v, self.simd.splat_f64s(0.0));
        self.with(self.simd.select_f64s(mask, yes.v, no.v))
    }
    #[inline(always)]
    fn seed_inverse_cbrt_1p(self) -> Self {
        (self + 1.0).map_bits(|b| seed_inverse_cbrt(f64::from_bits(b)).to_bits())
    }
    #[inline(never)]
    fn outlined<Op: Outlined>(self, op: Op) -> Op::Output {
        self.simd.vectorize(WithoutToken(op))
    }
}

/// What has its lanes, and with them the token of the instruction set, already.
struct WithoutToken<Op>(Op);

impl<Op: Outlined> WithSimd for WithoutToken<Op> {
    type Output = Op::Output;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Op::Output {
        self.0.run()
    }
}

/// The binary operators, between lanes and with a constant.
macro_rules! operator {
    ($trait:ident, $name:ident, $op:ident) => {
        impl<S: Simd> $trait for Lane<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                self.with(self.simd.$op(self.v, o.v))
            }
        }
        impl<S: Simd> $trait<f64> for Lane<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, c: f64) -> Self {
                self.with(self.simd.$op(self.v, self.simd.splat_f64s(c)))
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for Lane<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.with(self.simd.sub_f64s(self.simd.splat_f64s(-0.0), self.v))
    }
}
impl<S: Simd> AddAssign for Lane<S> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<S: Simd> SubAssign for Lane<S> {
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
