//! `/v1/jobs`: submit, validate, list, get, cancel, delete.

use super::app::App;
use super::extract::{JobPath, JsonBody, Owner, Parameters};
use super::problem::{Problem, ProblemBody};
use super::wire::{JobList, SceneBody, Validation};
use crate::blobs::hexadecimal;
use crate::plan::PlanReport;
use crate::scene::Problems;
use crate::service::fair_queue::Lane;
use crate::service::jobs::engine::JsonDocument;
use crate::service::jobs::store::{CancelAnswer, Job, NewJob, Page, Submitted};
use crate::service::jobs::{JobKind, JobState, Priority};
use crate::service::meshes::MeshShelf;
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::sync::Arc;
use utoipa::{IntoParams, IntoResponses};

/// Largest number of elements of a scene that is validated in well below a second.
const SMALL_SCENE: u64 = 20_000;
/// Marks the answer to a repeated request.
const REPLAYED: HeaderName = HeaderName::from_static("idempotent-replayed");

/// Headers of requests that create a job.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Header)]
pub struct SubmitHeaders {
    /// 1 to 255 visible ASCII characters chosen by the client; used once, for one body at one address
    #[serde(rename = "Idempotency-Key")]
    _idempotency_key: Option<String>,
    /// `low`, `normal` or `high`: which of the waiting jobs of this owner begins first; `normal` by default
    #[serde(rename = "Job-Priority")]
    _job_priority: Option<String>,
}

/// Answers to requests that create a job.
#[derive(IntoResponses)]
#[allow(dead_code, clippy::large_enum_variant)] // never made: the contract is generated from it
pub enum SubmitAnswer {
    /// The job is stored and waits for a worker
    #[response(status = 202, headers(
        ("Location" = String, description = "Address of the job"),
        ("Idempotent-Replayed" = String, description = "`true` when the key was seen before with this body")))]
    Accepted(Job),
    /// The body is not JSON
    #[response(status = 400, content_type = "application/problem+json")]
    NotJson(ProblemBody),
    /// As many jobs or bytes are kept as an owner may keep
    #[response(status = 403, content_type = "application/problem+json")]
    QuotaUsed(ProblemBody),
    /// Idempotency-Key already used with another body or address
    #[response(status = 409, content_type = "application/problem+json")]
    KeyReused(ProblemBody),
    /// The body exceeds the limit of its size
    #[response(status = 413, content_type = "application/problem+json")]
    TooLarge(ProblemBody),
    /// Not declared as JSON
    #[response(status = 415, content_type = "application/problem+json")]
    NotDeclared(ProblemBody),
    /// All errors of the document, including its scene
    #[response(status = 422, content_type = "application/problem+json")]
    Invalid(ProblemBody),
    /// Too many validations or jobs of this token are waiting
    #[response(status = 429, content_type = "application/problem+json", headers(("Retry-After" = u64, description = "Seconds")))]
    TooMany(ProblemBody),
    /// Queue full or shutting down
    #[response(status = 503, content_type = "application/problem+json")]
    Unavailable(ProblemBody),
}

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

/// Identity of a request: the same body at another address is a different request.
fn request_sha256(kind: JobKind, body: &[u8]) -> String {
    let address = match kind {
        JobKind::Simulation => "/v1/jobs",
        JobKind::Study => "/v1/studies",
        JobKind::WhatIf => "/v1/what-if",
    };
    let digest = Sha256::new().chain_update(address).chain_update([0]).chain_update(body);
    hexadecimal(&digest.finalize())
}

/// Creates a job from a body. `completed` validates the body and returns what is stored, unless the request is
/// repeated.
pub(super) async fn accept(
    app: &Arc<App>,
    owner: &str,
    kind: JobKind,
    headers: &HeaderMap,
    text: Vec<u8>,
    completed: impl AsyncFnOnce(JsonDocument) -> Result<JsonDocument, Problem>,
) -> Result<Response, Problem> {
    if app.queue.is_closing() {
        return Err(Problem::unavailable("The service is shutting down."));
    }
    let (idempotency_key, priority) = (idempotency_key(headers)?, priority(headers)?);
    let body_sha256 = request_sha256(kind, &text);
    // A repeated request needs no second validation of the scene.
    if let Some(key) = &idempotency_key
        && let Some(earlier) = app.queue.store.replay(owner, key, &body_sha256).await?
    {
        return submitted(earlier);
    }
    // Validate the document and store the job.
    let document = completed(parsed(app, owner, text).await?).await?;
    let engine = Arc::clone(&app.queue.engine);
    let (checked, document, meshes) = validated(app, owner, kind, document, move |document, shelf| {
        let checked = engine.check(kind, &document, shelf);
        // For scenes the schema reports repeated keys; members read by name would silently lose one of them.
        let repeated = if kind == JobKind::Simulation { Vec::new() } else { document.parsed.problems };
        Ok((Problems(repeated).then(checked)?, document.text, shelf.found()))
    })
    .await?;
    let new = NewJob {
        owner: owner.to_owned(),
        idempotency_key,
        body_sha256,
        kind,
        priority,
        document,
        name: checked.name,
        content_hash: checked.content_hash,
        end_time_s: checked.end_time_s,
        warnings: checked.warnings,
        memory_bytes: checked.memory_bytes,
        meshes,
    };
    submitted(app.queue.submit(&new).await?)
}

/// Validate a scene and preview its plan.
///
/// Runs nothing: mesh quality, the plan with what it keeps and omits, expected run time and memory; or all errors at
/// once.
#[utoipa::path(
    post, path = "/v1/jobs/validate", tag = "jobs", operation_id = "validate_scene",
    request_body(content = SceneBody, content_type = "application/json"),
    responses(
        (status = 200, description = "The scene may run", body = Validation),
        (status = 400, description = "The body is not JSON", body = ProblemBody, content_type = "application/problem+json"),
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
    JsonBody(body): JsonBody,
) -> Result<Json<Validation>, Problem> {
    let scene = parsed(&app, &owner, body).await?;
    let engine = Arc::clone(&app.queue.engine);
    let check = move |scene: JsonDocument, shelf: &MeshShelf| engine.preview(&scene, shelf);
    let preview = validated(&app, &owner, JobKind::Simulation, scene, check).await?;
    Ok(Json(Validation::of(preview)))
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

/// List jobs, newest first.
#[utoipa::path(
    get, path = "/v1/jobs", tag = "jobs", operation_id = "list_jobs", params(ListParameters),
    responses(
        (status = 200, description = "A page of jobs", body = JobList),
        (status = 400, description = "A parameter of the query is not valid", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn list(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Json<JobList>, Problem> {
    let page = page_of(&parameters)?;
    // One more than requested shows whether there is another page.
    let mut rows = app.queue.store.jobs(&owner, &Page { limit: page.limit + 1, ..page.clone() }).await?;
    let has_more = rows.len() > page.limit as usize;
    rows.truncate(page.limit as usize);
    let next_cursor = rows.last().filter(|_| has_more).map(|row| format!("{:x}", row.seq));
    Ok(Json(JobList { jobs: rows, next_cursor }))
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
    let status = match app.queue.cancel(&owner, id).await? {
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
    if app.queue.delete(&owner, id).await? { Ok(StatusCode::NO_CONTENT) } else { Err(Problem::no_such_job()) }
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
    )
)]
pub async fn plan(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
) -> Result<Json<PlanReport>, Problem> {
    let (kind, text) = app.queue.store.document(&owner, id).await?.ok_or_else(Problem::no_such_job)?;
    if let Some(purpose) = kind.purpose() {
        return Err(Problem::no_plan(purpose));
    }
    let engine = Arc::clone(&app.queue.engine);
    let scene = parsed(&app, &owner, text).await?;
    let check = move |scene: JsonDocument, shelf: &MeshShelf| engine.preview(&scene, shelf);
    let preview = validated(&app, &owner, kind, scene, check).await?;
    Ok(Json(preview.plan))
}

/// Parses a document in a slot of validation: it may have megabytes.
async fn parsed(app: &App, owner: &str, text: Vec<u8>) -> Result<JsonDocument, Problem> {
    let read = app.validation_slots.call(owner, Lane::Small, move || JsonDocument::read(text)).await?;
    read.map_err(|e| Problem::bad_json(&e))
}

/// Validates a document with its scene, given the meshes of its owner. Large scenes have a queue of their own.
async fn validated<T: Send + 'static>(
    app: &Arc<App>,
    owner: &str,
    kind: JobKind,
    document: JsonDocument,
    check: impl FnOnce(JsonDocument, &MeshShelf) -> Result<T, Problems> + Send + 'static,
) -> Result<T, Problem> {
    let (shelf, engine) = (app.queue.shelf(owner), Arc::clone(&app.queue.engine));
    let if_small = move || {
        if engine.elements(kind, &document, &shelf) <= SMALL_SCENE {
            Ok(check(document, &shelf))
        } else {
            Err(move || check(document, &shelf))
        }
    };
    let checked = match app.validation_slots.call(owner, Lane::Small, if_small).await? {
        Ok(checked) => checked,
        Err(large) => app.validation_slots.call(owner, Lane::Large, large).await?,
    };
    checked.map_err(|errors| Problem::invalid_scene(kind.document(), errors))
}

/// Response to a submission.
fn submitted(submitted: Submitted) -> Result<Response, Problem> {
    let (row, is_replay) = match submitted {
        Submitted::Created(row) => (row, false),
        Submitted::Replayed(row) => (row, true),
        Submitted::KeyReused => return Err(Problem::idempotency_key_reused()),
        Submitted::MeshGone { id } => return Err(Problem::mesh_gone(&id)),
    };
    let location = HeaderValue::try_from(&row.links.this).map_err(|e| Problem::internal(&e))?;
    let mut response = (StatusCode::ACCEPTED, Json(row)).into_response();
    response.headers_mut().insert(header::LOCATION, location);
    if is_replay {
        response.headers_mut().insert(REPLAYED, HeaderValue::from_static("true"));
    }
    Ok(response)
}

/// A header that may be sent once.
fn once<'a>(headers: &'a HeaderMap, name: &str) -> Result<Option<&'a HeaderValue>, Problem> {
    let mut values = headers.get_all(name).iter();
    let value = values.next();
    if values.next().is_some() {
        return Err(Problem::bad_header(name, "given once"));
    }
    Ok(value)
}

/// Priority of a new job.
fn priority(headers: &HeaderMap) -> Result<Priority, Problem> {
    let Some(value) = once(headers, "Job-Priority")? else { return Ok(Priority::default()) };
    let known = value.to_str().ok().and_then(Priority::from_name);
    known.ok_or_else(|| Problem::bad_header("Job-Priority", "`low`, `normal` or `high`"))
}

/// The client's idempotency key, if it sent one.
fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let Some(value) = once(headers, "Idempotency-Key")? else { return Ok(None) };
    let key = value
        .to_str()
        .ok()
        .filter(|k| (1..=255).contains(&k.len()) && k.bytes().all(|b| b.is_ascii_graphic()));
    let refusal = || Problem::bad_header("Idempotency-Key", "1 to 255 visible ASCII characters");
    key.map(|k| Some(k.to_owned())).ok_or_else(refusal)
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
