//! Running sums of work, part of the state; `balance.rs` adds to them.

use super::branches::Branches;
use super::energy::PairLedger;
use crate::plan::{ByPair, Plan};

/// Relative rounding error of a kinetic energy, with a wide margin [-].
const ROUNDING: f64 = 1e-10;
/// Relative energy error left by the tolerances of the contact solver, of the energy present or dissipated, with a wide
/// margin [-].
const UNDONE: f64 = 1e-4;

/// Running sums of work, part of the state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Energy dissipated by bulk and shear viscosity in each body [J].
    pub viscous: Vec<f64>,
    /// Work of the forces of each branch of relaxation [J], less what was stored in eroded elements; none without relaxation.
    pub branches: Vec<f64>,
    /// Strain energy removed with the eroded elements of each body [J].
    pub eroded: Vec<f64>,
    /// Energy dissipated by the time integrator in each body [J]: implicit steps with θ > ½; negative if created. For
    /// quasi-static load steps, the difference between the work along the path and the work of the end forces.
    pub algorithmic: Vec<f64>,
    /// Work of external forces (gravity, loads, prescribed motion) on each body, with the contribution of the first
    /// half step [J].
    pub external: Vec<f64>,
    /// Work of the contact reactions on each body [J].
    pub contact_work: Vec<f64>,
    /// Strain energy introduced by the position projection in each body [J].
    pub projection: Vec<f64>,
    /// One entry for each contact pair, of many bodies for each that has touched.
    pub pairs: ByPair<PairLedger>,
    /// Kinetic + strain energy at the start [J]; set by the first step.
    pub initial: Option<f64>,
    /// Kinetic energy in the frame of the support, plus strain energy [J]: the energy available to an impact.
    pub at_hand: f64,
    /// Part of it that rounding and tolerances may have produced so far [J].
    pub stirred: f64,
    /// Available energy at the start, or when a pair first touched: the energy scale of the impact [J].
    pub available: f64,
    /// Number of pairs that have touched.
    pub touched: usize,
    /// Largest total strain energy so far [J].
    pub peak_strain: f64,
}

impl Ledger {
    /// A zero ledger for the bodies and pairs of a plan.
    pub fn new(plan: &Plan) -> Self {
        let bodies = plan.bodies.len();
        let pairs = plan.contact.as_ref().map(|contact| &contact.pairs);
        Self {
            viscous: vec![0.0; bodies],
            branches: vec![0.0; Branches::of(plan).list().len()],
            eroded: vec![0.0; bodies],
            algorithmic: vec![0.0; bodies],
            external: vec![0.0; bodies],
            contact_work: vec![0.0; bodies],
            projection: vec![0.0; bodies],
            pairs: ByPair::new(pairs, |_| PairLedger::default()),
            ..Self::default()
        }
    }

    /// Copies `other` into the existing buffers.
    pub(super) fn copy_from(&mut self, other: &Self) {
        let Self {
            viscous,
            branches,
            eroded,
            algorithmic,
            external,
            contact_work,
            projection,
            pairs,
            initial,
            at_hand,
            stirred,
            available,
            touched,
            peak_strain,
        } = self;
        viscous.clone_from(&other.viscous);
        branches.clone_from(&other.branches);
        eroded.clone_from(&other.eroded);
        algorithmic.clone_from(&other.algorithmic);
        external.clone_from(&other.external);
        contact_work.clone_from(&other.contact_work);
        projection.clone_from(&other.projection);
        pairs.copy_from(&other.pairs);
        (*initial, *touched, *peak_strain) = (other.initial, other.touched, other.peak_strain);
        (*at_hand, *stirred, *available) = (other.at_hand, other.stirred, other.available);
    }

    /// Adds the work of the forces of the branches of relaxation in a step, those at its end with a weight [-], those at its start with
    /// the rest.
    pub(super) fn add_branch_work(&mut self, branches: &Branches, weight: f64) {
        for (sum, branch) in self.branches.iter_mut().zip(branches.list()) {
            let [start, end] = branch.totals.work;
            *sum += weight * end + (1.0 - weight) * start;
        }
    }

    pub(super) fn dissipated(&self) -> f64 {
        let pairs =
            self.pairs.values().map(|p| p.friction_j + p.numerical_j.abs() + p.impact_j.abs()).sum::<f64>();
        let algorithmic = self.algorithmic.iter().map(|a| a.abs()).sum::<f64>();
        self.viscous.iter().chain(&self.eroded).sum::<f64>() + pairs + algorithmic
    }

    /// Energy scale, see [`super::Energy::scale_j`].
    pub fn scale(&self, plan: &Plan) -> f64 {
        let stirred = self.stirred.max(UNDONE * self.dissipated()).max(plan.rounding_energy);
        self.available.max(self.peak_strain).max(stirred)
    }

    /// Energy scale or total dissipation, see [`super::Energy::turnover_j`].
    pub fn turnover(&self, plan: &Plan) -> f64 {
        self.scale(plan).max(self.dissipated())
    }

    /// Whether a pair has had an impulse, by its number.
    pub(super) fn has_touched(&self, pair: u32) -> bool {
        self.pairs.get(pair as usize).is_some_and(has_impulse)
    }

    /// Updates the energy available to an impact [J], and at the first touch of a pair, that of the previous step;
    /// `kinetic` is the kinetic energy in the frame of the support [J].
    pub(super) fn note_at_hand(&mut self, at_hand: f64, kinetic: f64) {
        let touched = self.pairs.values().filter(|pair| has_impulse(pair)).count();
        if self.initial.is_none() {
            self.available = at_hand;
        } else if touched > self.touched {
            self.available = self.available.max(self.at_hand);
        }
        self.touched = touched;
        self.at_hand = at_hand;
        self.stirred = self.stirred.max(UNDONE * at_hand).max(ROUNDING * kinetic);
    }
}

fn has_impulse(pair: &PairLedger) -> bool {
    pair.impulse_n_s.iter().any(|p| *p != 0.0)
}
