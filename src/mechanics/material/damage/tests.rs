//! Energy of a tear, irreversibility, and softening together with relaxation, along paths at one point.
#![allow(clippy::float_cmp)] // exactly is what is meant

use super::*;
use crate::material::{
    Branch, Invariants, Kinematics, Law, Memories, NeoHookean, PronySeries, Volumetric, isochoric_stress,
};
use crate::tensor::Tensor;

const LAW: NeoHookean = NeoHookean { c10: 1e5, volumetric: Volumetric::Quadratic(1e8) };
const SOFTENING: Softening = Softening { onset: 2e5, fracture_energy: 4000.0 };

/// A point that is sheared by γ.
struct Point {
    memory: Memories,
    size: f64,
    history: Vec<f64>,
}

/// What it says at one shear.
struct Answer {
    /// Shear stress P_xy [Pa], stored energy [J/m³], damage [-].
    stress: f64,
    stored: f64,
    damage: f64,
    elastic: f64,
    /// In the step [J/m³].
    dissipated: f64,
}

impl History<f64> for Vec<f64> {
    fn before(&self, index: usize) -> f64 {
        self[index]
    }
    fn set(&mut self, index: usize, value: f64) {
        self[index] = value;
    }
}

impl Point {
    fn new(memory: Memories, size: f64) -> Self {
        Self { memory, size, history: vec![0.0; memory.history_len()] }
    }

    /// After a step of `h` [s] to the shear γ [-].
    fn shear(&mut self, gamma: f64, h: f64) -> Answer {
        let k = Kinematics::new(&Tensor([[0.0, gamma, 0.0], [0.0; 3], [0.0; 3]]));
        let invariants = Invariants::new(&k);
        let point = LAW.eval_with_bounds(&k, &invariants, &[]);
        let S_iso = isochoric_stress(&k, &point.response);
        let elastic = ElasticPoint {
            k: &k,
            psi: point.response.psi,
            tension: 0.0,
            S_iso,
            stiffness_bound: point.stiffness_bound,
            condition: invariants.max_C * invariants.max_C_inverse,
            size: self.size,
            shear_modulus: 2.0 * LAW.c10,
        };
        let added = self.memory.update(&LAW, &self.memory.step(h), (&elastic, &[]), &mut self.history);
        let S = S_iso.scaled(1.0 - added.damage).plus_scaled(1.0, &added.S);
        Answer {
            stress: k.F.dot_sym(&S).0[0][1],
            stored: (1.0 - added.damage) * point.response.psi + added.stored,
            dissipated: added.dissipated,
            damage: added.damage,
            elastic: point.response.psi,
        }
    }

    /// Work of the stress from γ to another, in equal increments [J/m³].
    fn work(&mut self, from: f64, to: f64) -> f64 {
        let (steps, mut work) = (40_000, 0.0);
        let mut last = self.shear(from, 1e-6).stress;
        for i in 1..=steps {
            let now = self.shear(from + (to - from) * f64::from(i) / f64::from(steps), 1e-6).stress;
            work += 0.5 * (last + now) * (to - from) / f64::from(steps);
            last = now;
        }
        work
    }
}

fn softening_only() -> Memories {
    Memories { softening: SOFTENING, ..Memories::NONE }
}

#[test]
fn nothing_softens_below_the_onset() {
    let mut point = Point::new(softening_only(), 1e-3);
    // ψ = ½ G γ² = 2e5 J/m³ at γ = √2.
    for gamma in [0.1, 1.0, 1.41, 0.3] {
        let answer = point.shear(gamma, 1e-6);
        assert_eq!(answer.damage, 0.0);
        assert_eq!(answer.stored, answer.elastic);
    }
}

#[test]
fn a_tear_consumes_the_fracture_energy_whatever_the_size_of_the_element() {
    // The last size is above G_c/ψ₀ = 20 mm, where softening begins earlier.
    for size in [1e-3, 5e-3, 18e-3, 40e-3] {
        let mut point = Point::new(softening_only(), size);
        let per_volume = SOFTENING.fracture_energy / size;
        // The residual stress, a thousandth of the elastic one, works on: 1e-3 · ½ G γ².
        let last = 40.0 * (per_volume / 2e5).sqrt();
        let residual = RESIDUAL * 0.5 * 2e5 * last * last;
        let work = point.work(0.0, last);
        assert!(
            (work - per_volume - residual).abs() < 2e-3 * per_volume,
            "{size}: {work} instead of {per_volume}"
        );
        assert!(point.shear(last, 1e-6).damage > 0.99 * (1.0 - RESIDUAL));
    }
}

#[test]
fn what_is_not_stored_is_dissipated_and_never_returns() {
    let mut point = Point::new(softening_only(), 1e-3);
    let mut sum = 0.0;
    let mut other = Point::new(softening_only(), 1e-3);
    for i in 0..=30 {
        sum += other.shear(0.1 * f64::from(i), 1e-6).dissipated;
    }
    let there = point.work(0.0, 3.0);
    let (at_peak, torn) = (point.shear(3.0, 1e-6).stored, point.shear(3.0, 1e-6).damage);
    assert!(torn > 0.1 && torn < 0.9, "{torn}");
    assert!((there - at_peak - sum).abs() < 1e-6 * there, "{there} {at_peak} {sum}");
    // Unloading and reloading below the peak: elastic, along the secant.
    let back = point.work(3.0, 0.0);
    assert!((back + at_peak).abs() < 1e-8 * at_peak, "{back} {at_peak}");
    let again = point.work(0.0, 3.0);
    assert!((again - at_peak).abs() < 1e-8 * at_peak);
    assert_eq!(point.shear(0.5, 1e-6).damage, torn);
}

#[test]
fn relaxing_stress_softens_with_the_rest() {
    let branch = Branch { relative_modulus: 1.0, relaxation_time: 10.0 };
    let prony = PronySeries::new(&[branch]).unwrap();
    let both = Memories { prony, ..softening_only() };
    let relaxing = Memories { prony, ..Memories::NONE };
    let (mut torn, mut whole) = (Point::new(both, 1e-3), Point::new(relaxing, 1e-3));
    // Sudden shear: twice the slow stress and energy; the energy of slow loading determines the onset, at γ = √2.
    for (gamma, is_damaged) in [(0.9, false), (1.4, false), (1.5, true), (2.5, true)] {
        let (torn, whole) = (torn.shear(gamma, 1e-9), whole.shear(gamma, 1e-9));
        assert_eq!(torn.damage > 0.0, is_damaged, "{gamma}");
        assert!((torn.stress - (1.0 - torn.damage) * whole.stress).abs() < 1e-12 * whole.stress);
        assert!((torn.stored - (1.0 - torn.damage) * whole.stored).abs() < 1e-12 * whole.stored);
    }
}

#[test]
fn a_step_of_no_duration_gives_the_state_that_the_history_has() {
    let prony = PronySeries::new(&[Branch { relative_modulus: 2.0, relaxation_time: 1e-3 }]).unwrap();
    let mut point = Point::new(Memories { prony, ..softening_only() }, 1e-3);
    point.shear(1.0, 1e-4);
    let then = point.shear(1.9, 3e-4);
    let history = point.history.clone();
    let requested = point.shear(1.9, 0.0);
    assert_eq!(
        [requested.stress, requested.stored, requested.damage],
        [then.stress, then.stored, then.damage]
    );
    assert_eq!(point.history, history);
}
