//! Powers of the isochoric strain by its principal values, and their sums as a stress.
//!
//! For f(y) = Σ c y^k of the principal values y of C̄, whose product is 1, Newton's divided differences give (with the theorem of
//! Cayley and Hamilton for C̄²)
//!
//! ```text
//! dev f(C̄) = (f₁₂ + y₃ f₁₂₃) dev C̄ + f₁₂₃ dev C̄⁻¹        f₁₂₃ = (f₁₂ − f₂₃)/(y₁ − y₃)
//! ```
//!
//! First differences come from `y₁ᵏ − y₂ᵏ = y₂ᵏ (e^(k (x₁ − x₂)) − 1)`, x = ln y, without cancellation. An error ε/(y₁ − y₃) of f₁₂₃ changes
//! the stress by that times (y − y₁)(y − y₂): by rounding, however near the principal values are. So do errors of two nearly equal principal
//! values in their difference, since an interpolation is of second order in it. Derivatives are not so benign: those come from `logarithm.rs`.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::Kinematics;
use super::isochoric::{eval_first_invariant, eval_second_invariant};
use crate::real::Real;
use crate::tensor::Sym;

/// Stands for the difference of equal logarithms, so that the ratio of differences has its limit.
const EQUAL: f64 = 1e-290;
/// Difference of the outer principal values below which f₁₂₃ is of no effect.
const LEAST: f64 = 1e-15;

/// The principal values of C̄ = J^(−2/3) C at a point, without derivatives.
#[derive(Clone, Copy)]
pub(super) struct PrincipalStrain<R> {
    /// Their logarithms from the largest on; the sum is 0 [-].
    pub logs: [R; 3],
    /// The squared isochoric principal stretches themselves [-].
    pub values: Power<R>,
}

/// The powers y^k of the principal values.
#[derive(Clone, Copy)]
pub(super) struct Power<R> {
    /// Power of each principal value.
    pub of: [R; 3],
    /// y₁ᵏ − y₂ᵏ and y₃ᵏ − y₂ᵏ; where they are zero, in the ratio of their limits.
    pub differences: [R; 2],
    /// Σ y^k − 3, to nearly full relative accuracy.
    pub excess: R,
}

impl<R: Real> PrincipalStrain<R> {
    /// From the largest principal values of C̄ and of C̄⁻¹, in closed form.
    #[inline(always)]
    pub fn new(k: &Kinematics<R>) -> Self {
        let j23 = k.j23_m1() + 1.0;
        let (x1, _) = eval_first_invariant(1.0, k);
        let (x2, _) = eval_second_invariant(1.0, k);
        let most = log_of_largest(x1, &k.dev_C, j23);
        let least = -log_of_largest(x2, &k.dev_cof_C, j23 * j23);
        let logs = [most, -(most + least), least];
        Self { logs, values: Power::new(1.0, &logs) }
    }
    /// Powers yᵏ of the principal values.
    #[inline(always)]
    pub fn power(&self, k: f64) -> Power<R> {
        Power::new(k, &self.logs)
    }
    /// The factors of J^(2/3) dev C̄ = dev C and of J^(4/3) dev C̄⁻¹ = dev cof C in the deviator of the function with these differences
    /// [`Power::differences`], times J.
    #[inline(always)]
    pub fn in_strain(&self, k: &Kinematics<R>, differences: [R; 2]) -> (R, R) {
        let [above, below] = self.values.differences;
        let first = differences[0] / above;
        let outer = (above - below).max(above.constant(LEAST));
        let second = (first - differences[1] / below) / outer;
        let j23 = k.j23_m1() + 1.0;
        (second.mul_add(self.values.of[2], first) * j23, second * (j23 * j23))
    }
    /// Reciprocals of the principal values, of which each is the product of the others.
    #[inline(always)]
    pub fn reciprocals(&self) -> [R; 3] {
        let [y1, y2, y3] = self.values.of;
        [y2 * y3, y1 * y3, y1 * y2]
    }
}

impl<R: Real> Power<R> {
    /// With a = kx₂, b = k(x₁ − x₂), c = k(x₃ − x₂), 3a + b + c = 0, and eᵃ − 1 − a = A etc. the excess is
    /// `3A + B + C + (eᵃ − 1)(B + C − 3a)`: of second order, as it is.
    #[inline(always)]
    fn new(k: f64, logs: &[R; 3]) -> Self {
        let middle = logs[1] * k;
        let (e, defect) = middle.exp_m1_and_defect();
        let (above, above_defect) = ((logs[0] - logs[1]) * k).exp_m1_and_defect();
        let (below, below_defect) = ((logs[2] - logs[1]) * k).exp_m1_and_defect();
        let power = e + 1.0;
        let outer = above_defect + below_defect;
        Self {
            of: [power.mul_add(above, power), power, power.mul_add(below, power)],
            differences: [power * (above + k * EQUAL), power * (below - k * EQUAL)],
            excess: defect.mul_add(e.constant(3.0), outer) + e * (outer - middle * 3.0),
        }
    }
}

/// ln of the largest eigenvalue of `scale (mean I + s)`, whose trace is `3 + excess`; without derivatives.
#[inline(always)]
fn log_of_largest<R: Real>(excess: R, s: &Sym<R>, scale: R) -> R {
    (excess * (1.0 / 3.0) + s.largest_of_deviator() * scale).ln_1p().detached()
}
