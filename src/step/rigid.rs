//! Rigid bodies in a step: free rotation, poses, and their contribution to the ledger.

use super::failure::{Failure, FailureCause};
use super::phase::Phase;
use super::state::State;
use crate::mechanics::contact::{Contact, RigidSides};
use crate::mechanics::rigid::{Pose, RigidBody, Rotation, rotated, turn_freely};
use crate::mechanics::tensor::Vec3;
use crate::plan::{Plan, RigidPlan};

/// The rigid bodies of a step; derived from plan and state, so not part of the state.
pub(super) struct RigidStep<'p> {
    plan: &'p RigidPlan,
    poses: Vec<Pose>,
    /// Orientations at the end of the step, and the spins [rad/s] in the body axes at that time.
    ends: Vec<(Rotation, Vec3)>,
}

/// Largest rotation of a rigid body in an explicit step [rad].
pub(super) const LARGEST_TURN: f64 = 1.0;

impl<'p> RigidStep<'p> {
    pub fn new(plan: &'p RigidPlan) -> Self {
        let bodies = plan.bodies.len();
        Self { plan, poses: Vec::with_capacity(bodies), ends: Vec::with_capacity(bodies) }
    }

    /// Sets the poses of a state, and the centres in `x` [m].
    pub fn place(&mut self, plan: &Plan, state: &State, phase: Phase, x: &mut [Vec3]) {
        let time = if phase.flies() { state.time } else { 0.0 };
        self.poses.clear();
        for (index, orientation) in state.orientations.iter().enumerate() {
            let pose = plan.pose(self.plan, index, time, &state.u, *orientation);
            x[self.plan.bodies[index].centre as usize] = pose.centre;
            self.poses.push(pose);
        }
    }

    /// Spins of the state, damped by the fraction `damping` (½ α h̄), into `v_after` [rad/s].
    pub fn damp(&self, state: &State, damping: f64, v_after: &mut [Vec3]) {
        for spin in self.plan.bodies.iter().map(|body| body.spin as usize) {
            v_after[spin] = state.v[spin] * ((1.0 - damping) / (1.0 + damping));
        }
    }

    /// Largest spin in the velocities `v` [rad/s].
    pub fn fastest_spin(&self, v: &[Vec3]) -> f64 {
        self.plan.bodies.iter().map(|body| v[body.spin as usize].norm()).fold(0.0, f64::max)
    }

    /// Rotates the bodies freely to the end of the step, h [s] away, with the spins of `v_after` [rad/s] in the body
    /// axes at t_n: forces act at t_n, and from then on the angular momentum in space is constant. `theta`, the weight
    /// of `v_after` in the rotation, is below 1 if the velocities of the state are those at t_n itself.
    pub fn turn(&mut self, state: &State, v_after: &[Vec3], theta: f64, h: f64) -> Result<(), Failure> {
        self.ends.clear();
        for (orientation, body) in state.orientations.iter().zip(&self.plan.bodies) {
            let (before, after) = (&state.v[body.spin as usize], &v_after[body.spin as usize]);
            // Until the forces act the body has its earlier spin; without forces this makes no difference.
            let start = rotated(orientation, &(before - after), (1.0 - theta) * h);
            let end = turn_freely(&start, after, &body.inertia, h).ok_or_else(|| {
                let message = format!(
                    "A rigid body rotates too far in one step: {:.3e} rad/s for {h:.3e} s.",
                    after.norm()
                );
                Failure::new(state, FailureCause::StepTooLong, message)
            })?;
            self.ends.push(end);
        }
        Ok(())
    }

    /// As [`Self::turn`] in quasi-static steps: the spins of `v_after` [rad/s] are those of the whole load step, and
    /// vanish at its end.
    pub fn turn_statically(&mut self, state: &State, v_after: &[Vec3], h: f64) {
        self.ends.clear();
        let bodies = state.orientations.iter().zip(&self.plan.bodies);
        let end = |(orientation, body): (&Rotation, &RigidBody)| {
            let spin = body.spin as usize;
            (rotated(orientation, &v_after[spin], h), state.v[spin])
        };
        self.ends.extend(bodies.map(end));
    }

    /// Sets the orientations and spins at the end of the step.
    pub fn advance(&self, state: &mut State) {
        for ((orientation, spin), (index, body)) in self.ends.iter().zip(self.plan.bodies.iter().enumerate())
        {
            state.orientations[index] = *orientation;
            state.v[body.spin as usize] = *spin;
        }
        self.clear_places(state);
    }

    /// Spins are no translations: reverts what the common update has added to their entries.
    fn clear_places(&self, state: &mut State) {
        for body in &self.plan.bodies {
            state.u[body.spin as usize] = Vec3::zeros();
        }
    }

    /// The poses, for correction by projection.
    pub fn poses_mut(&mut self) -> &mut [Pose] {
        &mut self.poses
    }

    /// The rigid bodies with their poses, for the ledger.
    pub fn work(&self) -> RigidWork<'_> {
        let sides = RigidSides {
            of_pairs: &self.plan.of_pairs,
            first: self.plan.first_pair,
            bodies: &self.plan.bodies,
            poses: &self.poses,
        };
        RigidWork { plan: self.plan, sides }
    }
}

/// Rigid body data read by the ledger.
#[derive(Clone, Copy)]
pub(super) struct RigidWork<'a> {
    pub plan: &'a RigidPlan,
    pub sides: RigidSides<'a>,
}

impl RigidWork<'_> {
    /// Velocity of a contact point due to the rotation of one side (0 the slave, 1 the master) [m/s], from the spins in
    /// `v` [rad/s].
    pub fn velocity(&self, contact: &Contact, side: usize, v: &[Vec3]) -> Vec3 {
        let body = self.sides.of_pair(contact.pair)[side];
        body.map_or_else(Vec3::zeros, |body| {
            let body = body as usize;
            let pose = &self.sides.poses[body];
            (pose.orientation * v[self.sides.bodies[body].spin as usize])
                .cross(&(contact.point - pose.centre))
        })
    }

    /// Twice the kinetic energy of a rotation at t_n [J], and its angular momentum in space [kg m²/s]; `v_before` and
    /// `v_after` are the velocities of the adjacent half steps.
    pub fn rotation(&self, body: usize, v_before: &[Vec3], v_after: &[Vec3]) -> (f64, Vec3) {
        let RigidBody { inertia, spin, .. } = &self.sides.bodies[body];
        let (before, after) = (v_before[*spin as usize], v_after[*spin as usize]);
        // Both spins are in the axes at t_n: free rotation between two times does no work and conserves the momentum.
        let energy = before.dot(&inertia.component_mul(&after));
        let moment = inertia.component_mul(&((before + after) * 0.5));
        (energy, self.sides.poses[body].orientation * moment)
    }
}
