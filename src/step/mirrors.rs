//! The bodies of a sector must not reach their own mirror images: no contact would stop them there.

use super::failure::{Failure, FailureCause};
use super::state::State;
use crate::mechanics::contact::detection::slave_choice::mean_face_size;
use crate::plan::Plan;

/// How far a node may be beyond a plane of symmetry, relative to the mean size of the faces of its body [-].
const BEYOND: f64 = 0.1;

/// The planes of symmetry that the bodies of a plan end at.
pub(super) struct Mirrors<'p> {
    plan: &'p Plan,
    /// How far a node of each body may be beyond [m].
    tolerances: Vec<f64>,
}

impl<'p> Mirrors<'p> {
    pub fn of(plan: &'p Plan) -> Self {
        let bodies = plan.bodies.iter().filter(|_| !plan.mirrors.is_empty());
        Self {
            plan,
            tolerances: bodies.map(|body| BEYOND * mean_face_size(&body.boundary, &plan.X)).collect(),
        }
    }

    /// Whether every node is still on its side.
    ///
    /// # Errors
    /// A failure that names the first body that is not.
    pub fn check(&self, state: &State) -> Result<(), Failure> {
        for (body, tolerance) in self.tolerances.iter().enumerate() {
            let of_body = &self.plan.bodies[body];
            let is_beyond = |node: &u32| {
                let x = state.position(self.plan, body, *node as usize);
                self.plan.mirrors.iter().any(|plane| x[plane.axis] < plane.at - tolerance)
            };
            if of_body.rigid.is_none() && of_body.boundary.nodes.iter().any(is_beyond) {
                let message = format!(
                    "{} meets its mirror image at t = {:.4e} s, which the computation of a part of the scene does not follow.",
                    of_body.name, state.time
                );
                return Err(Failure::new(state, FailureCause::MirrorImagesMeet, message));
            }
        }
        Ok(())
    }
}
