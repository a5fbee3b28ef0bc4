//! The registers that lanes are in: `f64` of any instruction set, or single precision, of which a register has twice as many.
//!
//! In memory everything is `f64`, and so are the sums over elements; a load rounds, and a store widens. Sums of a whole batch
//! and the motion of the bodies keep all their digits; what is rounded to 6e-8 is the response of one element to the
//! differences of its displacements.

use super::real::Outlined;
use super::row::{BATCH, Row};
use pulp::{Simd, WithSimd};
use std::fmt::Debug;

/// Registers of one instruction set and one precision.
pub trait Registers: Copy + Debug {
    /// One register.
    type Numbers: Copy + Debug;
    /// Numbers in a register.
    const LANES: usize;
    /// Whether numbers have single precision.
    const IS_SINGLE: bool;

    /// All numbers equal to `c`.
    fn splat(self, c: f64) -> Self::Numbers;
    /// The `part`-th register of a batch.
    fn load(self, batch: &Row, part: usize) -> Self::Numbers;
    /// Stores it there.
    fn store(self, v: Self::Numbers, batch: &mut Row, part: usize);
    /// `a + b`.
    fn plus(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a − b`.
    fn minus(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a b`.
    fn times(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a / b`.
    fn over(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a b + c`, fused where that is fast.
    fn multiply_add(self, a: Self::Numbers, b: Self::Numbers, c: Self::Numbers) -> Self::Numbers;
    /// `√a`.
    fn square_root(self, a: Self::Numbers) -> Self::Numbers;
    /// Lane-wise maximum.
    fn larger(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// Lane-wise minimum.
    fn smaller(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `if a > 0 { yes } else { no }`.
    fn where_positive(self, a: Self::Numbers, yes: Self::Numbers, no: Self::Numbers) -> Self::Numbers;
    /// A function of `f64`.
    fn elementary<F: Elementary>(self, v: Self::Numbers) -> [Self::Numbers; 2];
    /// Calls what is not inlined, with the instruction set.
    fn enter<Op: Outlined>(self, op: Op) -> Op::Output;
}

/// A function of `f64`, number by number; two results, of which most have but one (`elementary.rs`).
pub trait Elementary {
    /// Its values at each number of a register.
    fn eval<S: Simd>(simd: S, v: S::f64s) -> [S::f64s; 2];
}

/// `exp(x)`.
#[derive(Debug)]
pub struct Exp;
/// `exp(x) − 1` and `exp(x) − 1 − x`.
#[derive(Debug)]
pub struct ExpM1;
/// `ln(1 + x)`.
#[derive(Debug)]
pub struct Ln1p;
/// `ln(x)`.
#[derive(Debug)]
pub struct Ln;
/// Approximate `(1 + x)^(−1/3)`.
#[derive(Debug)]
pub struct SeedInverseCbrt1p;

/// Single precision in the registers of an instruction set that have no more numbers than a batch.
#[derive(Clone, Copy, Debug)]
pub struct Single<S>(pub S);

impl<S: Simd> Registers for S {
    type Numbers = S::f64s;
    const LANES: usize = S::F64_LANES;
    const IS_SINGLE: bool = false;

    #[inline(always)]
    fn splat(self, c: f64) -> S::f64s {
        self.splat_f64s(c)
    }
    #[inline(always)]
    fn load(self, batch: &Row, part: usize) -> S::f64s {
        S::as_simd_f64s(&batch.0).0[part]
    }
    #[inline(always)]
    fn store(self, v: S::f64s, batch: &mut Row, part: usize) {
        S::as_mut_simd_f64s(&mut batch.0).0[part] = v;
    }
    #[inline(always)]
    fn plus(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.add_f64s(a, b)
    }
    #[inline(always)]
    fn minus(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.sub_f64s(a, b)
    }
    #[inline(always)]
    fn times(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.mul_f64s(a, b)
    }
    #[inline(always)]
    fn over(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.div_f64s(a, b)
    }
    #[inline(always)]
    fn multiply_add(self, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
        self.mul_add_e_f64s(a, b, c)
    }
    #[inline(always)]
    fn square_root(self, a: S::f64s) -> S::f64s {
        self.sqrt_f64s(a)
    }
    #[inline(always)]
    fn larger(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.max_f64s(a, b)
    }
    #[inline(always)]
    fn smaller(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.min_f64s(a, b)
    }
    #[inline(always)]
    fn where_positive(self, a: S::f64s, yes: S::f64s, no: S::f64s) -> S::f64s {
        let mask = self.greater_than_f64s(a, self.splat_f64s(0.0));
        self.select_f64s(mask, yes, no)
    }
    #[inline(always)]
    fn elementary<F: Elementary>(self, v: S::f64s) -> [S::f64s; 2] {
        F::eval(self, v)
    }
    #[inline(always)]
    fn enter<Op: Outlined>(self, op: Op) -> Op::Output {
        self.vectorize(WithoutToken(op))
    }
}

impl<S: Simd> Registers for Single<S> {
    type Numbers = S::f32s;
    const LANES: usize = S::F32_LANES;
    const IS_SINGLE: bool = true;

    #[inline(always)]
    fn splat(self, c: f64) -> S::f32s {
        self.0.splat_f32s(c as f32)
    }
    #[inline(always)]
    fn load(self, batch: &Row, part: usize) -> S::f32s {
        let mut narrow = [0.0; BATCH];
        for (narrow, x) in narrow.iter_mut().zip(&batch.0) {
            *narrow = *x as f32;
        }
        S::as_simd_f32s(&narrow).0[part]
    }
    #[inline(always)]
    fn store(self, v: S::f32s, batch: &mut Row, part: usize) {
        let to = &mut batch.0[part * Self::LANES..(part + 1) * Self::LANES];
        for (x, narrow) in to.iter_mut().zip(bytemuck::cast_slice::<S::f32s, f32>(&[v])) {
            *x = f64::from(*narrow);
        }
    }
    #[inline(always)]
    fn plus(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.add_f32s(a, b)
    }
    #[inline(always)]
    fn minus(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.sub_f32s(a, b)
    }
    #[inline(always)]
    fn times(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.mul_f32s(a, b)
    }
    #[inline(always)]
    fn over(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.div_f32s(a, b)
    }
    #[inline(always)]
    fn multiply_add(self, a: S::f32s, b: S::f32s, c: S::f32s) -> S::f32s {
        self.0.mul_add_e_f32s(a, b, c)
    }
    #[inline(always)]
    fn square_root(self, a: S::f32s) -> S::f32s {
        self.0.sqrt_f32s(a)
    }
    #[inline(always)]
    fn larger(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.max_f32s(a, b)
    }
    #[inline(always)]
    fn smaller(self, a: S::f32s, b: S::f32s) -> S::f32s {
        self.0.min_f32s(a, b)
    }
    #[inline(always)]
    fn where_positive(self, a: S::f32s, yes: S::f32s, no: S::f32s) -> S::f32s {
        let mask = self.0.greater_than_f32s(a, self.0.splat_f32s(0.0));
        self.0.select_f32s(mask, yes, no)
    }
    #[inline(always)]
    fn elementary<F: Elementary>(self, v: S::f32s) -> [S::f32s; 2] {
        let mut rows = [Row::default(); 2];
        self.store(v, &mut rows[0], 0);
        for part in 0..Self::LANES.div_ceil(S::F64_LANES) {
            let [a, b] = F::eval(self.0, Registers::load(self.0, &rows[0], part));
            Registers::store(self.0, a, &mut rows[0], part);
            Registers::store(self.0, b, &mut rows[1], part);
        }
        rows.map(|row| self.load(&row, 0))
    }
    #[inline(always)]
    fn enter<Op: Outlined>(self, op: Op) -> Op::Output {
        self.0.vectorize(WithoutToken(op))
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
