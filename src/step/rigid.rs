//! Rigid bodies inside a step: free rotation, poses, and what the ledger asks of them.

use super::failure::{Failure, FailureCause};
use super::integrator::Phase;
use super::ledger::Half;
use super::state::State;
use crate::mechanics::contact::{Contact, RigidSides};
use crate::mechanics::rigid::{Pose, RigidBody, Rotation, rotated, turn_freely};
use crate::mechanics::tensor::Vec3;
use crate::plan::{Plan, RigidPlan};

/// The rigid bodies of a step; derived from plan and state, so no part of the state.
pub(super) struct RigidStep<'p> {
    plan: &'p RigidPlan,
    /// Poses at t_n.
    poses: Vec<Pose>,
    /// Spins of the half step before, turned freely to the half step after [rad/s], in the axes of the bodies.
    turned: Vec<Vec3>,
}

impl<'p> RigidStep<'p> {
    pub fn new(plan: &'p RigidPlan) -> Self {
        let bodies = plan.bodies.len();
        Self { plan, poses: Vec::with_capacity(bodies), turned: vec![Vec3::zeros(); bodies] }
    }

    /// Takes the poses of a state; the centres go into `x` [m] too.
    pub fn place(&mut self, plan: &Plan, state: &State, phase: Phase, x: &mut [Vec3]) {
        let time = match phase {
            Phase::Settling(_) | Phase::Preloading => 0.0,
            Phase::Running => state.time,
        };
        self.poses.clear();
        for (index, orientation) in state.orientations.iter().enumerate() {
            let pose = plan.pose(self.plan, index, time, &state.u, *orientation);
            x[self.plan.bodies[index].centre as usize] = pose.centre;
            self.poses.push(pose);
        }
    }

    /// The spins of `v` [rad/s], turned freely for a time h̄ [s], into `v_after`; damped by the share `damping` (½ α h̄).
    pub fn turn(
        &mut self,
        state: &State,
        mean_step: f64,
        damping: f64,
        v_after: &mut [Vec3],
    ) -> Result<(), Failure> {
        for (turned, body) in self.turned.iter_mut().zip(&self.plan.bodies) {
            let spin = body.spin as usize;
            let free = turn_freely(&state.v[spin], &body.inertia, mean_step).ok_or_else(|| {
                let message = format!(
                    "A rigid body turns too far in one step: {:.3e} rad/s for {mean_step:.3e} s.",
                    state.v[spin].norm()
                );
                Failure::new(state, FailureCause::StepTooLong, message)
            })?;
            *turned = free;
            v_after[spin] = free * ((1.0 - damping) / (1.0 + damping));
        }
        Ok(())
    }

    /// The orientations at the end of a step of length h [s] with the velocities of the state: those between its ends.
    pub fn advance(&self, state: &mut State, h: f64) {
        let State { orientations, v, .. } = state;
        self.turn_with(orientations, h, |spin| v[spin]);
        self.clear_places(state);
    }

    /// As [`RigidStep::advance`] where the velocities of the state are those of the start and `v_end` those of the end, weighted by
    /// θ.
    pub fn advance_between(&self, state: &mut State, v_end: &[Vec3], theta: f64, h: f64) {
        let State { orientations, v, .. } = state;
        self.turn_with(orientations, h, |spin| v_end[spin] * theta + v[spin] * (1.0 - theta));
    }

    fn turn_with(&self, orientations: &mut [Rotation], h: f64, spin: impl Fn(usize) -> Vec3) {
        for (orientation, body) in orientations.iter_mut().zip(&self.plan.bodies) {
            *orientation = rotated(orientation, &spin(body.spin as usize), h);
        }
    }

    /// Spins have no place: what the common formula has put there is taken back.
    pub fn clear_places(&self, state: &mut State) {
        for body in &self.plan.bodies {
            state.u[body.spin as usize] = Vec3::zeros();
        }
    }

    /// The poses, to be corrected.
    pub fn poses_mut(&mut self) -> &mut [Pose] {
        &mut self.poses
    }

    /// The bodies and where they are.
    pub fn work(&self) -> RigidWork<'_> {
        let sides =
            RigidSides { of_pairs: &self.plan.of_pairs, bodies: &self.plan.bodies, poses: &self.poses };
        RigidWork { plan: self.plan, sides, turned: &self.turned }
    }
}

/// What the ledger reads of the rigid bodies of a step.
#[derive(Clone, Copy)]
pub(super) struct RigidWork<'a> {
    pub plan: &'a RigidPlan,
    pub sides: RigidSides<'a>,
    /// Spins before the forces at t_n, in the axes of the bodies at t_n [rad/s]; empty at the start, where v₋ has them.
    ///
    /// The free rotation from the half step before does no work, so the energy of the rotation is that of these spins, and
    /// with them in the place of v₋ the balance closes as it does for nodes.
    pub turned: &'a [Vec3],
}

impl RigidWork<'_> {
    /// As seen at one time, with the spins of the velocities on both sides of it.
    pub fn unturned(self) -> Self {
        Self { turned: &[], ..self }
    }

    /// The spin before or after the forces at t_n, of the velocities `v` of that half [rad/s].
    pub fn spin(&self, body: usize, half: Half, v: &[Vec3]) -> Vec3 {
        let own = || v[self.sides.bodies[body].spin as usize];
        match half {
            Half::Before => self.turned.get(body).copied().unwrap_or_else(own),
            Half::After => own(),
        }
    }

    /// Velocity that the rotation gives a contact's point on one of its sides (0 the slave, 1 the master) [m/s]; `spins`
    /// by index of the rigid body.
    pub fn velocity(&self, contact: &Contact, side: usize, spin: impl Fn(usize) -> Vec3) -> Vec3 {
        let body = self.sides.of_pair(contact.pair)[side];
        body.map_or_else(Vec3::zeros, |body| {
            let body = body as usize;
            let pose = &self.sides.poses[body];
            (pose.orientation * spin(body)).cross(&(contact.point - pose.centre))
        })
    }

    /// Twice the kinetic energy of a rotation at t_n [J], and its angular momentum in space [kg m²/s]; `v_before` and
    /// `v_after` are the velocities of the half steps around.
    pub fn rotation(&self, body: usize, v_before: &[Vec3], v_after: &[Vec3]) -> (f64, Vec3) {
        let RigidBody { inertia, spin, .. } = &self.sides.bodies[body];
        let (before, after) = (v_before[*spin as usize], v_after[*spin as usize]);
        let energy = self.spin(body, Half::Before, v_before).dot(&inertia.component_mul(&after));
        // The axes of the body at t_n are half way between those of both spins.
        let moment = inertia.component_mul(&((before + after) * 0.5));
        (energy, self.sides.poses[body].orientation * moment)
    }
}
