//! `/v1/what-if`: many cases of one scene as one job.

use super::app::App;
use super::extract::{JsonBody, Owner};
use super::problem::Problem;
use super::submission::{SubmitAnswer, SubmitHeaders, accept};
use crate::scene::json::Parsed;
use crate::scene::problem::Pointer;
use crate::scene::{self, Problems};
use crate::service::jobs::engine::JsonDocument;
use crate::service::jobs::{JobId, JobKind};
use crate::study::what_if::WhatIfDocument;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;
use std::sync::Arc;

/// Ask a what-if question.
///
/// A base (a scene, or a job by its id) and what varies: explicit cases, one parameter at a time, a sample, limits. It
/// becomes a job: every case is an event `case` under `/v1/jobs/{id}/events` as soon as it is available, in the order
/// of the cases, and the whole answer is `/v1/jobs/{id}/summary`. It has no recording.
#[utoipa::path(
    post, path = "/v1/what-if", tag = "studies", operation_id = "ask_what_if",
    request_body(content = WhatIfDocument, content_type = "application/json"),
    params(SubmitHeaders), responses(SubmitAnswer)
)]
pub async fn ask(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JsonBody(body, _held): JsonBody,
) -> Result<Response, Problem> {
    let completed = async |question| with_scene(&app, &owner, question).await;
    accept(&app, &owner, JobKind::WhatIf, &headers, body, completed).await
}

/// The part of a long question that names a job, read without the rest.
#[derive(Deserialize)]
struct Based {
    job: Option<IgnoredAny>,
}

/// Replaces a named job by its scene, so that the question no longer depends on that job.
async fn with_scene(app: &App, owner: &str, body: JsonDocument) -> Result<JsonDocument, Problem> {
    // Any other body is left to the validation.
    let names_job = match body.parsed() {
        Some(content) => content.value.get("job").is_some(),
        None => matches!(serde_json::from_slice(&body.text), Ok(Based { job: Some(_) })),
    };
    if !names_job {
        return Ok(body);
    }
    let content = body.content().map_err(|errors| Problem::invalid_scene("question", errors))?.into_owned();
    let Value::Object(mut question) = content.value else { return Ok(body) };
    let Some(job) = question.remove("job") else { return Ok(body) };
    let refuse = |code: &'static str, message: &str, limit: &str, remedy: &str| {
        let problem = scene::Problem::error(code, &Pointer::root().key("job"), message);
        let problem = problem.value(job.clone()).limit(limit).remedy(remedy);
        let all: Problems = content.problems.iter().cloned().chain([problem]).collect();
        Problem::invalid_scene("question", all)
    };
    // The base must be a job that runs a scene.
    if question.contains_key("scene") {
        return Err(refuse(
            "bad_base",
            "the question has two bases",
            "one of `scene` and `job`",
            "omit one of them",
        ));
    }
    let id: Option<JobId> = job.as_str().and_then(|text| text.parse().ok());
    let kept = match id {
        Some(id) => app.queue.store.document(owner, id).await?,
        None => None,
    };
    if let Some(purpose) = kept.as_ref().and_then(|(kind, _)| kind.purpose()) {
        return Err(refuse(
            "no_base",
            &format!("this job {purpose}: it has no scene of its own"),
            "the id of a job that runs a scene",
            "name the job of its base, or send the scene of the base as `scene`",
        ));
    }
    let scene: Option<Value> = kept.and_then(|(_, text)| serde_json::from_slice(&text).ok());
    let unknown = || refuse("bad_base", "there is no such job", "the id of a job", "see /v1/jobs");
    let scene = scene.ok_or_else(unknown)?;
    // Insert its scene into the question.
    question.insert("scene".into(), scene);
    let value = Value::Object(question);
    let text = value.to_string().into_bytes();
    Ok(JsonDocument::of(text, Parsed { value, problems: content.problems }))
}
