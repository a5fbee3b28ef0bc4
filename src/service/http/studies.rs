//! `/v1/studies`: many runs of one scene as one job.

use super::App;
use super::extract::{JsonText, Owner};
use super::jobs::accept;
use super::problem::{Problem, ProblemBody};
use super::wire::Job;
use crate::service::jobs::study_job::StudyDocument;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use std::sync::Arc;

/// Submit a study.
///
/// It becomes a job like any other: its progress under `/v1/jobs/{id}`, its results under `/v1/jobs/{id}/summary`. It has no
/// recording.
#[utoipa::path(
    post, path = "/v1/studies", tag = "studies", operation_id = "submit_study",
    request_body(content = StudyDocument, content_type = "application/json"),
    params(("Idempotency-Key" = Option<String>, Header, description = "1 to 255 visible ASCII characters of the client's choice")),
    responses(
        (status = 202, description = "Accepted", body = Job, headers(("Location" = String, description = "Address of the job"))),
        (status = 400, description = "Not JSON", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Idempotency-Key of another body", body = ProblemBody, content_type = "application/problem+json"),
        (status = 413, description = "Too large", body = ProblemBody, content_type = "application/problem+json"),
        (status = 415, description = "Not declared as JSON", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "Every problem of the study and its scene", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Queue full or shutting down", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn submit(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JsonText(body): JsonText,
) -> Result<Response, Problem> {
    let (engine, study) = (Arc::clone(&app.queue.engine), body.clone());
    accept(&app, owner, &headers, body, move |shelf| engine.check_study(&study, shelf)).await
}
