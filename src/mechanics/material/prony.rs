//! Prony series: fading memory of the isochoric stress of any law (quasi-linear viscoelasticity; Fung 1981, Simo 1987).
//!
//! ```text
//! S(t) = S∞ + Σ_i g_i DEV H_i        Ḣ_i + H_i/τ_i = dS_iso/dt        DEV H = H − ⅓ (H : C) C⁻¹
//! ```
//!
//! with S∞ the stress of the law, whose constants are those of slow loading, and S_iso its part without the pressure
//! `U′`. For small strains the relaxation modulus is `G(t) = G∞ (1 + Σ_i g_i e^(−t/τ_i))`. The recursion over a step
//! h is exact where S_iso is linear in time, and second-order accurate elsewhere:
//!
//! ```text
//! H_i⁺ = e^(−h/τ_i) H_i + (1 − e^(−h/τ_i)) τ_i/h (S_iso⁺ − S_iso)
//! ```

use super::{Kinematics, Response};
use crate::mechanics::real::Real;
use crate::mechanics::tensor::Sym;

/// Largest number of branches of a series.
pub const MAX_BRANCHES: usize = 6;

/// One term of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Branch {
    /// Modulus g relative to that of slow loading [-].
    pub relative_modulus: f64,
    /// Relaxation time τ [s].
    pub relaxation_time: f64,
}

/// A Prony series; without branches there is no memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PronySeries {
    branches: [Branch; MAX_BRANCHES],
    count: usize,
}

/// Coefficients of a branch in one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct BranchStep {
    /// Relative modulus g [-].
    pub g: f64,
    /// Decay e^(−h/τ) of the branch in the step [-].
    pub decay: f64,
    /// (1 − e^(−h/τ)) τ/h [-].
    pub gain: f64,
}

impl PronySeries {
    /// A material without memory.
    pub const NONE: Self =
        Self { branches: [Branch { relative_modulus: 0.0, relaxation_time: 0.0 }; MAX_BRANCHES], count: 0 };

    /// A series, `None` if it has more than [`MAX_BRANCHES`].
    pub fn new(branches: &[Branch]) -> Option<Self> {
        let mut series = Self { count: branches.len(), ..Self::NONE };
        series.branches.get_mut(..branches.len())?.copy_from_slice(branches);
        Some(series)
    }

    /// Branches of the series, at most [`MAX_BRANCHES`].
    pub fn branches(&self) -> &[Branch] {
        &self.branches[..self.count]
    }

    /// Whether it has no branch.
    pub fn is_none(&self) -> bool {
        self.count == 0
    }

    /// Sum of the relative moduli [-]: the instantaneous stress is 1 + Σg times that of slow loading.
    pub fn sum(&self) -> f64 {
        self.branches().iter().map(|b| b.relative_modulus).sum()
    }

    /// Number of symmetric history tensors at a point: S_iso, and H of each branch.
    pub fn history_len(&self) -> usize {
        if self.is_none() { 0 } else { 1 + self.count }
    }

    /// Coefficients of a step of `h` [s]; `h = 0`, at the start of a run, stands for a fully relaxed state.
    pub fn step(&self, h: f64) -> [BranchStep; MAX_BRANCHES] {
        let mut steps = [BranchStep::default(); MAX_BRANCHES];
        for (step, b) in steps.iter_mut().zip(self.branches()) {
            let x = h / b.relaxation_time;
            let gain = if x > 0.0 { -(-x).exp_m1() / x } else { 0.0 };
            *step = BranchStep { g: b.relative_modulus, decay: (-x).exp(), gain };
        }
        steps
    }
}

/// S_iso [Pa], the second Piola–Kirchhoff stress of a response without the pressure: `cof C matrix / J + S_fibres`.
#[inline(always)]
pub fn isochoric_stress<R: Real>(k: &Kinematics<R>, response: &Response<R>) -> Sym<R> {
    // The matrix is a function of C, so that both commute.
    let S = k.dev_cof_C.plus_diagonal(k.mean_cof_C).dot_commuting(&response.matrix).scaled(k.J_inverse);
    match &response.fibres {
        Some(fibres) => S.plus_scaled(k.J.constant(1.0), fibres),
        None => S,
    }
}

/// Deviator in the current configuration, DEV H = H − ⅓ (H : C) C⁻¹.
#[inline(always)]
pub fn deviator_at<R: Real>(k: &Kinematics<R>, H: &Sym<R>) -> Sym<R> {
    let C = k.dev_C.plus_diagonal(k.mean_C);
    let cof_C = k.dev_cof_C.plus_diagonal(k.mean_cof_C);
    let along = H.double_dot(&C) * (k.J_inverse * k.J_inverse) * (-1.0 / 3.0);
    H.plus_scaled(along, &cof_C)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::material::{Law, NeoHookean, Volumetric};
    use crate::mechanics::tensor::Tensor;

    fn series() -> PronySeries {
        let branch = |(g, tau)| Branch { relative_modulus: g, relaxation_time: tau };
        PronySeries::new(&[(0.5, 0.1), (2.0, 3.0)].map(branch)).unwrap()
    }

    #[test]
    fn one_step_of_a_ramp_is_exact_however_long() {
        // S = r t: H = r τ (1 − e^(−t/τ)).
        for h in [1e-6, 0.05, 1.0, 40.0] {
            for (step, branch) in series().step(h).iter().zip(series().branches()) {
                let tau = branch.relaxation_time;
                let exact = -tau * (-h / tau).exp_m1();
                assert!((step.gain * h - exact).abs() <= 1e-12 * exact, "h = {h}");
            }
        }
    }

    #[test]
    fn the_isochoric_stress_is_that_of_the_law() {
        let law = NeoHookean { c10: 3.0, volumetric: Volumetric::Quadratic(100.0) };
        let H = Tensor([[0.2, -0.1, 0.3], [0.05, -0.15, 0.1], [-0.2, 0.02, 0.25]]);
        let k = Kinematics::new(&H);
        let response = law.eval(&k, &[]);
        let S = isochoric_stress(&k, &response);
        let (P, expected) = (k.F.dot_sym(&S), response.first_piola(&k, 0.0));
        assert!(P.plus_scaled(-1.0, &expected).double_dot(&P).abs() < 1e-13 * P.double_dot(&P));
        // It contains no pressure, so it equals its deviator.
        let rest = deviator_at(&k, &S).plus_scaled(-1.0, &S);
        assert!(rest.norm_squared() < 1e-26 * S.norm_squared());
        let C = k.dev_C.plus_diagonal(k.mean_C);
        let other = Sym([1.0, -2.0, 0.5, 0.3, 0.7, -0.4]);
        assert!(deviator_at(&k, &other).double_dot(&C).abs() < 1e-13);
    }

    #[test]
    fn too_many_branches_are_refused() {
        assert!(PronySeries::new(&[Branch::default(); MAX_BRANCHES + 1]).is_none());
        assert!(PronySeries::new(&[]).unwrap().is_none());
    }
}
