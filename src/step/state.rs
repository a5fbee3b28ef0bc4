//! All that changes from step to step, and nothing else.

use super::ledger::Ledger;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::force::{AssembledRows, ElementForces, Erosion, ForceInput};
use crate::mechanics::lanes::Row;
use crate::mechanics::rigid::Rotation;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use std::sync::Arc;

/// Capacity for projection shifts per contact: slave and master nodes in a few passes.
pub(super) const SHIFTS: usize = 8;

/// The state at time t_n. A restart or a replay is a clone of it.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time t_n [s]; negative during dynamic relaxation.
    pub time: f64,
    /// Number of steps completed.
    pub step: u64,
    /// Displacement u_n in each body's own inertial frame [m], nodes × 3: x = X + V_b max(t, 0) + u.
    pub u: Vec<Vec3>,
    /// Velocity relative to the rigid-body velocity V of the body [m/s], nodes × 3: v₋ of the last half step in explicit runs, v_n in
    /// implicit ones; for the spin of a rigid body [rad/s], in its axes.
    pub v: Vec<Vec3>,
    /// Orientation of each rigid body at t_n.
    pub orientations: Vec<Rotation>,
    /// Size of the last step [s]; 0 at the start.
    pub last_step: f64,
    /// History of the elements at t_{n−1}, in implicit runs at t_n, chunk by chunk, see [`ElementBlock::history_rows`](crate::mechanics::force::ElementBlock::history_rows).
    pub history: Vec<Vec<Row>>,
    /// What the assembled mesh leaves of the volumetric stiffness of each element in its critical time step [-], chunk by chunk; empty in
    /// implicit runs, see [`AssembledBound`](crate::mechanics::force::AssembledBound).
    pub fractions: Vec<Vec<AssembledRows>>,
    /// Elements eroded so far.
    pub erosion: Arc<Erosion>,
    /// Forces of shear viscosity at t_{n−1} [N], nodes × 3; empty if no part is viscous.
    pub viscous_force: Vec<Vec3>,
    /// Shifts [m] of nodes projected out of the other side at t_n; half of their work has been booked with the previous
    /// forces, the other half is due with the forces at t_n.
    pub projected: Vec<(u32, Vec3)>,
    /// Energy ledger up to t_n, without the work of the forces that act at t_n.
    pub ledger: Ledger,
    /// Data that an implicit run carries between steps.
    pub implicit: ImplicitMemory,
}

/// Data that an implicit run carries between steps besides the motion, so that a copy of the state restarts it with the
/// same bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImplicitMemory {
    /// Target step size [s]; 0 at the start, for that of the scene.
    pub target_step: f64,
    /// Linearisation point of the matrix used in the last step, if there was one.
    pub tangent: Option<Tangent>,
    /// In quasi-static steps, the contacts that support the bodies at t_n.
    pub held: Held,
}

/// The contacts that support bodies at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Held {
    /// Contacts of the load step that ended here.
    pub contacts: Vec<Contact>,
    /// Reactions of these contacts.
    pub reactions: Vec<Reaction>,
    /// Time over which these act [s]; 0 at the start.
    pub step: f64,
}

/// Where the matrix `S = M + ξ θ h² K(u)` of an implicit step was taken. It serves as long as Newton's iteration converges with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent {
    /// Which of the run it is, from 1.
    pub number: u64,
    /// Displacement [m], nodes × 3.
    pub u: Vec<Vec3>,
    /// Velocity [m/s], nodes × 3; empty if nothing depends on time.
    pub v: Vec<Vec3>,
    /// History of the elements, chunk by chunk; empty if nothing relaxes.
    pub history: Vec<Vec<Row>>,
    /// Step size h of the matrix [s].
    pub step: f64,
    /// The pressures on faces [Pa].
    pub pressures: Vec<f64>,
    /// Nodes whose compliance was solved for, ascending.
    pub contact_nodes: Vec<u32>,
}

impl State {
    /// The initial state of a plan (before dynamic relaxation, if there is any).
    pub fn new(plan: &Plan) -> Self {
        let nodes = plan.node_count();
        // x + 0 makes +0 of −0: what is at rest has one bit pattern.
        let or_zero = |values: &[Vec3]| {
            if values.is_empty() {
                vec![Vec3::zeros(); nodes]
            } else {
                values.iter().map(|v| v.add_scalar(0.0)).collect()
            }
        };
        Self {
            time: 0.0,
            step: 0,
            u: or_zero(&plan.initial_u),
            v: or_zero(&plan.initial_v),
            orientations: plan.rigid.as_ref().map_or_else(Vec::new, |rigid| rigid.orientations.clone()),
            last_step: 0.0,
            history: ElementForces::no_history(&plan.blocks),
            fractions: plan.fractions.clone(),
            erosion: Arc::default(),
            viscous_force: vec![Vec3::zeros(); if plan.is_viscous() { nodes } else { 0 }],
            projected: Vec::with_capacity(SHIFTS * plan.most_contacts()),
            ledger: Ledger::new(plan),
            implicit: ImplicitMemory::default(),
        }
    }

    /// Input of the internal force evaluation at t_n.
    pub(super) fn force_input(&self) -> ForceInput<'_> {
        let inverse_step = if self.last_step > 0.0 { 1.0 / self.last_step } else { 0.0 };
        ForceInput { u: &self.u, inverse_step, history: &self.history, fractions: &self.fractions, v: &[] }
    }

    /// Position x of a node [m].
    pub fn position(&self, plan: &Plan, body: usize, node: usize) -> Vec3 {
        plan.position(body, node, self.time, &self.u[node])
    }
}
