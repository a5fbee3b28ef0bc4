//! Jobs: scenes that wait, run and end, and survive the process that runs them.
//!
//! - [`store`]: what is kept of jobs, behind a trait; every change of a job and the event that tells of it are one
//!   transaction.
//! - [`queue`]: what can be asked of jobs: submit, cancel, delete; and recovery at the start.
//! - [`worker`]: threads that claim a job, run it by an [`engine::Engine`] and say how it ended.
//! - [`recordings`]: files that are still written.
//! - [`snapshots`]: what can be seen of a recording while it is written.
//! - [`control`]: how a running job is stopped, and why.

pub mod control;
pub mod engine;
mod error;
mod judged;
mod kind;
pub mod queue;
pub mod recordings;
pub mod simulator;
pub mod snapshots;
mod spending;
pub mod store;
mod study_entries;
pub mod study_job;
mod verdict;
pub mod what_if_job;
pub mod worker;

pub use error::{JobsError, StoreFault};
pub use kind::JobKind;

pub use crate::study::{Phase, Progress};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

/// Name of a job. Version 7: ids sort by their time of arrival and cannot be guessed.
pub type JobId = Uuid;

/// Where a job stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// It waits for a worker.
    Queued,
    /// A worker has it.
    Running,
    /// It reached the end time, and its gates were passed.
    Succeeded,
    /// It ended early; `failure` says why.
    Failed,
    /// Somebody stopped it.
    Cancelled,
}

impl JobState {
    /// All of them, in the order of a life.
    pub const ALL: [Self; 5] = [Self::Queued, Self::Running, Self::Succeeded, Self::Failed, Self::Cancelled];

    /// The name on the wire and in the store.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// The state of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.as_str() == name)
    }

    /// Whether nothing will change any more.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
}

/// Why a job failed, as a code that programs can match.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobFailureCause {
    /// The scene that was accepted is not valid any more (a mesh is gone, the engine changed).
    InvalidScene,
    /// An element's Jacobian became zero or negative.
    ElementInverted,
    /// The stable step fell below what can finish.
    StepCollapsed,
    /// The same where the law of the material softens.
    EllipticityLost,
    /// The contact solver did not reach its tolerance.
    ContactNotConverged,
    /// No reactions can stop what contact must stop.
    ContactJammed,
    /// An implicit step did not converge however short it was.
    NewtonNotConverged,
    /// Without mass: nothing balances what pushes a body.
    NothingHolds,
    /// The energy balance failed its gate.
    EnergyGate,
    /// The step is longer than a rigid body's rotation allows.
    StepTooLong,
    /// A fibre, or tissue without, was stretched beyond what its exponential can represent.
    FibreOverstretched,
    /// A number became infinite or not a number.
    NotFinite,
    /// The wall-clock budget ran out.
    Deadline,
    /// It took more steps, or recorded more, than it was estimated to and may.
    Budget,
    /// The process that ran it was lost, more often than a job may lose one.
    WorkerLost,
    /// The recording could not be written.
    RecordingFailed,
    /// A fault of the program.
    Internal,
}

/// The diagnosis of a job that failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobFailure {
    /// The cause.
    pub cause: JobFailureCause,
    /// What happened, with values and limits.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
    /// Simulated time [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<u64>,
    /// Where, when it is about an element.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element: Option<FailedElement>,
}

impl JobFailure {
    /// The diagnosis of a job that lost its worker so often.
    pub fn worker_lost(attempts: u32) -> Self {
        Self {
            cause: JobFailureCause::WorkerLost,
            message: format!("the process that ran it was lost {attempts} times"),
            remedy:
                "Look at the memory of the machine and at the log of the service; a smaller scene may pass."
                    .into(),
            time_s: None,
            step: None,
            element: None,
        }
    }

    /// The diagnosis of a fault of the program. What it was is in the log and not for the world.
    pub fn internal() -> Self {
        Self {
            cause: JobFailureCause::Internal,
            message: "A fault of the program stopped the run.".into(),
            remedy: "Report it with the id of the job and the log of the service around its end.".into(),
            time_s: None,
            step: None,
            element: None,
        }
    }
}

/// The element that a failure is about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FailedElement {
    /// Name of the body.
    pub body: String,
    /// Name of the part.
    pub part: String,
    /// Index of the element in the body, from 0.
    pub element: u32,
    /// Its centre at that time [m]; absent when that is not finite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_m: Option<[f64; 3]>,
}

/// A recording that will not change any more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Recording)]
pub struct FinalRecording {
    /// Its size [bytes].
    pub bytes: u64,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Whether it holds the whole run.
    pub complete: bool,
}
