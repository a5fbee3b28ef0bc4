//! Forces and motion of one step, from which its work is evaluated.

use super::branches::Branches;
use super::rigid::RigidWork;
use super::state::State;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::force::Activity;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;

/// Everything that the ledger needs of the step around t_n.
#[derive(Clone, Copy)]
pub(super) struct StepWork<'a> {
    pub plan: &'a Plan,
    pub state: &'a State,
    pub v_after: &'a [Vec3],
    /// Mean step h̄ [s].
    pub mean_step: f64,
    /// h₊ − h₋ [s]; 0 if velocities are known at t_n itself.
    pub step_change: f64,
    /// Internal forces at t_n [N], nodes × 3; not used if the step size does not change.
    pub f_int: &'a [Vec3],
    pub contacts: &'a [Contact],
    pub reactions: &'a [Reaction],
    /// Effective gravity in the step [m/s²].
    pub gravity: Vec3,
    /// Forces of loads in the step [N], nodes × 3; empty when there are none.
    pub f_ext: &'a [Vec3],
    /// Impulses on the prescribed components of the plan, one each [N s].
    pub prescribed: &'a [f64],
    /// Strain energy of each body at t_n [J].
    pub strain: &'a [f64],
    /// Part of it in the stabilisation [J].
    pub hourglass: &'a [f64],
    /// Part of it in the branches of Prony series.
    pub branches: &'a Branches,
    /// Nodes that move relative to their bodies' flight.
    pub activity: &'a Activity,
    /// Rigid bodies, if there are any.
    pub rigid: Option<RigidWork<'a>>,
}

impl StepWork<'_> {
    /// The same before any work is done: the initial velocities stand on both sides.
    pub fn at_the_start(&self) -> Self {
        Self { v_after: &self.state.v, step_change: 0.0, ..*self }
    }
}

/// Which half of the work at t_n is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Half {
    /// The half with v₋, before t_n.
    Before,
    /// The half with v₊, after t_n.
    After,
}
