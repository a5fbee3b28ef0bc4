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
//! A branch is relaxed at the stress `S_iso − H`, and stores the work from there. The secant stiffness `k(|S_iso|) = |S_iso|²/ψ` grows linearly
//! with the stress of a law that stiffens exponentially; at the sum of the stresses of both ends it gives the stored energy
//!
//! ```text
//! g |H|²/k(|S_iso| + |S_iso − H|)
//! ```
//!
//! exact for small strains, and for any law where loading is sudden. Between the stress now and the largest so far, which a point remembers
//! with its k, and beyond, k is taken as linear. The rest of the forces' work is dissipated; it is negative only for a moment, by up to a tenth of
//! the work, where tissue that has relaxed in a large strain is loaded and released suddenly: quasi-linear viscoelasticity has no energy there.

use super::memory::{ElasticPoint, History, Inelastic, Memory};
use super::{Kinematics, Response};
use crate::real::Real;
use crate::tensor::Sym;

/// Largest number of branches of a series.
pub const MAX_BRANCHES: usize = 6;
/// |S_iso|² over G² below which the secant is that at rest [-].
const UNSTRAINED: f64 = 1e-20;
/// |S_iso| over G by which two stresses differ at least [-].
const DISTINCT: f64 = 1e-12;
/// Numbers beside S_iso and the H: the largest |S_iso| so far, and its k.
const OF_STIFFNESS: usize = 2;

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

/// The secant stiffness k of a law at a point, over its stress.
#[derive(Clone, Copy, Debug)]
pub struct SecantStiffness<R> {
    /// |S_iso| now, and its k [Pa].
    now: [R; 2],
    /// The largest |S_iso| so far, and its k [Pa].
    largest: [R; 2],
    /// Shear modulus at rest [Pa].
    shear_modulus: f64,
}

impl<R: Real> SecantStiffness<R> {
    /// At a point whose largest stress so far, and k there, were these.
    #[inline(always)]
    fn new(elastic: &ElasticPoint<R>, largest: [R; 2]) -> Self {
        let (G, square) = (elastic.shear_modulus, elastic.S_iso.norm_squared());
        let floor = square.constant(UNSTRAINED * G * G);
        let at_rest = square.constant(4.0 * G);
        let k = (square - floor).select_positive(square.max(floor) / elastic.psi, at_rest);
        let now = [square.sqrt(), k];
        let is_less = largest[0] - now[0];
        // Written out: a closure of `map` would be compiled without the instruction set of the kernel.
        let largest =
            [is_less.select_positive(largest[0], now[0]), is_less.select_positive(largest[1], now[1])];
        Self { now, largest, shear_modulus: G }
    }

    /// From the history of a point at t_n, whose numbers of the series begin at 0.
    #[inline(always)]
    pub fn remembered(elastic: &ElasticPoint<R>, branches: usize, number: impl Fn(usize) -> R) -> Self {
        let place = PronySeries::place_of_branch(branches);
        Self::new(elastic, [number(place), number(place + 1)])
    }

    /// k at a stress of at least that now [Pa].
    #[inline(always)]
    fn at(&self, stress: R) -> R {
        let ([now, k], [largest, k_largest]) = (self.now, self.largest);
        let distinct = now.constant(DISTINCT * self.shear_modulus);
        let one = now.constant(1.0);
        // Between now and the largest so far.
        let ahead = largest - now;
        let fraction = ((stress - now) / ahead.max(distinct)).min(one);
        let between = (ahead - distinct).select_positive((k_largest - k).mul_add(fraction, k), k_largest);
        // Beyond: as from rest to the largest, where the law stiffens.
        let rise =
            (k_largest - now.constant(4.0 * self.shear_modulus)).max(now.zero()) / largest.max(distinct);
        between + rise * (stress - largest).max(now.zero())
    }

    /// What a branch with `H` [Pa] stores, over its relative modulus [J/m³].
    #[inline(always)]
    fn stored(&self, S_iso: &Sym<R>, H: &Sym<R>) -> R {
        let relaxed = S_iso.plus_scaled(-H.0[0].constant(1.0), H).norm_squared().sqrt();
        H.norm_squared() / self.at(self.now[0] + relaxed)
    }
}

impl PronySeries {
    /// Where H of a branch begins in the history of a point.
    pub const fn place_of_branch(branch: usize) -> usize {
        6 * (branch + 1)
    }

    /// What a branch with `H` [Pa] adds: second Piola–Kirchhoff stress [Pa] and stored energy [J/m³].
    #[inline(always)]
    pub fn of_branch<R: Real>(
        &self,
        branch: usize,
        (elastic, stiffness): (&ElasticPoint<R>, &SecantStiffness<R>),
        H: &Sym<R>,
    ) -> (Sym<R>, R) {
        let g = self.branches[branch].relative_modulus;
        let S = deviator_at(elastic.k, H).scaled(elastic.psi.constant(g));
        (S, stiffness.stored(&elastic.S_iso, H) * g)
    }
}

impl Memory for PronySeries {
    type Step = [BranchStep; MAX_BRANCHES];
    const NONE: Self =
        Self { branches: [Branch { relative_modulus: 0.0, relaxation_time: 0.0 }; MAX_BRANCHES], count: 0 };

    fn title(&self) -> String {
        format!("Prony series of {}", self.count)
    }

    /// S_iso, H of each branch, the largest |S_iso| so far and its k.
    fn history_len(&self) -> usize {
        if self.count == 0 { 0 } else { 6 * (1 + self.count) + OF_STIFFNESS }
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
        let stiffness = SecantStiffness::remembered(elastic, self.count, |index| history.before(index));
        for (i, number) in stiffness.largest.into_iter().enumerate() {
            history.set(Self::place_of_branch(self.count) + i, number);
        }
        let (mut sum, mut total_g) = (Sym([zero; 6]), 0.0);
        for (b, step) in steps[..self.count].iter().enumerate() {
            let place = Self::place_of_branch(b);
            let decayed = history.tensor_before(place, zero).scaled(zero.constant(step.decay));
            let H = decayed.plus_scaled(zero.constant(step.gain), &change);
            history.set_tensor(place, &H);
            sum = sum.plus_scaled(zero.constant(step.g), &H);
            to.stored += stiffness.stored(S_iso, &H) * step.g;
            total_g += step.g;
        }

        to.S = to.S.plus_scaled(one, &deviator_at(elastic.k, &sum));
        // δP = δF DEV H + F δ(DEV H): by |H| and the stretches; the law's own tangent by its bound.
        let geometric = sum.norm_squared().sqrt() * elastic.condition.scale_add(4.0 / 3.0, 1.0);
        to.stiffness += elastic.stiffness_bound * total_g + geometric;
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
    use crate::material::{Law, NeoHookean, Ogden, OgdenTerm, Volumetric};
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

    /// Work of the branches, and what they store of it [J/m³], after each step of a path of (duration [s], final stretch).
    fn energies(law: &Ogden, series: PronySeries, path: &[(f64, f64)]) -> Vec<[f64; 3]> {
        let (G, _) = law.moduli_at_rest();
        let mut history = vec![0.0; series.history_len()];
        let (mut at, mut work, mut before) = (1.0_f64, 0.0, (Sym([0.0; 6]), Tensor([[0.0; 3]; 3])));
        let mut all = Vec::new();
        for &(duration, end) in path {
            let start = at;
            for i in 1..=STEPS {
                at = start + (end - start) * f64::from(i) / f64::from(STEPS);
                let side = at.powf(-0.5);
                let H = Tensor([[at - 1.0, 0.0, 0.0], [0.0, side - 1.0, 0.0], [0.0, 0.0, side - 1.0]]);
                let k = Kinematics::new(&H);
                let response = law.eval(&k, &[]);
                let elastic = ElasticPoint {
                    k: &k,
                    psi: response.psi,
                    tension: 0.0,
                    S_iso: isochoric_stress(&k, &response),
                    stiffness_bound: 0.0,
                    condition: 1.0,
                    size: 1.0,
                    shear_modulus: G,
                };
                let none = Sym([0.0; 6]);
                let mut to = Inelastic { S: none, stored: 0.0, stiffness: 0.0, damage: 0.0, dissipated: 0.0 };
                series.update(&series.step(duration / f64::from(STEPS)), &elastic, &mut history, &mut to);
                // By the mean stress and the change of the Green–Lagrange strain.
                let mean = to.S.plus_scaled(1.0, &before.0);
                let strain = |H: &Tensor<f64>| [0, 1, 2].map(|i| H.0[i][i] + 0.5 * H.0[i][i].powi(2));
                let (now, then) = (strain(&H), strain(&before.1));
                work += (0..3).map(|i| 0.5 * mean.0[i] * (now[i] - then[i])).sum::<f64>();
                before = (to.S, H);
                all.push([work, to.stored, response.psi]);
            }
        }
        all
    }

    const STEPS: u32 = 500;

    #[test]
    fn branches_never_store_more_than_the_work_on_them() {
        // Fat of the library, whose stiffness rises by orders of magnitude; and a law that softens in this measure of stress.
        let ogden = |mu, alpha| Ogden::new(&[OgdenTerm { mu, alpha }], Volumetric::Quadratic(1e8)).unwrap();
        let branch = |(g, tau)| Branch { relative_modulus: g, relaxation_time: tau };
        let one = PronySeries::new(&[branch((10.0, 3.2e-3))]).unwrap();
        let three = PronySeries::new(&[(2.3, 0.17), (5.1, 0.02), (6.3, 1.7e-3)].map(branch)).unwrap();
        let paths: [&[(f64, f64)]; 7] = [
            &[(1e-3, 0.4), (9e-3, 0.4), (1e-3, 0.8)],
            &[(5e-3, 1.6), (5e-3, 1.0)],
            &[(2e-3, 0.7), (2e-2, 0.7), (2e-3, 1.0)],
            &[(1e-2, 0.6), (1e-2, 1.0)],
            &[(2e-3, 0.6), (2e-3, 1.3), (2e-3, 0.7), (2e-3, 1.0)],
            // Relaxed in a strain, then sudden: the energy is an estimate.
            &[(1.0, 0.6), (1e-4, 1.0)],
            &[(1.0, 0.8), (1e-4, 0.6), (1e-2, 0.6), (1e-4, 0.9)],
        ];
        for law in [ogden(30.0, 20.0), ogden(4000.0, 1.0)] {
            for (series, (number, path)) in
                [one, three].into_iter().flat_map(|s| paths.into_iter().enumerate().map(move |p| (s, p)))
            {
                let allowed = [1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 0.01, 0.11][number];
                let all = energies(&law, series, path);
                let most = all.iter().map(|[work, ..]| work.abs()).fold(0.0, f64::max);
                for [work, stored, _] in &all {
                    assert!(
                        *stored >= 0.0 && work - stored >= -allowed * most,
                        "{path:?}: {work} {stored} of {most}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_is_stored_suddenly_is_the_energy_of_the_law() {
        let law = Ogden::new(&[OgdenTerm { mu: 30.0, alpha: 20.0 }], Volumetric::Quadratic(1e8)).unwrap();
        let slow = PronySeries::new(&[Branch { relative_modulus: 2.0, relaxation_time: 1e6 }]).unwrap();
        let [work, stored, psi] = *energies(&law, slow, &[(1e-6, 0.6)]).last().unwrap();
        assert!((stored / (2.0 * psi) - 1.0).abs() < 1e-9, "{stored} {psi}");
        assert!((work / stored - 1.0).abs() < 1e-3, "{work} {stored}");
    }

    #[test]
    fn too_many_branches_are_refused() {
        assert!(PronySeries::new(&[Branch::default(); MAX_BRANCHES + 1]).is_none());
        assert!(PronySeries::new(&[]).unwrap().branches().is_empty());
    }
}
