//! Rigid bodies of a plan.

use super::{ContactPlan, Plan, PlanBody};
use crate::mechanics::rigid::{Pose, RigidBody, Rotation};
use crate::mechanics::tensor::Vec3;
use serde::{Deserialize, Serialize};

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

impl Plan {
    /// Rigid bodies of the plan; may be empty.
    pub fn rigid_bodies(&self) -> &[RigidBody] {
        self.rigid.as_ref().map_or(&[], |rigid| &rigid.bodies)
    }

    /// Pose of a rigid body at a time [s] with displacement `u` [m] of its centre.
    pub fn pose(
        &self,
        rigid: &RigidPlan,
        index: usize,
        time: f64,
        u: &[Vec3],
        orientation: Rotation,
    ) -> Pose {
        let centre = rigid.bodies[index].centre as usize;
        Pose { centre: self.position(rigid.of_body[index], centre, time, &u[centre]), orientation }
    }
}

/// Report of a rigid body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RigidReport {
    /// Name of the body.
    pub body: String,
    /// Name of its shape.
    pub shape: String,
    /// Mass of the body [kg].
    pub mass_kg: f64,
    /// Principal moments of inertia [kg m²], about the axes of the shape.
    pub inertia_kg_m2: [f64; 3],
}

impl RigidReport {
    /// Reports of all rigid bodies of a plan.
    pub(super) fn of(plan: &Plan) -> Vec<Self> {
        let Some(rigid) = &plan.rigid else { return Vec::new() };
        let of_body = |(body, &index): (&RigidBody, &usize)| Self {
            body: plan.bodies[index].name.clone(),
            shape: body.shape.name().into(),
            mass_kg: body.mass,
            inertia_kg_m2: body.inertia.into(),
        };
        rigid.bodies.iter().zip(&rigid.of_body).map(of_body).collect()
    }

    pub(super) fn in_words(&self) -> String {
        format!("{}: rigid {}, {:.4e} kg, six unknowns", self.body, self.shape, self.mass_kg)
    }
}
