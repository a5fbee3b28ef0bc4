//! Rigid bodies of a plan.

use super::body::PlanBody;
use super::contact_plan::ContactPlan;
use crate::mechanics::rigid::{RigidBody, Rotation};

/// Rigid bodies of a plan, with their initial orientations and contact pairs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigidPlan {
    /// Rigid bodies, in the order of the plan's bodies.
    pub bodies: Vec<RigidBody>,
    /// For each rigid body, its index among the plan's bodies.
    pub of_body: Vec<usize>,
    /// Initial orientations, from body axes to spatial axes.
    pub orientations: Vec<Rotation>,
    /// For each contact pair with a rigid side, the rigid bodies of slave and master.
    pub of_pairs: Vec<[Option<u32>; 2]>,
    /// Number of the first of these pairs.
    pub first_pair: usize,
}

impl RigidPlan {
    /// Stores which rigid bodies take part in each contact pair.
    pub(super) fn note_pairs(&mut self, contact: Option<&ContactPlan>, bodies: &[PlanBody]) {
        let Some(contact) = contact else { return };
        let rigid = |body: usize| bodies[body].rigid.map(|rigid| rigid as u32);
        let (pairs, first) = contact.pairs.rigid();
        let sides = pairs.iter().map(|pair| contact.bodies_of(pair));
        self.of_pairs = sides.map(|(slave, master)| [rigid(slave), master.and_then(rigid)]).collect();
        self.first_pair = first;
    }

    /// The rigid bodies of slave and master of a pair.
    pub fn sides_of(&self, pair: usize) -> [Option<u32>; 2] {
        let place = pair.checked_sub(self.first_pair);
        place.and_then(|place| self.of_pairs.get(place).copied()).unwrap_or([None; 2])
    }

    /// Whether both sides of a pair are rigid bodies or planes; energy lost by such a pair follows from the impact law.
    pub fn has_no_mesh(&self, contact: &ContactPlan, pair: usize) -> bool {
        let [slave, master] = self.sides_of(pair);
        slave.is_some() && (master.is_some() || contact.bodies_of(&contact.pairs.get(pair)).1.is_none())
    }
}
