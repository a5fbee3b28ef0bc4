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
//!
//! What is stored in a branch follows from the secant of the law: `g ψ |H|²/|S_iso|²`, exact for small strains, and for any
//! law where loading is sudden. The rest of the forces' work is dissipated.

use super::memory::{ElasticPoint, History, Inelastic, Memory};
use super::{Kinematics, Response};
use crate::real::Real;
use crate::tensor::Sym;

/// Largest number of branches of a series.
pub const MAX_BRANCHES: usize = 6;
/// |S_iso|² over G² below which the secant is that at rest [-].
const UNSTRAINED: f64 = 1e-20;

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
}

impl PronySeries {
    /// Where H of a branch begins in the history of a point.
    pub const fn place_of_branch(branch: usize) -> usize {
        6 * (branch + 1)
    }

    /// What a branch with `H` [Pa] adds: second Piola–Kirchhoff stress [Pa] and stored energy [J/m³].
    #[inline(always)]
    pub fn of_branch<R: Real>(&self, branch: usize, elastic: &ElasticPoint<R>, H: &Sym<R>) -> (Sym<R>, R) {
        let g = self.branches[branch].relative_modulus;
        let S = deviator_at(elastic.k, H).scaled(elastic.psi.constant(g));
        (S, H.norm_squared() * g * secant(elastic))
    }
}

impl Memory for PronySeries {
    type Step = [BranchStep; MAX_BRANCHES];
    const NONE: Self =
        Self { branches: [Branch { relative_modulus: 0.0, relaxation_time: 0.0 }; MAX_BRANCHES], count: 0 };

    /// S_iso, and H of each branch.
    fn history_len(&self) -> usize {
        if self.count == 0 { 0 } else { 6 * (1 + self.count) }
    }

    fn softens(&self) -> bool {
        false
    }
    /// Coefficients of a step; `h = 0`, at the start of a run, stands for a fully relaxed state.
    fn step(&self, h: f64) -> [BranchStep; MAX_BRANCHES] {
        let mut steps = [BranchStep::default(); MAX_BRANCHES];
        for (step, b) in steps.iter_mut().zip(self.branches()) {
            let x = h / b.relaxation_time;
            let gain = if x > 0.0 { -(-x).exp_m1() / x } else { 0.0 };
            *step = BranchStep { g: b.relative_modulus, decay: (-x).exp(), gain };
        }
        steps
    }

    #[inline(always)]
    fn update<R: Real>(
        &self,
        steps: &[BranchStep; MAX_BRANCHES],
        elastic: &ElasticPoint<R>,
        history: &mut impl History<R>,
        to: &mut Inelastic<R>,
    ) {
        let (S_iso, zero) = (&elastic.S_iso, elastic.psi.zero());
        let one = zero.constant(1.0);
        let change = S_iso.plus_scaled(-one, &history.tensor_before(0, zero));
        history.set_tensor(0, S_iso);
        let (mut sum, mut squares, mut total_g) = (Sym([zero; 6]), zero, 0.0);
        for (b, step) in steps[..self.count].iter().enumerate() {
            let place = Self::place_of_branch(b);
            let decayed = history.tensor_before(place, zero).scaled(zero.constant(step.decay));
            let H = decayed.plus_scaled(zero.constant(step.gain), &change);
            history.set_tensor(place, &H);
            sum = sum.plus_scaled(zero.constant(step.g), &H);
            squares += H.norm_squared() * step.g;
            total_g += step.g;
        }

        to.stored += squares * secant(elastic);
        to.S = to.S.plus_scaled(one, &deviator_at(elastic.k, &sum));
        // δP = δF DEV H + F δ(DEV H): by |H| and the stretches; the law's own tangent by its bound.
        let geometric = sum.norm_squared().sqrt() * elastic.condition.scale_add(4.0 / 3.0, 1.0);
        to.stiffness += elastic.stiffness_bound * total_g + geometric;
    }
}

/// ψ/|S_iso|² [1/Pa], at rest 1/(4 G).
#[inline(always)]
fn secant<R: Real>(elastic: &ElasticPoint<R>) -> R {
    let (G, square) = (elastic.shear_modulus, elastic.S_iso.norm_squared());
    let floor = square.constant(UNSTRAINED * G * G);
    (square - floor).select_positive(elastic.psi / square.max(floor), square.constant(0.25 / G))
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
    use crate::material::{Law, NeoHookean, Volumetric};
    use crate::tensor::Tensor;

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
        assert!(PronySeries::new(&[]).unwrap().branches().is_empty());
    }
}
