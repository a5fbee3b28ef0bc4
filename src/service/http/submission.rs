//! Submission of a job: once per key, validated, and within what its owner may ask for.

use super::app::App;
use super::problem::{Problem, ProblemBody};
use super::validation::{parsed, validated};
use crate::blobs::hexadecimal;
use crate::scene::Problems;
use crate::service::jobs::engine::JsonDocument;
use crate::service::jobs::held_text::HeldText;
use crate::service::jobs::store::{Job, NewJob, Submitted};
use crate::service::jobs::to_end::to_end;
use crate::service::jobs::{JobKind, Priority};
use crate::service::traces::context_of;
use axum::Json;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::sync::Arc;
use tracing::Span;
use utoipa::{IntoParams, IntoResponses};

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
    /// Too many documents, validations or jobs of this client are waiting
    #[response(status = 429, content_type = "application/problem+json", headers(("Retry-After" = u64, description = "Seconds")))]
    TooMany(ProblemBody),
    /// Queue full or shutting down
    #[response(status = 503, content_type = "application/problem+json", headers(("Retry-After" = u64, description = "Seconds")))]
    Unavailable(ProblemBody),
    /// The service has no space left
    #[response(status = 507, content_type = "application/problem+json", headers(("Retry-After" = u64, description = "Seconds")))]
    Full(ProblemBody),
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
    text: HeldText,
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
    let (checked, document, meshes) =
        validated(app, owner, kind, document, move |document, shelf, is_wanted| {
            let checked = engine.check(kind, &document, shelf, is_wanted);
            // For scenes the schema reports repeated keys; members read by name would silently lose one of them.
            let reported = document.parsed().filter(|_| kind != JobKind::Simulation);
            let repeated = reported.map(|parsed| parsed.problems.clone()).unwrap_or_default();
            Ok((Problems(repeated).then(checked)?, document.text, shelf.found()))
        })
        .await?;
    let (document, _memory) = document.into_parts();
    let new = NewJob {
        owner: owner.to_owned(),
        idempotency_key,
        body_sha256,
        kind,
        priority,
        trace: context_of(&Span::current()),
        document,
        name: checked.name,
        content_hash: checked.content_hash,
        end_time_s: checked.end_time_s,
        warnings: checked.warnings,
        memory_bytes: checked.memory_bytes,
        meshes,
    };
    let queue = Arc::clone(&app.queue);
    submitted(to_end(async move { queue.submit(&new).await }).await?)
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
