//! `/v1/studies`: many runs of one scene as one job.

use super::app::App;
use super::extract::{JsonBody, Owner};
use super::problem::Problem;
use super::submission::{SubmitAnswer, SubmitHeaders, accept};
use crate::service::jobs::JobKind;
use crate::service::jobs::study_job::StudyDocument;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use std::sync::Arc;

/// Submit a study.
///
/// It becomes an ordinary job: progress under `/v1/jobs/{id}`, results under `/v1/jobs/{id}/summary`, without a
/// recording.
#[utoipa::path(
    post, path = "/v1/studies", tag = "studies", operation_id = "submit_study",
    request_body(content = StudyDocument, content_type = "application/json"),
    params(SubmitHeaders), responses(SubmitAnswer)
)]
pub async fn submit(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    headers: HeaderMap,
    JsonBody(body): JsonBody,
) -> Result<Response, Problem> {
    accept(&app, &owner, JobKind::Study, &headers, body, async |study| Ok(study)).await
}
