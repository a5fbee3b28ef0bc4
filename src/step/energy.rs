//! Energies and momenta of bodies and contact pairs at one time.

use super::branches::Branches;
use crate::plan::{ByPair, Plan};
use serde::Serialize;

/// Running sums of one contact pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PairLedger {
    /// Impulse on the slave so far [N s], x, y, z.
    pub impulse_n_s: [f64; 3],
    /// Energy dissipated by friction so far [J].
    pub friction_j: f64,
    /// Numerical contact dissipation so far [J]: loss of lumped contact nodes at impact activation; in quasi-static steps what opening and
    /// closing gaps leave, of either sign.
    pub numerical_j: f64,
    /// Energy lost so far by rigid bodies stopped by a plane or by each other, according to their impact law: they do
    /// not rebound [J].
    pub impact_j: f64,
    /// Work on the slave's body so far [J].
    pub work_on_slave_j: f64,
    /// Work on the master's body so far [J].
    pub work_on_master_j: f64,
}

/// Energies and momenta of one body at t_n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BodyEnergy {
    /// Kinetic energy, `½ v₋ᵀ M v₊` including the rigid-body velocity V, and the rotation of a rigid body [J].
    pub kinetic_j: f64,
    /// Strain energy, ∫ψ dV, including that of the stabilisation of one-point elements, of Prony series branches and
    /// of internal variables [J].
    pub strain_j: f64,
    /// Part of the strain energy in the stabilisation [J]; 0 in formulations that need none.
    pub hourglass_j: f64,
    /// Part of the strain energy in the branches of Prony series and in internal variables [J], less what is lost by softening.
    pub branches_j: f64,
    /// Energy dissipated by bulk and shear viscosity, relaxation and softening so far [J].
    pub viscous_j: f64,
    /// Strain energy removed with eroded elements so far [J].
    pub eroded_j: f64,
    /// Energy dissipated by the time integrator so far, negative if created [J]; 0 in explicit runs.
    pub algorithmic_j: f64,
    /// Work of the contact reactions on the body so far [J].
    pub contact_work_j: f64,
    /// Work of external forces on the body so far, with the contribution of the first half step [J].
    pub external_work_j: f64,
    /// Strain energy introduced by the position projection so far [J].
    pub projection_j: f64,
    /// Linear momentum [kg m/s].
    pub momentum_kg_m_per_s: [f64; 3],
}

/// Energy of a branch of the Prony series of a body at t_n; of all its parts that relax with this time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BranchEnergy {
    /// Index of the body.
    pub body: usize,
    /// Relaxation time τ [s].
    pub relaxation_time_s: f64,
    /// Energy stored in the branch [J], part of [`BodyEnergy::branches_j`].
    pub stored_j: f64,
    /// Energy dissipated by it so far [J], part of [`BodyEnergy::viscous_j`]: work of its forces less what is stored.
    pub dissipated_j: f64,
}

/// The ledger at t_n.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// One entry for each body.
    pub bodies: Vec<BodyEnergy>,
    /// One entry for each relaxation time of each body.
    pub branches: Vec<BranchEnergy>,
    /// One entry for each contact pair, of many bodies for each that has touched.
    pub pairs: ByPair<PairLedger>,
    /// Sum of kinetic and strain energy and of all dissipation: viscous, erosion, algorithmic, friction, impact,
    /// numerical contact [J].
    pub total_j: f64,
    /// Kinetic and strain energy at the start [J].
    pub initial_total_j: f64,
    /// Work of external forces and of the position projection so far [J].
    pub external_work_j: f64,
    /// Energy scale of the impact, to which errors are related [J]: the maximum of K + strain at the start, K + strain
    /// when a pair first touched, and the peak strain energy; at least the level of rounding. K refers to the frame of
    /// the supports, or else of the common centre of mass, so errors do not depend on the observer. A long fall or
    /// slide does not increase it.
    pub scale_j: f64,
    /// The scale, or the total dissipation if that is larger [J]: reference for losses that accumulate over time.
    pub turnover_j: f64,
    /// |total − initial − external| / scale [-].
    pub balance_error: f64,
    /// Linear momentum [kg m/s].
    pub momentum_kg_m_per_s: [f64; 3],
    /// Angular momentum about the origin [kg m²/s].
    pub angular_momentum_kg_m2_per_s: [f64; 3],
}

/// What a turnover is, in words: the energy of the impact, unless more than that was dissipated, as where weight or driven nodes do work.
pub(super) fn turnover_in_words(scale_j: f64, turnover_j: f64) -> &'static str {
    if turnover_j > scale_j { "all energy that was lost" } else { "the energy of the impact" }
}

impl Energy {
    /// A zero ledger with capacity for the bodies and pairs of a plan.
    pub fn with_capacity(plan: &Plan) -> Self {
        let pairs = plan.contact.as_ref().map(|contact| &contact.pairs);
        let pairs = ByPair::new(pairs, |_| PairLedger::default());
        let bodies = Vec::with_capacity(plan.bodies.len());
        let branches = Vec::with_capacity(Branches::of(plan).list().len());
        Self { bodies, branches, pairs, ..Self::default() }
    }
    /// What the turnover is, in words, where a loss is a share of it.
    pub fn turnover_in_words(&self) -> &'static str {
        turnover_in_words(self.scale_j, self.turnover_j)
    }
    /// Copies `other` into the existing buffers.
    pub fn copy_from(&mut self, other: &Self) {
        let (mut bodies, mut pairs) = (std::mem::take(&mut self.bodies), std::mem::take(&mut self.pairs));
        let mut branches = std::mem::take(&mut self.branches);
        bodies.clone_from(&other.bodies);
        branches.clone_from(&other.branches);
        pairs.copy_from(&other.pairs);
        *self = Self { bodies, branches, pairs, ..*other };
    }
    /// Kinetic + strain energy of a body, plus its dissipation by viscosity, erosion and the time integrator [J].
    pub fn of_body(&self, body: usize) -> f64 {
        let b = &self.bodies[body];
        b.kinetic_j + b.strain_j + b.viscous_j + b.eroded_j + b.algorithmic_j
    }
    /// Least loss at contacts so far [J]; below zero, they created energy. What load steps leave at contacts has either sign and does not count.
    pub fn least_contact_loss_j(&self, is_static: bool) -> f64 {
        if is_static { self.impact_j() } else { self.numerical_contact_j().min(self.impact_j()) }
    }
    /// Energy dissipated by the time integrator in all bodies [J].
    pub fn algorithmic_j(&self) -> f64 {
        self.bodies.iter().map(|b| b.algorithmic_j).sum()
    }
    /// Numerical contact dissipation of all pairs [J].
    pub fn numerical_contact_j(&self) -> f64 {
        self.pairs.values().map(|p| p.numerical_j).sum()
    }
    /// Energy lost by impacts of rigid bodies, all pairs [J].
    pub fn impact_j(&self) -> f64 {
        self.pairs.values().map(|p| p.impact_j).sum()
    }
}
