//! A job as its owner sees it: what the store returns, and what the routes send.

use super::headline::Headline;
use crate::scene::Problem;
use crate::service::jobs::{FinalRecording, JobId, JobState, Phase, Priority};
use crate::service::shelves::recording_name;
use crate::step::Failure;
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

/// Disclaimer in every job and in a header of every answer.
pub const NOTICE: &str = "Research use only: not a medical device, not a diagnosis.";

/// A job with its progress and results.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Job {
    /// Sequence number in the order of arrival.
    #[serde(skip)]
    pub seq: i64,
    /// Unique id of the job.
    pub id: Uuid,
    /// Name of the scene.
    pub name: String,
    /// Priority among the jobs of its owner.
    pub priority: Priority,
    /// Current state of the job.
    pub state: JobState,
    /// Current phase of the job.
    pub phase: Phase,
    /// Completed fraction of the run, 0 … 1.
    pub progress: f64,
    /// Number of steps completed.
    pub step: u64,
    /// Expected total number of steps.
    pub expected_steps: Option<u64>,
    /// Simulated time reached [s]; negative during dynamic relaxation.
    pub simulated_time_s: f64,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// Expected time to the end on the wall clock [s].
    pub eta_s: Option<f64>,
    /// Position among the waiting jobs of its owner, from 1: owners take turns.
    pub queue_position: Option<u64>,
    /// Number of attempts so far.
    pub attempts: u32,
    /// Whether cancellation was requested.
    pub cancel_requested: bool,
    /// Time of submission, RFC 3339.
    pub created_at: String,
    /// Start of the latest attempt.
    pub started_at: Option<String>,
    /// Time of the end.
    pub finished_at: Option<String>,
    /// Digest of the document and its meshes: identifies the question.
    pub content_hash: String,
    /// Warnings from the validation of the scene.
    pub warnings: Vec<Problem>,
    /// Diagnosis of a failed job.
    pub failure: Option<Failure>,
    /// Whether its run gives no result: a check failed, and the summary lists its numbers as withheld, with the reason.
    pub withheld: bool,
    /// Projectile and main numbers, for lists; null until the job has ended, and where there are none.
    pub headline: Option<Headline>,
    /// Final recording, if there is one.
    pub recording: Option<FinalRecording>,
    /// Addresses related to the job.
    pub links: JobLinks,
    /// The disclaimer of every result.
    pub notice: &'static str,
}

impl Job {
    /// Name of the blob of its recording.
    pub fn recording_name(&self) -> String {
        recording_name(self.id, self.recording.as_ref().map_or(1, |recording| recording.attempt))
    }
}

/// Addresses of a job.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct JobLinks {
    /// Address of the job itself.
    #[serde(rename = "self")]
    pub this: String,
    /// Address of its event stream.
    pub events: String,
    /// Address that cancels the job.
    pub cancel: String,
    /// Address of the compiled plan.
    pub plan: String,
    /// Address of its summary, if it has one.
    pub summary: Option<String>,
    /// Address of its recording, if it has one.
    pub recording: Option<String>,
}

impl JobLinks {
    /// The addresses of a job that has these results.
    pub fn new(id: JobId, has_summary: bool, has_recording: bool) -> Self {
        let this = format!("/v1/jobs/{id}");
        Self {
            events: format!("{this}/events"),
            cancel: format!("{this}/cancel"),
            plan: format!("{this}/plan"),
            summary: has_summary.then(|| format!("{this}/summary")),
            recording: has_recording.then(|| format!("{this}/recording")),
            this,
        }
    }
}
