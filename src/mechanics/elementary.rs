//! Elementary functions of several `f64` at once: exponential, logarithm, initial guess of a cube root.

use super::lanes::Lane;
use super::real::{Real, seed_inverse_cbrt};
use super::registers::{Elementary, Exp, ExpM1, Ln, Ln1p, SeedInverseCbrt1p};
use pulp::Simd;

impl Elementary for Exp {
    #[inline(always)]
    fn eval<S: Simd>(simd: S, v: S::f64s) -> [S::f64s; 2] {
        let x = Lane { v, simd };
        let (scale, r, p) = x.split_exp();
        [scale.mul_add(p.mul_add(r, r), scale).v; 2]
    }
}

impl Elementary for ExpM1 {
    #[inline(always)]
    fn eval<S: Simd>(simd: S, v: S::f64s) -> [S::f64s; 2] {
        let x = Lane { v, simd };
        let (scale, r, p) = x.split_exp();
        // For k = 0 the defect is r² Σ alone: 2^k r − x and 2^k − 1 are zero.
        let defect = scale.mul_add(p * r, scale.mul_sub(r, x) + (scale - 1.0));
        [scale.mul_add(p.mul_add(r, r), scale - 1.0).v, defect.v]
    }
}

impl Elementary for Ln1p {
    #[inline(always)]
    fn eval<S: Simd>(simd: S, v: S::f64s) -> [S::f64s; 2] {
        let x = Lane { v, simd };
        // x − (u − 1) is what rounding 1 + x has lost.
        let u = x + 1.0;
        [u.ln_of_sum(x - (u - 1.0)).v; 2]
    }
}

impl Elementary for Ln {
    #[inline(always)]
    fn eval<S: Simd>(simd: S, v: S::f64s) -> [S::f64s; 2] {
        let x = Lane { v, simd };
        [x.ln_of_sum(x.zero()).v; 2]
    }
}

impl Elementary for SeedInverseCbrt1p {
    #[inline(always)]
    fn eval<S: Simd>(simd: S, v: S::f64s) -> [S::f64s; 2] {
        let x = Lane { v, simd };
        [(x + 1.0).map_bits(|b| seed_inverse_cbrt(f64::from_bits(b)).to_bits()).v; 2]
    }
}

impl<S: Simd> Lane<S> {
    /// Applies an integer operation to the bits of every lane.
    #[inline(always)]
    fn map_bits(self, f: impl Fn(u64) -> u64) -> Self {
        let mut bits = self.v;
        for b in bytemuck::cast_slice_mut::<S::f64s, u64>(std::slice::from_mut(&mut bits)) {
            *b = f(*b);
        }
        self.with(bits)
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
