//! Functions of the isochoric strain in terms of its logarithm, for their derivatives: smooth where principal stretches coincide.
//!
//! L = ln C̄ is symmetric and traceless, so L³ = p L + q I with p = ½ tr L², q = det L (Cayley–Hamilton). Its powers
//! are `a L² + b L + c I` with a, b, c polynomials of p and q: no eigenvectors are needed, and equal eigenvalues are
//! no special case.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::Kinematics;
use super::isochoric::{eval_first_invariant, eval_second_invariant};
use super::principal_strain::PrincipalStrain;
use crate::real::Real;

/// exp(kL) − I = a L² + b L + c I.
#[derive(Clone, Copy)]
pub(super) struct Exponential<R> {
    /// Coefficient a of L².
    pub a: R,
    /// Coefficient b of L.
    pub b: R,
    /// Coefficient c of I.
    pub c: R,
}

/// Terms of the series of exp: relative error below 1e-16 for a norm up to 0.3, 1e-13 up to 0.6.
const SERIES: i32 = 12;

/// A multiple kL, with the number of halvings for the series: the norm is then below 0.3 for principal stretches λ̄
/// from 1/9 to 9, |ln λ̄²| < 4.5.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Multiple {
    /// The factor k [-].
    k: f64,
    halvings: u32,
    /// The factor of the series, k/2^halvings [-].
    reduced: f64,
}

impl Multiple {
    const UP: Self = Self { k: 1.0, halvings: 4, reduced: 1.0 / 16.0 };
    const DOWN: Self = Self { k: -1.0, halvings: 4, reduced: -1.0 / 16.0 };

    /// The multiple kL of a logarithm L.
    pub fn new(k: f64) -> Self {
        let halvings = 4 + k.abs().max(1.0).log2().ceil() as u32;
        Self { k, halvings, reduced: k * 0.5_f64.powi(halvings.cast_signed()) }
    }
}

impl<R: Real> Exponential<R> {
    /// Exponential of a multiple of L: the series for the reduced one, squared repeatedly as `(I + E)² − I`, which
    /// preserves the accuracy of a small E.
    #[inline(always)]
    pub fn new(of: Multiple, p: R, q: R) -> Self {
        let r = of.reduced;
        let (mut p, mut q) = (p * (r * r), q * (r * r * r));
        let (mut a, mut b, mut c) = (p.zero(), p.zero(), p.constant(1.0));
        // Horner: T ← I + B T/n, with B (a B² + b B + c I) = b B² + (c + p a) B + q a I
        for n in (2..=SERIES).rev() {
            let inverse = 1.0 / f64::from(n);
            (a, b, c) = (b * inverse, p.mul_add(a, c) * inverse, (q * a).scale_add(inverse, 1.0));
        }
        (a, b, c) = (b, p.mul_add(a, c), q * a);
        for _ in 0..of.halvings {
            let (aa, twice_ab) = (a * a, a * b * 2.0);
            let square_a = aa.mul_add(p, b.mul_add(b, a * c * 2.0));
            let square_b = aa.mul_add(q, twice_ab.mul_add(p, b * c * 2.0));
            let square_c = twice_ab.mul_add(q, c * c);
            // After this scaling the coefficients are those of twice the tensor.
            (a, b, c) = ((square_a + a * 2.0) * 0.25, (square_b + b * 2.0) * 0.5, square_c + c * 2.0);
            (p, q) = (p * 4.0, q * 8.0);
        }
        Self { a: a * (of.k * of.k), b: b * of.k, c }
    }
}

/// ln C̄ at a point, in terms of its invariants.
#[derive(Clone, Copy)]
pub(super) struct Logarithm<R> {
    /// p = ½ tr L² [-].
    pub p: R,
    /// q = det L [-].
    pub q: R,
    /// Coefficients of exp(L) − I.
    up: Exponential<R>,
    /// Coefficients of exp(−L) − I.
    down: Exponential<R>,
    /// `a₊ b₋ − a₋ b₊`, minus the product of the divided differences of exp; never zero.
    determinant: R,
}

impl<R: Real> Logarithm<R> {
    /// Logarithm at a point with these principal values.
    ///
    /// Those have no derivatives where they coincide. Those of p and q do, by a Newton step on `tr exp(±L) = Ī1, Ī2`:
    /// `∂ tr exp(±L)/∂p = ±b`, `∂ tr exp(±L)/∂q = ±a`.
    #[inline(always)]
    pub fn new(k: &Kinematics<R>, strain: &PrincipalStrain<R>) -> Self {
        let [most, middle, least] = strain.logs;
        let mut p = most.mul_sub(most, least * middle);
        let mut q = most * least * middle;
        let (up, down) = (Exponential::new(Multiple::UP, p, q), Exponential::new(Multiple::DOWN, p, q));
        let (x1, _) = eval_first_invariant(1.0, k);
        let (x2, _) = eval_second_invariant(1.0, k);
        let (dx1, dx2) = (x1 - x1.detached(), x2 - x2.detached());
        let inverse = p.constant(1.0) / (up.b * down.a - up.a * down.b);
        p += (down.a * dx1 + up.a * dx2) * inverse;
        q -= (down.b * dx1 + up.b * dx2) * inverse;
        let (up, down) = (Exponential::new(Multiple::UP, p, q), Exponential::new(Multiple::DOWN, p, q));
        let determinant = up.a * down.b - down.a * up.b;
        Self { p, q, up, down, determinant }
    }
    /// exp(kL) − I, and its trace.
    #[inline(always)]
    pub fn exponential(&self, multiple: Multiple) -> (Exponential<R>, R) {
        let e = Exponential::new(multiple, self.p, self.q);
        (e, self.p * e.a * 2.0 + e.c * 3.0)
    }
    /// The deviator of `a L² + b L` in terms of the deviators of C and cof C: their factors times J [-].
    ///
    /// `a L² + b L = t₁ (C̄ − c₊ I) + t₂ (C̄⁻¹ − c₋ I)`, C̄ = J^(−2/3) C, C̄⁻¹ = J^(−4/3) cof C.
    #[inline(always)]
    pub fn in_strain(&self, k: &Kinematics<R>, a: R, b: R) -> (R, R) {
        let j23 = k.j23_m1() + 1.0;
        let inverse = a.constant(1.0) / self.determinant;
        let first = (a * self.down.b - b * self.down.a) * inverse;
        let second = (b * self.up.a - a * self.up.b) * inverse;
        (first * j23, second * (j23 * j23))
    }
}
