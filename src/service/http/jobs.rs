//! `/v1/jobs`: submit, validate, list, get, cancel, delete.

use super::answers::MadeIn;
use super::app::App;
use super::extract::{JobPath, JsonBody, Owner, Parameters, Sender};
use super::problem::{Problem, ProblemBody};
use super::submission::{SubmitAnswer, SubmitHeaders, accept};
use super::validation::{parsed, validated};
use super::wire::{JobList, SceneBody, Validation};
use crate::plan::PlanReport;
use crate::service::jobs::engine::{JsonDocument, ScenePreview};
use crate::service::jobs::held_text::HeldText;
use crate::service::jobs::store::{CancelAnswer, Job, Page};
use crate::service::jobs::to_end::to_end;
use crate::service::jobs::{JobKind, JobState};
use crate::service::meshes::MeshShelf;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// Submit a scene.
///
/// The answer is sent once the job is durable. With an `Idempotency-Key` the same request can be repeated without
/// creating a second job.
#[utoipa::path(
    post, path = "/v1/jobs", tag = "jobs", operation_id = "submit_job",
    request_body(content = SceneBody, content_type = "application/json"),
    params(SubmitHeaders), responses(SubmitAnswer)
)]
pub async fn submit(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JsonBody(body): JsonBody,
) -> Result<Response, Problem> {
    accept(&app, &owner, JobKind::Simulation, &headers, body, async |scene| Ok(scene)).await
}

/// What a validation answers.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct ValidationParameters {
    /// Whether the answer also has the bodies as they begin, to draw them; false by default.
    geometry: Option<bool>,
}

/// Validate a scene and preview its plan.
///
/// Runs nothing: mesh quality, the plan with what it keeps and omits, expected run time and memory; or all errors at
/// once.
#[utoipa::path(
    post, path = "/v1/jobs/validate", tag = "jobs", operation_id = "validate_scene",
    request_body(content = SceneBody, content_type = "application/json"), params(ValidationParameters),
    responses(
        (status = 200, description = "The scene may run", body = Validation),
        (status = 400, description = "The body is not JSON, or a parameter of the query is not valid", body = ProblemBody, content_type = "application/problem+json"),
        (status = 413, description = "The body exceeds the limit of its size", body = ProblemBody, content_type = "application/problem+json"),
        (status = 415, description = "Not declared as JSON", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "Every problem of the scene", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "Too many validations of this token are waiting", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Too many validations are waiting", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn validate(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    Parameters(parameters): Parameters<ValidationParameters>,
    JsonBody(body): JsonBody,
) -> Result<Json<Validation>, Problem> {
    let with_geometry = parameters.geometry.unwrap_or(false);
    Ok(Json(Validation::of(previewed(&app, &owner, body, with_geometry).await?)))
}

/// Filter and page of a list of jobs.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct ListParameters {
    /// Only jobs in this state; several separated by commas.
    state: Option<String>,
    /// Maximum number of jobs, 1 to 200; 50 by default.
    limit: Option<u32>,
    /// `next_cursor` of the previous page.
    cursor: Option<String>,
}

/// Memory for a job of a list that is made [bytes].
const MEMORY_OF_ROW: usize = 4 << 10;

/// List jobs, newest first.
#[utoipa::path(
    get, path = "/v1/jobs", tag = "jobs", operation_id = "list_jobs", params(ListParameters),
    responses(
        (status = 200, description = "A page of jobs", body = JobList),
        (status = 400, description = "A parameter of the query is not valid", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "Documents and answers of this client take all the memory for those of one client", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Documents and answers take all the memory for them", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn list(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    Sender(sender): Sender,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<(Extension<MadeIn>, Json<JobList>), Problem> {
    let page = page_of(&parameters)?;
    let memory = app.bodies.hold(&sender, page.limit as usize * MEMORY_OF_ROW).await?;
    // One more than requested shows whether there is another page.
    let mut rows = app.queue.store.jobs(&owner, &Page { limit: page.limit + 1, ..page.clone() }).await?;
    let has_more = rows.len() > page.limit as usize;
    rows.truncate(page.limit as usize);
    let next_cursor = rows.last().filter(|_| has_more).map(|row| format!("{:x}", row.seq));
    Ok((MadeIn::new(memory), Json(JobList { jobs: rows, next_cursor })))
}

/// Get a job with its state and progress.
#[utoipa::path(
    get, path = "/v1/jobs/{id}", tag = "jobs", operation_id = "get_job", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 200, description = "The job as it stands", body = Job),
        (status = 404, description = "No job of this owner has this id", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn get(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
) -> Result<Response, Problem> {
    let row = app.queue.store.job(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(row)).into_response())
}

/// Cancel a job.
///
/// A waiting job is cancelled immediately; a running one stops within a step or two, and keeps its recording so far.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/cancel", tag = "jobs", operation_id = "cancel_job", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 200, description = "The job is cancelled", body = Job),
        (status = 202, description = "The job will stop", body = Job),
        (status = 404, description = "No job of this owner has this id", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "The job has already ended", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn cancel(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
) -> Result<Response, Problem> {
    let cancelled = {
        let (queue, owner) = (Arc::clone(&app.queue), owner.clone());
        to_end(async move { queue.cancel(&owner, id).await }).await?
    };
    let status = match cancelled {
        CancelAnswer::Cancelled { .. } | CancelAnswer::AlreadyCancelled => StatusCode::OK,
        CancelAnswer::Stopping => StatusCode::ACCEPTED,
        CancelAnswer::TooLate(state) => return Err(Problem::too_late_to_cancel(state)),
        CancelAnswer::Unknown => return Err(Problem::no_such_job()),
    };
    let row = app.queue.store.job(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
    Ok((status, Json(row)).into_response())
}

/// Delete a job and its recording.
///
/// A running job is cancelled first. The job is no longer accessible once the answer is sent. What it has left is removed by then, or
/// in the background: when a running job has stopped, or as soon as the storage answers.
#[utoipa::path(
    delete, path = "/v1/jobs/{id}", tag = "jobs", operation_id = "delete_job", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 204, description = "The job is deleted"),
        (status = 404, description = "No job of this owner has this id", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn delete(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
) -> Result<StatusCode, Problem> {
    let queue = Arc::clone(&app.queue);
    let is_known = to_end(async move { queue.delete(&owner, id).await }).await?;
    if is_known { Ok(StatusCode::NO_CONTENT) } else { Err(Problem::no_such_job()) }
}

/// Get the summary of a job that has ended.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/summary", tag = "jobs", operation_id = "get_summary", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 200, description = "Numbers with unit, estimated numerical error and the result of the acceptance checks", body = serde_json::Value),
        (status = 404, description = "No such job, or it has no summary", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "The job has not ended", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn summary(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
) -> Result<Response, Problem> {
    let row = app.queue.store.job(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
    if !row.state.is_final() {
        return Err(Problem::not_yet("summary", row.state));
    }
    let text =
        app.queue.store.summary(&owner, id).await?.ok_or_else(|| Problem::never("summary", row.state))?;
    Ok(([(header::CONTENT_TYPE, "application/json")], text).into_response())
}

/// Get the plan of a job: the compiled scene, what is omitted and why, and the expected cost.
///
/// Compiled for each request, in every state of the job: the same scene gives the same plan.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/plan", tag = "jobs", operation_id = "get_plan", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 200, description = "The plan of the scene: what is computed, omitted and expected to cost", body = PlanReport),
        (status = 404, description = "No such job, or a what-if question or a study, which have no plan", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The scene is no longer valid: a mesh is missing", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "Too many documents or validations of this client are waiting", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Too many documents or validations are waiting", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn plan(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    Sender(sender): Sender,
    JobPath(id): JobPath,
) -> Result<Json<PlanReport>, Problem> {
    let kept = async {
        let (kind, text) = app.queue.store.document(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
        kind.purpose().map_or(Ok(text), |purpose| Err(Problem::no_plan(purpose)))
    };
    let most = app.config.runs.budget.document_bytes as usize;
    let text = app.bodies.load(&sender, most, kept).await?;
    Ok(Json(previewed(&app, &owner, text, false).await?.plan))
}

/// Validates a scene and compiles it.
async fn previewed(
    app: &Arc<App>,
    owner: &str,
    text: HeldText,
    with_geometry: bool,
) -> Result<ScenePreview, Problem> {
    let scene = parsed(app, owner, text).await?;
    let engine = Arc::clone(&app.queue.engine);
    let preview = move |scene: JsonDocument, shelf: &MeshShelf, is_wanted: &dyn Fn() -> bool| {
        engine.preview(&scene, with_geometry, shelf, is_wanted)
    };
    validated(app, owner, JobKind::Simulation, scene, preview).await
}

fn page_of(parameters: &ListParameters) -> Result<Page, Problem> {
    let names = parameters.state.as_deref().unwrap_or_default();
    let states = names.split(',').filter(|name| !name.is_empty()).map(|name| {
        let known = || JobState::ALL.map(JobState::as_str).join(", ");
        JobState::from_name(name).ok_or_else(|| {
            Problem::bad_parameter(format!("There is no state {name:?}; there are {}.", known()))
        })
    });
    let limit = parameters.limit.unwrap_or(50);
    if !(1..=200).contains(&limit) {
        return Err(Problem::bad_parameter("`limit` must be between 1 and 200."));
    }
    let before = match &parameters.cursor {
        None => None,
        Some(text) => Some(
            i64::from_str_radix(text, 16)
                .map_err(|_| Problem::bad_parameter("`cursor` must be the `next_cursor` of a page."))?,
        ),
    };
    Ok(Page { states: states.collect::<Result<_, _>>()?, before, limit })
}
