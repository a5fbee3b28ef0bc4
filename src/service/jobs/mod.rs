//! Jobs: scenes that wait, run and end, and outlive the process that runs them.
//!
//! - [`store`]: the records of jobs, behind a trait; every change of a job and its event are one transaction.
//! - [`queue`]: operations on jobs: submit, cancel; [`deletion`]: delete, and [`removals`] of what is left.
//! - [`upload`]: a file that arrives, and room for it.
//! - [`to_end::to_end`]: what a client that leaves does not interrupt.
//! - [`recovery`]: what lost processes have left.
//! - [`worker`]: threads that claim a job, run it with an [`engine::Engine`] and record how it ended.
//! - [`data_folder`]: files that are still being written.
//! - [`snapshots`]: views of a recording while it is written.
//! - [`sharing`]: jobs of several processes: leases, and changes by others.
//! - [`control`]: stopping a running job, and why.
//! - [`pulse`]: whether the object store answers; [`ownership`]: whose blobs it has.
//! - [`process`]: runs in processes of their own.

mod allowance;
pub mod control;
pub mod data_folder;
pub mod deletion;
mod disk;
pub mod engine;
mod error;
pub mod failures;
pub mod found;
pub mod held_text;
mod kind;
pub mod ownership;
mod priority;
pub mod process;
pub mod pulse;
pub mod queue;
pub mod recovery;
pub mod removals;
mod room;
mod scene_loader;
mod scene_size;
pub mod sharing;
pub mod simulator;
pub mod snapshots;
mod spending;
pub mod store;
mod study_entries;
pub mod study_job;
pub mod to_end;
pub mod upload;
pub mod what_if_job;
pub mod worker;

pub use error::{JobsError, StoreFault};
pub use kind::JobKind;
pub use priority::Priority;

pub use crate::study::{Phase, Progress, Stage};

use crate::step::Ending;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

/// Id of a job. UUID version 7: ids sort by their time of arrival and cannot be guessed.
pub type JobId = Uuid;

/// State of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Waiting for a worker.
    Queued,
    /// A worker is running it.
    Running,
    /// The end time was reached, and the acceptance checks were passed.
    Succeeded,
    /// It ended early; `failure` gives the reason.
    Failed,
    /// Cancelled by the user.
    Cancelled,
}

impl JobState {
    /// All states in order of progress.
    pub const ALL: [Self; 5] = [Self::Queued, Self::Running, Self::Succeeded, Self::Failed, Self::Cancelled];

    /// Name in documents and in the store.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// The state with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.as_str() == name)
    }

    /// Final state of a job whose run ended in this way.
    pub fn of(ending: &Ending) -> Self {
        match ending {
            Ending::Finished => Self::Succeeded,
            Ending::Cancelled => Self::Cancelled,
            Ending::Failed { .. } => Self::Failed,
        }
    }

    /// Whether the state is final.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
}

/// A recording that will not change any more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Recording)]
pub struct FinalRecording {
    /// Size of the file in bytes.
    pub bytes: u64,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Whether it contains the whole run.
    pub complete: bool,
    /// Number of the attempt that left it, which is in the name of its blob.
    #[serde(skip)]
    pub attempt: u32,
}
