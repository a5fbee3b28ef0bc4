//! Branches of Prony series as the ledger counts them: those of one body with the same relaxation time are one.

use crate::mechanics::force::{BranchTotals, ElementForces};
use crate::plan::Plan;

/// The branches of a plan, with their energies in the last evaluation; none without relaxation.
#[derive(Clone, Debug, Default)]
pub(super) struct Branches {
    list: Vec<BranchOfBody>,
    /// For each block and its branches in order, their index in the list.
    places: Vec<(usize, usize, usize)>,
    /// Energy in all branches of each body in the last evaluation, less what is lost by softening [J].
    of_bodies: Vec<f64>,
}

/// One branch of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct BranchOfBody {
    /// Index of the body.
    pub body: usize,
    /// Relaxation time τ [s].
    pub relaxation_time: f64,
    /// Energies in the last evaluation.
    pub totals: BranchTotals,
}

impl Branches {
    /// The branches of a plan.
    pub fn of(plan: &Plan) -> Self {
        let mut branches = Self { of_bodies: vec![0.0; plan.bodies.len()], ..Self::default() };
        for (block_index, block) in plan.blocks.iter().enumerate() {
            for (index, branch) in block.parameters.memory.branches().iter().enumerate() {
                let is_same = |known: &BranchOfBody| {
                    known.body == block.body
                        && known.relaxation_time.total_cmp(&branch.relaxation_time).is_eq()
                };
                let place = branches.list.iter().position(is_same).unwrap_or(branches.list.len());
                if place == branches.list.len() {
                    branches.list.push(BranchOfBody {
                        body: block.body,
                        relaxation_time: branch.relaxation_time,
                        totals: BranchTotals::default(),
                    });
                }
                branches.places.push((block_index, index, place));
            }
        }
        branches
    }

    /// Takes the energies of an evaluation.
    pub fn evaluate(&mut self, plan: &Plan, forces: &ElementForces) {
        self.of_bodies.fill(0.0);
        for (index, block) in plan.blocks.iter().enumerate() {
            self.of_bodies[block.body] += forces.totals(index).branches;
        }
        for branch in &mut self.list {
            branch.totals = BranchTotals::default();
        }
        for (block, index, place) in &self.places {
            self.list[*place].totals.add(&forces.branch_totals(*block, *index));
        }
    }

    /// Energy that memories store in each body [J]; of Prony series that in all branches, less what is lost by softening.
    pub fn of_bodies(&self) -> &[f64] {
        &self.of_bodies
    }

    /// That of one body [J].
    pub fn of_body(&self, body: usize) -> f64 {
        self.of_bodies.get(body).copied().unwrap_or_default()
    }

    /// All branches, body by body.
    pub fn list(&self) -> &[BranchOfBody] {
        &self.list
    }

    /// Index of a branch of a block in the list.
    pub fn place(&self, block: usize, branch: usize) -> Option<usize> {
        self.places.iter().find(|(b, index, _)| (*b, *index) == (block, branch)).map(|(_, _, place)| *place)
    }
}
