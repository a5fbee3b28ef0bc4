//! Documents exchanged over HTTP.

use crate::plan::PlanReport;
use crate::scene::Problem;
use crate::scene::summary::BodySummary;
use crate::service::jobs::engine::ScenePreview;
use crate::service::jobs::store::JobRow;
use crate::service::jobs::{FinalRecording, JobState, Phase};
use crate::step::Failure;
use serde::Serialize;
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};
use uuid::Uuid;

/// Disclaimer in every job and in a header of every answer.
pub const NOTICE: &str = "Research use only: not a medical device, not a diagnosis.";

/// A scene document; its schema is a separate file, which the service also serves at `/scene.schema.json`.
#[derive(Debug)]
pub struct SceneBody;

impl PartialSchema for SceneBody {
    fn schema() -> RefOr<Schema> {
        RefOr::Ref(Ref::new("scene.schema.json"))
    }
}
impl ToSchema for SceneBody {
    fn name() -> std::borrow::Cow<'static, str> {
        "Scene".into()
    }
}

/// A job with its progress and results.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Job {
    /// Unique id of the job.
    pub id: Uuid,
    /// Name of the scene.
    pub name: String,
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
    /// Position in the queue, from 1.
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
    /// Final recording, if there is one.
    pub recording: Option<FinalRecording>,
    /// Addresses related to the job.
    pub links: JobLinks,
    /// The disclaimer of every result.
    pub notice: &'static str,
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

impl Job {
    /// Converts a record of the store.
    pub fn of(row: JobRow) -> Self {
        let this = format!("/v1/jobs/{}", row.id);
        let links = JobLinks {
            events: format!("{this}/events"),
            cancel: format!("{this}/cancel"),
            plan: format!("{this}/plan"),
            summary: row.has_summary.then(|| format!("{this}/summary")),
            recording: row.recording.is_some().then(|| format!("{this}/recording")),
            this,
        };
        Self {
            id: row.id,
            name: row.name,
            state: row.state,
            phase: row.progress.phase,
            progress: row.progress.progress,
            step: row.progress.step,
            expected_steps: row.progress.expected_steps,
            simulated_time_s: row.progress.simulated_time_s,
            end_time_s: row.end_time_s,
            eta_s: row.progress.eta_s,
            queue_position: row.queue_position,
            attempts: row.attempts,
            cancel_requested: row.cancel_requested,
            created_at: row.created_at,
            started_at: row.started_at,
            finished_at: row.finished_at,
            content_hash: row.content_hash,
            warnings: row.warnings,
            failure: row.failure,
            recording: row.recording,
            links,
            notice: NOTICE,
        }
    }
}

/// A page of jobs.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct JobList {
    /// The jobs, newest first.
    pub jobs: Vec<Job>,
    /// `cursor` of the next page; null on the last one.
    pub next_cursor: Option<String>,
}

/// Preview of a valid scene.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Validation {
    /// Always true: an invalid scene is answered with a problem.
    pub valid: bool,
    /// Name of the scene.
    pub name: String,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// Warnings that do not prevent a run.
    pub warnings: Vec<Problem>,
    /// The bodies and their meshes, placed [m].
    pub bodies: Vec<BodySummary>,
    /// Plan of the run and its expected cost.
    pub plan: PlanReport,
    /// The disclaimer of every result.
    pub notice: &'static str,
}

impl Validation {
    /// The answer for a scene that can run.
    pub fn of(preview: ScenePreview) -> Self {
        Self {
            valid: true,
            name: preview.checked.name,
            content_hash: preview.checked.content_hash,
            warnings: preview.checked.warnings,
            bodies: preview.bodies,
            plan: preview.plan,
            notice: NOTICE,
        }
    }
}
