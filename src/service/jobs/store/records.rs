//! Records of a job store.

use super::headline::Headline;
use super::job::Job;
use crate::mesh::read::MeshFormat;
use crate::scene::Problem;
use crate::service::jobs::{FinalRecording, JobId, JobKind, JobState, JobsError, Priority, Progress};
use crate::step::Ending;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Data of a new job.
#[derive(Clone, Debug)]
pub struct NewJob {
    /// Owner of the job.
    pub owner: String,
    /// The client's key for the request, which makes repetition safe.
    pub idempotency_key: Option<String>,
    /// SHA-256 of the address and the body of the request, hexadecimal.
    pub body_sha256: String,
    /// Kind of job that the document requests.
    pub kind: JobKind,
    /// Priority among the jobs of its owner.
    pub priority: Priority,
    /// Context of the trace of the request.
    pub trace: Option<String>,
    /// Document accepted at submission.
    pub document: Vec<u8>,
    /// Name of the scene.
    pub name: String,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// Warnings from the validation of the scene.
    pub warnings: Vec<Problem>,
    /// Memory that the run is expected to take [bytes].
    pub memory_bytes: u64,
    /// Ids of the uploaded meshes that its document names.
    pub meshes: BTreeSet<String>,
}

/// Outcome of a submission.
#[derive(Clone, Debug)]
pub enum Submitted {
    /// A new job was created.
    Created(Box<Job>),
    /// The job of an earlier request with the same key and the same body.
    Replayed(Box<Job>),
    /// The key belongs to a request with another body.
    KeyReused,
    /// The owner deleted a mesh of the job since it was validated.
    MeshGone {
        /// Id of the mesh.
        id: String,
    },
}

/// A job claimed by a worker.
#[derive(Clone, Debug)]
pub struct ClaimedJob {
    /// Sequence number in the order of arrival.
    pub seq: i64,
    /// Public id of the job.
    pub id: JobId,
    /// Owner of the job.
    pub owner: String,
    /// Kind of job that its document requests.
    pub kind: JobKind,
    /// Document accepted at submission.
    pub document: Vec<u8>,
    /// Memory that the run is expected to take [bytes].
    pub memory_bytes: u64,
    /// Whether it lost its process before, and therefore runs without others.
    pub alone: bool,
    /// Number of this attempt, from 1.
    pub attempt: u32,
    /// Context of the trace of the request that submitted it.
    pub trace: Option<String>,
}

/// How a job ended.
#[derive(Clone, Debug)]
pub struct JobEnd {
    /// Ending of its run.
    pub ending: Ending,
    /// Summary as JSON text.
    pub summary: Option<String>,
    /// Projectile and main numbers, for lists.
    pub headline: Option<Headline>,
    /// Final recording, if there is one.
    pub recording: Option<FinalRecording>,
    /// Final progress, if known.
    pub progress: Option<Progress>,
}

/// What of a summary says that its numbers are withheld.
#[derive(Deserialize)]
struct Withholding {
    withheld: Option<IgnoredAny>,
}

impl JobEnd {
    /// What the job keeps beside its document [bytes].
    pub fn kept_bytes(&self) -> u64 {
        let summary = self.summary.as_ref().map_or(0, |text| text.len() as u64);
        summary + self.recording.as_ref().map_or(0, |recording| recording.bytes)
    }

    /// Whether the numbers of its run are withheld, as its summary says.
    pub fn is_withheld(&self) -> bool {
        let read = |text: &String| serde_json::from_str::<Withholding>(text).ok();
        self.summary.as_ref().and_then(read).is_some_and(|summary| summary.withheld.is_some())
    }
}

/// Why a job waits again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Requeued {
    /// Its worker had to drop it. The attempt does not count, since the job is not to blame.
    Shutdown,
    /// The disk was full. The attempt does not count, since any job would have failed.
    DiskFull,
    /// The disk had no room for its recording, and has room now. The attempt counts, since the recording may be the cause.
    NoRoom,
    /// The object store did not answer. The attempt does not count, since any job would have failed.
    BlobStoreSilent,
    /// The process that ran it was lost. The attempt counts, since the job may be the cause.
    WorkerLost,
    /// The process of its run was lost. The attempt counts, and the next one runs alone.
    ProcessLost,
}

impl Requeued {
    /// Number of attempts that do not count.
    pub fn attempts_forgiven(self) -> u32 {
        u32::from(matches!(self, Self::Shutdown | Self::DiskFull | Self::BlobStoreSilent))
    }

    fn reason(self) -> &'static str {
        match self {
            Self::Shutdown => "the service was shut down",
            Self::DiskFull | Self::NoRoom => "the disk of the service was full",
            Self::BlobStoreSilent => "the object store of the service did not answer",
            Self::WorkerLost => "the process that ran it was lost",
            Self::ProcessLost => {
                "the process that ran it was lost: it is tried again without others beside it"
            }
        }
    }
}

/// What the owner of a job has requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnerRequest {
    /// Completion of the job.
    Result,
    /// Cancellation of the job.
    Stop,
    /// Deletion of the job.
    Deletion,
}

impl OwnerRequest {
    /// From what a store notes of a job.
    pub(super) fn of(is_deleted: bool, is_cancelled: bool) -> Self {
        match (is_deleted, is_cancelled) {
            (true, _) => Self::Deletion,
            (false, true) => Self::Stop,
            (false, false) => Self::Result,
        }
    }
}

/// A job whose process was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orphan {
    /// Sequence number in the order of arrival.
    pub seq: i64,
    /// Public id of the job.
    pub id: JobId,
    /// Attempt that lost its worker.
    pub attempt: u32,
    /// Latest request of its owner.
    pub request: OwnerRequest,
}

/// Outcome of a cancellation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelAnswer {
    /// The job was waiting, and is cancelled.
    Cancelled {
        /// Sequence number in the order of arrival.
        seq: i64,
    },
    /// The job is running, and will stop.
    Stopping,
    /// The job was cancelled before.
    AlreadyCancelled,
    /// The job had already ended otherwise.
    TooLate(JobState),
    /// There is no such job.
    Unknown,
}

/// Outcome of a deletion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeleteAnswer {
    /// No worker has the job: it can be erased.
    Idle {
        /// Sequence number in the order of arrival.
        seq: i64,
        /// Number of its attempts, each of which may have left a recording.
        attempts: u32,
    },
    /// The job is running: its worker erases it after stopping.
    Running {
        /// Sequence number in the order of arrival.
        seq: i64,
    },
    /// There is no such job.
    Unknown,
}

/// Blobs that a store refers to.
#[derive(Clone, Debug, Default)]
pub struct KnownBlobs {
    /// Names of all blobs that its jobs and meshes have or may have.
    pub names: BTreeSet<String>,
    /// Names of the recordings of jobs that have ended with one.
    pub recorded: BTreeMap<JobId, String>,
    /// Rows that cannot be read: what they refer to is not among the names.
    pub unreadable: u64,
}

impl KnownBlobs {
    /// Counts a row that cannot be read.
    pub fn doubt(&mut self, seq: Option<i64>, error: &JobsError) {
        tracing::error!(seq, %error, "a row of the job store cannot be read");
        self.unreadable += 1;
    }
}

/// What is old enough to be deleted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expired<Id> {
    /// Owners and ids.
    pub found: Vec<(String, Id)>,
    /// Rows that cannot be read.
    pub unreadable: u64,
}

/// Outcome of the deletion of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshDeletion {
    /// The owner has it no more.
    Deleted {
        /// Format of the file, if no one else has it.
        unowned: Option<MeshFormat>,
    },
    /// A waiting or running job of the owner names it.
    InUse {
        /// Id of that job.
        job: JobId,
    },
    /// The owner has no such mesh.
    Unknown,
}

/// Which jobs to list, newest first.
#[derive(Clone, Debug)]
pub struct Page {
    /// Only jobs in these states; all if empty.
    pub states: Vec<JobState>,
    /// Only jobs submitted before this one.
    pub before: Option<i64>,
    /// Maximum number of jobs.
    pub limit: u32,
}

/// An event of a job, as reported in its event stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Event<'a> {
    /// Kind of event, such as `running`.
    pub kind: &'a str,
    /// Data of the event.
    pub data: Value,
}

impl Event<'static> {
    /// The job is waiting.
    pub fn queued(name: &str) -> Self {
        Self { kind: "queued", data: json!({ "state": "queued", "name": name }) }
    }

    /// A worker has started the job.
    pub fn running(attempt: u32) -> Self {
        Self { kind: "running", data: json!({ "state": "running", "attempt": attempt }) }
    }

    /// Progress of the job.
    ///
    /// # Errors
    /// If it cannot be serialised as JSON.
    pub fn progress(progress: &Progress) -> Result<Self, JobsError> {
        Ok(Self { kind: "progress", data: serde_json::to_value(progress)? })
    }

    /// The job is waiting again.
    pub fn requeued(why: Requeued) -> Self {
        Self { kind: "requeued", data: json!({ "state": "queued", "reason": why.reason() }) }
    }

    /// The job has ended.
    pub fn ended(ending: &Ending) -> Self {
        let state = JobState::of(ending);
        Self { kind: state.as_str(), data: json!({ "state": state, "failure": ending.failure() }) }
    }
}

/// What distinguishes the blobs of a store from those of others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Unique name, which stays with the store and its backups.
    pub id: String,
    /// Whether a store of blobs has been given this name.
    pub has_blobs: bool,
}

/// What another process changed in a store that is shared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// A job waits.
    Arrival(i64),
    /// The owner of a job requests its end or deletion.
    Request(i64),
    /// A job has another event.
    Event(i64),
    /// Announcements were missed: anything may have changed.
    Missed,
}

/// A stored event of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EventRow {
    /// Number of the event within the job, from 1.
    pub n: i64,
    /// Kind of event, such as `running`.
    pub kind: String,
    /// Data of the event, JSON.
    pub data: String,
}
