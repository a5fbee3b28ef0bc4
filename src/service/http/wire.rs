//! What goes over the wire.

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

/// What this service is not. It is said in every job and in a header of every answer.
pub const NOTICE: &str = "Research use only: not a medical device, not a diagnosis.";

/// A scene document; its schema is a file of its own, which the service also serves at `/scene.schema.json`.
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

/// A job.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Job {
    /// Its id.
    pub id: Uuid,
    /// Name of the scene.
    pub name: String,
    /// Where it stands.
    pub state: JobState,
    /// What it does at the moment.
    pub phase: Phase,
    /// Share of the run that is done, 0 … 1.
    pub progress: f64,
    /// Steps done.
    pub step: u64,
    /// Steps expected in all.
    pub expected_steps: Option<u64>,
    /// Simulated time reached [s]; negative while settling.
    pub simulated_time_s: f64,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// Expected time to the end on the wall clock [s].
    pub eta_s: Option<f64>,
    /// Its place among those that wait, the next one is 1.
    pub queue_position: Option<u64>,
    /// How often a worker took it.
    pub attempts: u32,
    /// Whether it was asked to stop.
    pub cancel_requested: bool,
    /// When it came, RFC 3339.
    pub created_at: String,
    /// When a worker took it last.
    pub started_at: Option<String>,
    /// When it ended.
    pub finished_at: Option<String>,
    /// Digest of the document and its meshes: the name of the question.
    pub content_hash: String,
    /// What is odd about the scene.
    pub warnings: Vec<Problem>,
    /// Why it failed.
    pub failure: Option<Failure>,
    /// Its recording, when final.
    pub recording: Option<FinalRecording>,
    /// Where more can be asked.
    pub links: JobLinks,
    /// What the numbers are not.
    pub notice: &'static str,
}

/// Addresses of a job.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct JobLinks {
    /// The job.
    #[serde(rename = "self")]
    pub this: String,
    /// Its events.
    pub events: String,
    /// Stops it.
    pub cancel: String,
    /// What its scene is compiled to.
    pub plan: String,
    /// Its summary, if it has one.
    pub summary: Option<String>,
    /// Its recording, if it has one.
    pub recording: Option<String>,
}

impl Job {
    /// The job of a row of the store.
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

/// What a valid scene would be.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Validation {
    /// Always true: what is not valid is answered as a problem.
    pub valid: bool,
    /// Name of the scene.
    pub name: String,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// What is odd, but not wrong.
    pub warnings: Vec<Problem>,
    /// The bodies and their meshes, placed [m].
    pub bodies: Vec<BodySummary>,
    /// What the run would cost, and what it would do.
    pub plan: PlanReport,
    /// What the numbers are not.
    pub notice: &'static str,
}

impl Validation {
    /// The answer to a scene that may run.
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
