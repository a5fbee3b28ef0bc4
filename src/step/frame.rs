//! What recorders see, and how a run ends.

use super::failure::Failure;
use super::ledger::Energy;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::force::{Erosion, PointInput};
use crate::mechanics::lanes::Row;
use crate::mechanics::rigid::{Pose, Rotation};
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use serde::Serialize;
use std::sync::Arc;

/// The run at one time t_n, complete: positions, reactions and a closed energy ledger.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// Time t_n [s], from 0 on: settling has no frames.
    pub time: f64,
    /// Number of steps done.
    pub step: u64,
    /// Displacement u_n in each body's own inertial frame [m], nodes × 3. In a [`super::FrameCopy`] it is up to date at the
    /// field times, and between them at the nodes of the skins only (of bodies that erode, at all).
    pub u: &'a [Vec3],
    /// Velocity of the half step before t_n, relative to the bodies' flight [m/s], nodes × 3; in a [`super::FrameCopy`] empty
    /// between the look times, and when neither the plan asks for the velocity nor a part is viscous.
    pub v: &'a [Vec3],
    /// Velocity of the half step after t_n, as `v`.
    pub v_after: &'a [Vec3],
    /// History of the elements at t_n, chunk by chunk; empty between the look times, and where nothing relaxes.
    pub history: &'a [Vec<Row>],
    /// Elements that are gone at t_n.
    pub erosion: &'a Arc<Erosion>,
    /// Orientation of each rigid body at t_n.
    pub orientations: &'a [Rotation],
    /// Candidate contacts at t_n, sorted by (pair, slave, face).
    pub contacts: &'a [Contact],
    /// Their reactions: impulses over `mean_step`, so force = impulse / mean_step.
    pub reactions: &'a [Reaction],
    /// h̄ = ½(h₋ + h₊), the time over which the reactions of this step act [s].
    pub mean_step: f64,
    /// The ledger at t_n.
    pub energy: &'a Energy,
    /// Whether t_n is one of the plan's field times (or the end of a run that failed or was cancelled).
    pub is_field_time: bool,
    /// Whether measures look at the whole bodies: a field time, or one of fifty looks in between; the displacements of all nodes
    /// are known then, and else those of the skins alone.
    pub is_look_time: bool,
}

/// Times of a run at which whole bodies are looked at, whatever is recorded.
pub const LOOKS: f64 = 50.0;

impl Frame<'_> {
    /// What stresses at points are made of.
    pub fn points(&self) -> PointInput<'_> {
        PointInput { u: self.u, v: self.v, history: self.history, erosion: self.erosion }
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
    /// As [`Frame::position`], for those who know the node's body.
    pub fn position_in(&self, body: usize, node: u32) -> Vec3 {
        self.plan.position(body, node as usize, self.time, &self.u[node as usize])
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "ending", rename_all = "snake_case")]
pub enum Ending {
    /// It reached the end time.
    Finished,
    /// Somebody stopped it.
    Cancelled,
    /// It went wrong, and this is why.
    Failed {
        /// The diagnosis.
        failure: Failure,
    },
}

impl Ending {
    /// What went wrong.
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

/// The end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// How it ended.
    #[serde(flatten)]
    pub ending: Ending,
    /// Simulated time reached [s].
    pub time_s: f64,
    /// Steps done.
    pub steps: u64,
    /// Smallest step [s].
    pub smallest_step_s: f64,
    /// Smallest Jacobian J at any quadrature point at any time [-].
    pub smallest_jacobian: f64,
    /// Elements × steps.
    pub element_steps: u64,
    /// Of these, those that were swept: the rest were quiet, which nothing had reached yet.
    pub swept_element_steps: u64,
    /// Largest error of the energy balance [-].
    pub balance_error: f64,
    /// Largest number of contact candidates in a step.
    pub most_contacts: usize,
    /// Sentences that the user should read (numerical contact dissipation above 2 %, a wave came back, …).
    pub warnings: Vec<String>,
}

/// A recorder that could not record.
#[derive(Debug, thiserror::Error)]
#[error("the recording failed: {0}")]
pub struct RecorderError(#[from] pub Box<dyn std::error::Error + Send + Sync>);

/// A sink that the stepper pushes frames into. The stepper knows nothing of files.
pub trait Recorder {
    /// Before the first step.
    ///
    /// # Errors
    /// When the sink cannot be opened.
    fn start(&mut self, _plan: &Plan) -> Result<(), RecorderError> {
        Ok(())
    }
    /// At every step, also those that are not due: the recorder keeps the plan's cadence (`plan.every_steps`,
    /// `frame.is_field_time`).
    ///
    /// # Errors
    /// When the sink cannot be written; the run then ends as failed.
    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError>;
    /// After the last step, however the run ended.
    ///
    /// # Errors
    /// When the sink cannot be closed.
    fn finish(&mut self, _plan: &Plan, _outcome: &Outcome) -> Result<(), RecorderError> {
        Ok(())
    }
}
