//! `/energy`: the energy ledger.

use super::proto::contuse::{BodyEnergy, BranchEnergy, Energy, PairEnergy};
use crate::measure::Measures;
use crate::plan::Plan;

/// Topic of the energy ledger.
pub const TOPIC: &str = "/energy";
/// Schema of the energy ledger.
pub const SCHEMA: &str = "contuse.v1.Energy";

/// The message of the latest measured step.
pub fn message(plan: &Plan, measures: &Measures) -> Energy {
    let ledger = &measures.energy;
    let branches_of = |index: usize| {
        let of_body = ledger.branches.iter().filter(move |branch| branch.body == index);
        of_body.map(|branch| BranchEnergy {
            relaxation_time_s: branch.relaxation_time_s,
            stored_j: branch.stored_j,
            dissipated_j: branch.dissipated_j,
        })
    };
    let bodies = plan.bodies.iter().zip(&ledger.bodies).enumerate().map(|(index, (body, e))| BodyEnergy {
        body: body.name.clone(),
        kinetic_j: e.kinetic_j,
        strain_j: e.strain_j,
        branches_j: e.branches_j,
        eroded_j: e.eroded_j,
        viscous_j: e.viscous_j,
        contact_work_j: e.contact_work_j,
        external_work_j: e.external_work_j,
        projection_j: e.projection_j,
        hourglass_j: e.hourglass_j,
        algorithmic_j: e.algorithmic_j,
        branches: branches_of(index).collect(),
    });
    // The ledger has no pairs before the first step.
    let pairs = measures.listed_pairs().filter_map(|(index, pair)| {
        let e = ledger.pairs.get(index)?;
        Some(PairEnergy {
            pair: pair.name.clone(),
            friction_j: e.friction_j,
            numerical_contact_j: e.numerical_j,
            work_on_slave_j: e.work_on_slave_j,
            work_on_master_j: e.work_on_master_j,
            impact_j: e.impact_j,
        })
    });
    let absorbed = measures.absorbed.as_ref().map(|a| a.now).unwrap_or_default();
    Energy {
        time_s: measures.time,
        step: measures.step,
        bodies: bodies.collect(),
        pairs: pairs.collect(),
        total_j: ledger.total_j,
        initial_total_j: ledger.initial_total_j,
        external_work_j: ledger.external_work_j,
        balance_error: ledger.balance_error,
        absorbed_by_tissue_j: absorbed.by_state(),
        absorbed_by_tissue_work_j: absorbed.work,
        momentum_kg_m_per_s: Some(ledger.momentum_kg_m_per_s.into()),
        angular_momentum_kg_m2_per_s: Some(ledger.angular_momentum_kg_m2_per_s.into()),
    }
}
