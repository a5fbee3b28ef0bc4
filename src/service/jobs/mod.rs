//! Jobs: scenes that wait, run and end, and survive the process that runs them.
//!
//! - [`store`]: what is kept of jobs, behind a trait; every change of a job and the event that tells of it are one
//!   transaction.
//! - [`queue`]: what can be asked of jobs: submit, cancel, delete; and recovery at the start.
//! - [`worker`]: threads that claim a job, run it by an [`engine::Engine`] and say how it ended.
//! - [`data_folder`]: files that are still written.
//! - [`snapshots`]: what can be seen of a recording while it is written.
//! - [`control`]: how a running job is stopped, and why.

pub mod control;
pub mod data_folder;
pub mod engine;
mod error;
pub mod failures;
mod judged;
mod kind;
pub mod queue;
pub mod simulator;
pub mod snapshots;
mod spending;
pub mod store;
mod study_entries;
pub mod study_job;
pub mod what_if_job;
pub mod worker;

pub use error::{JobsError, StoreFault};
pub use kind::JobKind;

pub use crate::study::{Phase, Progress};

use crate::step::Ending;
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

    /// The state that a job ends in whose run ended so.
    pub fn of(ending: &Ending) -> Self {
        match ending {
            Ending::Finished => Self::Succeeded,
            Ending::Cancelled => Self::Cancelled,
            Ending::Failed { .. } => Self::Failed,
        }
    }

    /// Whether nothing will change any more.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
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
