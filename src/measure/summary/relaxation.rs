//! Energy of the branches of relaxation in the summary.

use super::written::{number, seconds};
use crate::plan::Plan;
use crate::step::{BranchEnergy, Energy};
use serde::{Deserialize, Serialize};

/// Energy of a branch of the Prony series of a body, of all its parts with this relaxation time, at the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RelaxationOfBody {
    /// Name of the body, as in the scene.
    pub body: String,
    /// Relaxation time of the branch [s].
    pub relaxation_time_s: f64,
    /// Energy stored in the branch [J].
    pub stored_j: f64,
    /// Energy dissipated by it [J].
    pub dissipated_j: f64,
}

/// All branches, body by body in the order of the plan.
pub(super) fn relaxation(energy: &Energy, plan: &Plan) -> Vec<RelaxationOfBody> {
    let of_branch = |branch: &BranchEnergy| {
        Some(RelaxationOfBody {
            body: plan.bodies.get(branch.body)?.name.clone(),
            relaxation_time_s: branch.relaxation_time_s,
            stored_j: branch.stored_j,
            dissipated_j: branch.dissipated_j,
        })
    };
    energy.branches.iter().filter_map(of_branch).collect()
}

impl RelaxationOfBody {
    /// Title of its row in the table.
    pub fn title(&self) -> String {
        format!("relaxation of {} over {}", self.body, seconds(self.relaxation_time_s))
    }

    /// Dissipated and stored energy as text.
    pub fn in_words(&self) -> String {
        format!("{} J dissipated, {} J stored", number(self.dissipated_j), number(self.stored_j))
    }
}
