//! The rigid bodies of a plan.

use super::{ContactPlan, Plan, PlanBody};
use crate::mechanics::rigid::{Pose, RigidBody, Rotation};
use crate::mechanics::tensor::Vec3;
use serde::Serialize;

/// The rigid bodies of a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigidPlan {
    /// The bodies, in the order of the plan's.
    pub bodies: Vec<RigidBody>,
    /// Which of the plan's bodies each is.
    pub of_body: Vec<usize>,
    /// Orientations at the start, from the axes of each body to those of space.
    pub orientations: Vec<Rotation>,
    /// The rigid bodies of slave and master of each contact pair.
    pub of_pairs: Vec<[Option<u32>; 2]>,
}

impl RigidPlan {
    /// Notes which pairs the bodies are in.
    pub(super) fn note_pairs(&mut self, contact: Option<&ContactPlan>, bodies: &[PlanBody]) {
        let rigid = |body: usize| bodies[body].rigid.map(|rigid| rigid as u32);
        let of_pairs = contact.iter().flat_map(|contact| &contact.pair_bodies);
        self.of_pairs = of_pairs.map(|&(slave, master)| [rigid(slave), master.and_then(rigid)]).collect();
    }

    /// Whether both sides of a pair are rigid bodies or planes: what such a pair loses, it loses by the law of its impacts.
    pub fn has_no_mesh(&self, contact: &ContactPlan, pair: usize) -> bool {
        let [slave, master] = self.of_pairs[pair];
        slave.is_some() && (master.is_some() || contact.pair_bodies[pair].1.is_none())
    }
}

impl Plan {
    /// The rigid bodies; none when there are none.
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

/// A rigid body in figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct RigidReport {
    /// Body.
    pub body: String,
    /// Shape.
    pub shape: String,
    /// Mass [kg].
    pub mass_kg: f64,
    /// Principal moments of inertia [kg m²], about the axes of the shape.
    pub inertia_kg_m2: [f64; 3],
}

impl RigidReport {
    /// All of a plan.
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
