//! What goes into a job store and what comes out of it.

use crate::scene::Problem;
use crate::service::jobs::{FinalRecording, JobId, JobKind, JobState, JobsError, Progress};
use crate::step::{Ending, Failure};
use serde_json::{Value, json};

/// What a new job is made of.
#[derive(Clone, Debug)]
pub struct NewJob {
    /// Whose it is.
    pub owner: String,
    /// The client's name for the request, by which it may ask twice.
    pub idempotency_key: Option<String>,
    /// SHA-256 of the address and the body of the request, hexadecimal.
    pub body_sha256: String,
    /// What the document asks for.
    pub kind: JobKind,
    /// The document as it was accepted.
    pub document: Vec<u8>,
    /// Name of the scene.
    pub name: String,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// What is odd about the scene.
    pub warnings: Vec<Problem>,
}

/// What became of a submission.
#[derive(Clone, Debug)]
pub enum Submitted {
    /// A new job.
    Created(Box<JobRow>),
    /// The job of an earlier request with the same key and the same body.
    Replayed(Box<JobRow>),
    /// The key belongs to a request with another body.
    KeyReused,
}

/// A job that a worker took.
#[derive(Clone, Debug)]
pub struct ClaimedJob {
    /// Order of arrival.
    pub seq: i64,
    /// Its id.
    pub id: JobId,
    /// Whose it is.
    pub owner: String,
    /// What its document asks for.
    pub kind: JobKind,
    /// The document as it was accepted.
    pub document: Vec<u8>,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// Which attempt this is, from 1.
    pub attempt: u32,
}

/// How a job ended.
#[derive(Clone, Debug)]
pub struct JobEnd {
    /// How its run ended.
    pub ending: Ending,
    /// Its summary, JSON text.
    pub summary: Option<String>,
    /// Its recording.
    pub recording: Option<FinalRecording>,
    /// How far it came, when that is known.
    pub progress: Option<Progress>,
}

/// Why a job waits again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Requeued {
    /// Its worker had to drop it. The attempt does not count: it was not the job's fault.
    Shutdown,
    /// Its worker was lost. The attempt counts: it may be the job that kills its workers.
    WorkerLost,
}

impl Requeued {
    /// The attempts that are forgotten.
    pub fn attempts_forgiven(self) -> u32 {
        u32::from(self == Self::Shutdown)
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Shutdown => "the service was shut down",
            Self::WorkerLost => "the process that ran it was lost",
        }
    }
}

/// What an owner wants of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnerWish {
    /// That it runs to its end.
    Result,
    /// That it stops.
    Stop,
    /// That it was never there.
    Deletion,
}

/// A job that the process before this one left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orphan {
    /// Order of arrival.
    pub seq: i64,
    /// Its id.
    pub id: JobId,
    /// The attempt that lost its worker.
    pub attempt: u32,
    /// What its owner wants of it.
    pub wish: OwnerWish,
}

/// What became of a wish to cancel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelAnswer {
    /// It waited, and is cancelled.
    Cancelled {
        /// Order of arrival.
        seq: i64,
    },
    /// It runs, and will stop.
    Stopping,
    /// It was cancelled before.
    AlreadyCancelled,
    /// It ended otherwise before.
    TooLate(JobState),
    /// There is no such job.
    Unknown,
}

/// What became of a wish to delete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeleteAnswer {
    /// Nobody works on it: it can be erased.
    Idle {
        /// Order of arrival.
        seq: i64,
    },
    /// It runs: its worker erases it when it has stopped.
    Running {
        /// Order of arrival.
        seq: i64,
    },
    /// There is no such job.
    Unknown,
}

/// A job as it stands.
#[derive(Clone, Debug)]
pub struct JobRow {
    /// Order of arrival.
    pub seq: i64,
    /// Its id.
    pub id: JobId,
    /// Name of the scene.
    pub name: String,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// What is odd about the scene.
    pub warnings: Vec<Problem>,
    /// Where it stands.
    pub state: JobState,
    /// How far it has come.
    pub progress: Progress,
    /// How often a worker took it.
    pub attempts: u32,
    /// Whether its owner wants it stopped.
    pub cancel_requested: bool,
    /// When it came, RFC 3339.
    pub created_at: String,
    /// When a worker took it last.
    pub started_at: Option<String>,
    /// When it ended.
    pub finished_at: Option<String>,
    /// Why it failed.
    pub failure: Option<Failure>,
    /// Whether it has a summary.
    pub has_summary: bool,
    /// Its recording, when final.
    pub recording: Option<FinalRecording>,
    /// Its place in the queue, the next one is 1; `None` when it does not wait.
    pub queue_position: Option<u64>,
}

/// Which jobs to list, newest first.
#[derive(Clone, Debug)]
pub struct Page {
    /// Only these states; all when empty.
    pub states: Vec<JobState>,
    /// Only jobs that came before this one.
    pub before: Option<i64>,
    /// At most so many.
    pub limit: u32,
}

/// Something that happened to a job, as its event stream will say it.
#[derive(Clone, Debug, PartialEq)]
pub struct Event<'a> {
    /// What happened.
    pub kind: &'a str,
    /// The details.
    pub data: Value,
}

impl Event<'static> {
    /// It waits.
    pub fn queued(name: &str) -> Self {
        Self { kind: "queued", data: json!({ "state": "queued", "name": name }) }
    }

    /// A worker took it.
    pub fn running(attempt: u32) -> Self {
        Self { kind: "running", data: json!({ "state": "running", "attempt": attempt }) }
    }

    /// How far it has come.
    ///
    /// # Errors
    /// When that cannot be written as JSON.
    pub fn progress(progress: &Progress) -> Result<Self, JobsError> {
        Ok(Self { kind: "progress", data: serde_json::to_value(progress)? })
    }

    /// It waits again.
    pub fn requeued(why: Requeued) -> Self {
        Self { kind: "requeued", data: json!({ "state": "queued", "reason": why.reason() }) }
    }

    /// It has ended.
    pub fn ended(ending: &Ending) -> Self {
        let state = JobState::of(ending);
        Self { kind: state.as_str(), data: json!({ "state": state, "failure": ending.failure() }) }
    }
}

/// An event of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EventRow {
    /// Its number in the job, from 1.
    pub n: i64,
    /// What happened.
    pub kind: String,
    /// The details, JSON.
    pub data: String,
}
