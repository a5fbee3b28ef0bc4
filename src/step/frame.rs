//! Input of the recorders, and the outcome of a run.

use super::energy::Energy;
use super::failure::Failure;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::force::{Erosion, PointInput};
use crate::mechanics::lanes::Row;
use crate::mechanics::rigid::{Pose, Rotation};
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Complete state of the run at one time t_n: positions, reactions and a closed energy ledger.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// Plan of the run.
    pub plan: &'a Plan,
    /// Time t_n [s], from 0 on: dynamic relaxation has no frames.
    pub time: f64,
    /// Number of steps completed.
    pub step: u64,
    /// Displacement u_n in each body's own inertial frame [m], nodes × 3. In a [`super::FrameCopy`] it is complete at
    /// the field times, and otherwise available at boundary nodes only (of all bodies, if they erode).
    pub u: &'a [Vec3],
    /// Velocity of the half step before t_n, relative to the rigid-body velocities V of the bodies [m/s], nodes × 3; in a [`super::FrameCopy`]
    /// empty between the look times, and if neither the plan requests the velocity nor a part is viscous.
    pub v: &'a [Vec3],
    /// Velocity of the half step after t_n, as `v`.
    pub v_after: &'a [Vec3],
    /// History of the elements at t_n, chunk by chunk; empty between the look times, and if no material relaxes.
    pub history: &'a [Vec<Row>],
    /// Elements eroded by t_n.
    pub erosion: &'a Arc<Erosion>,
    /// Orientation of each rigid body at t_n.
    pub orientations: &'a [Rotation],
    /// Candidate contacts at t_n, sorted by (pair, slave, face).
    pub contacts: &'a [Contact],
    /// Reactions of these contacts: impulses over `mean_step`, so force = impulse / mean_step.
    pub reactions: &'a [Reaction],
    /// h̄ = ½(h₋ + h₊), the time over which the reactions of this step act [s].
    pub mean_step: f64,
    /// Energy ledger at t_n.
    pub energy: &'a Energy,
    /// Whether t_n is one of the plan's field times (or the end of a run that failed or was cancelled).
    pub is_field_time: bool,
    /// Whether measures evaluate the whole bodies: at the field times, and once in each fiftieth of a run without one; only then are
    /// the displacements of all nodes available, otherwise those of the boundary nodes alone.
    pub is_look_time: bool,
}

/// Number of times in a run at which whole bodies are evaluated, regardless of the recording.
pub const LOOKS: f64 = 50.0;

impl Frame<'_> {
    /// The contacts of a pair, with their reactions.
    pub fn contacts_of(&self, pair: u32) -> impl Iterator<Item = (&Contact, &Reaction)> + Clone {
        let first = self.contacts.partition_point(|contact| contact.pair < pair);
        let count = self.contacts[first..].partition_point(|contact| contact.pair == pair);
        self.contacts[first..first + count].iter().zip(&self.reactions[first..first + count])
    }
    /// Input for the evaluation of stresses at quadrature points.
    pub fn points(&self) -> PointInput<'_> {
        PointInput {
            u: self.u,
            v: self.v,
            history: self.history,
            erosion: self.erosion,
            with_stress: true,
            with_rate: false,
        }
    }
    /// Position x = X + V_b t + u of a node at t_n [m].
    pub fn position(&self, node: u32) -> Vec3 {
        self.position_in(self.plan.body_of_node(node), node)
    }
    /// Pose of a body at t_n, if it is rigid.
    pub fn pose(&self, body: usize) -> Option<Pose> {
        let index = self.plan.bodies[body].rigid?;
        let rigid = self.plan.rigid.as_ref()?;
        Some(self.plan.pose(rigid, index, self.time, self.u, self.orientations[index]))
    }
    /// As [`Frame::position`], given the node's body.
    pub fn position_in(&self, body: usize, node: u32) -> Vec3 {
        self.plan.position(body, node as usize, self.time, &self.u[node as usize])
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "ending", rename_all = "snake_case")]
pub enum Ending {
    /// It reached the end time.
    Finished,
    /// The run was cancelled by the user.
    Cancelled,
    /// The run failed with a diagnosis.
    Failed {
        /// Diagnosis of the failure.
        failure: Failure,
    },
}

impl Ending {
    /// Name in documents and recordings.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::Cancelled => "cancelled",
            Self::Failed { .. } => "failed",
        }
    }

    /// Diagnosis of the failure, if the run failed.
    pub fn failure(&self) -> Option<&Failure> {
        match self {
            Self::Failed { failure } => Some(failure),
            Self::Finished | Self::Cancelled => None,
        }
    }
}

impl From<Failure> for Ending {
    fn from(failure: Failure) -> Self {
        Self::Failed { failure }
    }
}

/// Outcome of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// How the run ended.
    #[serde(flatten)]
    pub ending: Ending,
    /// Simulated time reached [s].
    pub time_s: f64,
    /// Number of steps completed.
    pub steps: u64,
    /// Smallest time step [s].
    pub smallest_step_s: f64,
    /// Smallest Jacobian J at any quadrature point at any time [-].
    pub smallest_jacobian: f64,
    /// Number of elements times number of steps.
    pub element_steps: u64,
    /// Active part of these; in the rest internal forces were not evaluated, because nothing had reached the element
    /// yet.
    pub evaluated_element_steps: u64,
    /// Largest error of the energy balance [-].
    pub balance_error: f64,
    /// Largest number of contact candidates in a step.
    pub most_contacts: usize,
    /// Warnings for the user (numerical contact dissipation above 2 %, a reflected wave, …).
    pub warnings: Vec<String>,
}

/// Failure of a recorder.
#[derive(Debug, thiserror::Error)]
#[error("the recording failed: {0}")]
pub struct RecorderError(#[from] pub Box<dyn std::error::Error + Send + Sync>);

/// A recipient of the stepper's frames. The stepper is independent of file formats.
pub trait Recorder {
    /// Called before the first step.
    ///
    /// # Errors
    /// If the recorder cannot be opened.
    fn start(&mut self, _plan: &Plan) -> Result<(), RecorderError> {
        Ok(())
    }
    /// Called at every step, whether a frame is due or not: the recorder follows the plan's cadence
    /// (`plan.every_steps`, `frame.is_field_time`).
    ///
    /// # Errors
    /// If the recorder cannot be written; the run then ends as failed.
    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError>;
    /// Whether it reads displacements and velocities of all nodes in every frame, and not at the look times alone.
    fn reads_all_nodes(&self) -> bool {
        false
    }
    /// Called after the last step, however the run ended.
    ///
    /// # Errors
    /// If the recorder cannot be closed.
    fn finish(&mut self, _plan: &Plan, _outcome: &Outcome) -> Result<(), RecorderError> {
        Ok(())
    }
}
