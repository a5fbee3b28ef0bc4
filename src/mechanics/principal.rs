//! Scalars of a symmetric tensor: von Mises stress, pressure, the largest principal value.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::real::Real;
use super::tensor::Sym;

/// cos(θ/3) as a polynomial in t = 2 cos(θ/2) − 1, highest power first, for 0 ≤ θ ≤ π: within 1e-15.
///
/// As a function of cos(θ/2) in 0…1 it is smooth up to −1, so that the coefficients of the Chebyshev series fall by
/// 5.8 per term; these are its first 19 terms as powers. A function of cos θ would have a branch point at the end of
/// its range.
const THIRD_OF_ANGLE: [f64; 19] = [
    -1.278_976_924_368_180_3e-12,
    4.996_536_517_865_024_5e-11,
    -1.673_328_142_715_036e-10,
    3.154_791_983_206_451e-10,
    -1.026_037_033_113_880_2e-9,
    3.968_422_479_516_676e-9,
    -1.353_044_698_504_390_8e-8,
    4.584_312_490_729_658_4e-8,
    -1.594_224_691_703_338_7e-7,
    5.641_519_298_382_747e-7,
    -2.035_916_569_748_108_5e-6,
    7.541_081_065_442_351e-6,
    -2.891_992_618_828_456_7e-5,
    0.000_116_425_451_926_615_78,
    -0.000_504_124_692_211_806_9,
    0.002_466_352_815_239_996,
    -0.015_509_188_436_443_232,
    0.247_409_066_322_845_96,
    0.766_044_443_118_977_7,
];

impl<R: Real> Sym<R> {
    /// Von Mises stress √(3/2 s:s), s the deviator of this Cauchy stress [Pa].
    #[inline(always)]
    pub fn von_mises(&self) -> R {
        (self.deviator().norm_squared() * 1.5).sqrt()
    }

    /// Pressure −tr σ / 3 of this Cauchy stress, positive in compression [Pa].
    #[inline(always)]
    pub fn pressure(&self) -> R {
        self.trace() * (-1.0 / 3.0)
    }

    /// Largest principal value: the mean plus that of the deviator.
    #[inline(always)]
    pub fn largest_principal(&self) -> R {
        let q = self.trace() * (1.0 / 3.0);
        let (p, third) = self.deviator().size_and_angle();
        (p * third).mul_add(p.constant(2.0), q)
    }

    /// Largest eigenvalue of a deviator.
    #[inline(always)]
    pub fn largest_of_deviator(&self) -> R {
        let (p, third) = self.size_and_angle();
        p * third * 2.0
    }

    /// Least and largest principal value. The least is minus the largest of the negative: with the same p, and minus the
    /// same determinant.
    #[inline(always)]
    pub fn extreme_principals(&self) -> [R; 2] {
        let q = self.trace() * (1.0 / 3.0);
        let (p, cosine) = self.deviator().size_and_cosine();
        let (of_least, of_largest) = (p * third_of_angle(-cosine), p * third_of_angle(cosine));
        let two = p.constant(2.0);
        [-of_least.mul_add(two, -q), of_largest.mul_add(two, q)]
    }

    /// p and cos φ of a deviator B, whose largest eigenvalue is 2 p cos φ.
    #[inline(always)]
    fn size_and_angle(&self) -> (R, R) {
        let (p, cosine) = self.size_and_cosine();
        (p, third_of_angle(cosine))
    }

    /// p and cos 3φ of a deviator B, whose largest eigenvalue is 2 p cos φ, in closed form (Smith 1961): p² = B:B / 6
    /// and cos 3φ = det B / (2 p³). An iteration would take longer than the law itself.
    #[inline(always)]
    fn size_and_cosine(&self) -> (R, R) {
        let p = (self.norm_squared() * (1.0 / 6.0)).sqrt();
        let one = p.constant(1.0);
        // For a multiple of the identity B is zero: 0/tiny, not 0/0.
        let scaled = self.scaled(one / p.max(p.constant(f64::MIN_POSITIVE)));
        (p, (scaled.determinant() * 0.5).min(one).max(-one))
    }
}

/// cos φ of cos 3φ, for 0 ≤ 3φ ≤ π.
#[inline(always)]
fn third_of_angle<R: Real>(cosine: R) -> R {
    let t = ((cosine + 1.0) * 0.5).sqrt() * 2.0 - 1.0;
    let mut third = t.constant(THIRD_OF_ANGLE[0]);
    for c in &THIRD_OF_ANGLE[1..] {
        third = third.mul_add(t, t.constant(*c));
    }
    third
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;
    use crate::tensor::Mat3;

    fn sym(m: &Mat3) -> Sym<f64> {
        Sym([m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(0, 2)]])
    }

    #[test]
    fn von_mises_of_uniaxial_stress_is_the_stress() {
        let sigma = Sym([-5.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!((sigma.von_mises() - 5.0).abs() < 1e-14 && (sigma.pressure() - 5.0 / 3.0).abs() < 1e-14);
        let shear = Sym([0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
        assert!((shear.von_mises() - 2.0 * 3f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn the_closed_form_is_the_largest_eigenvalue() {
        for seed in 0..50 {
            let wave = |i: usize, j: usize| 0.3 * f64::from(seed).mul_add(1.7, (5 * i + 3 * j) as f64).sin();
            let m = Mat3::from_fn(wave);
            let m = (m + m.transpose()) * 0.5;
            let (found, largest) = (sym(&m).largest_principal(), m.symmetric_eigenvalues().max());
            assert!((found - largest).abs() < 1e-13, "{seed}: {found} against {largest}");
            // Bit for bit, also for double eigenvalues.
            for m in [sym(&m), Sym([found, found, 0.1, 0.0, 0.0, 0.0]), Sym([found; 6])] {
                let negative = m.scaled(-1.0);
                assert_eq!(m.extreme_principals(), [-negative.largest_principal(), m.largest_principal()]);
            }
        }
    }

    #[test]
    fn equal_and_double_eigenvalues_are_no_exception() {
        assert_eq!(Sym([0.0; 6]).largest_principal(), 0.0);
        assert!((Sym([0.105, 0.105, 0.105, 0.0, 0.0, 0.0]).largest_principal() - 0.105).abs() < 1e-15);
        assert!((Sym([0.22, 0.0, 0.0, 0.0, 0.0, 0.0]).largest_principal() - 0.22).abs() < 1e-15);
        // Where the two largest coincide, the rounding of the cosine leaves its square root.
        assert!((Sym([0.2, 0.2, -0.1, 0.0, 0.0, 0.0]).largest_principal() - 0.2).abs() < 1e-8);
    }
}
