//! `/v1/studies`: many runs of one scene as one job.

use super::App;
use super::extract::{JsonText, Owner};
use super::jobs::{Submission, SubmitAnswer, SubmitHeaders, accept, with_repeated_keys};
use super::problem::Problem;
use crate::service::jobs::study_job::StudyDocument;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use std::future::ready;
use std::sync::Arc;

/// Submit a study.
///
/// It becomes a job like any other: its progress under `/v1/jobs/{id}`, its results under `/v1/jobs/{id}/summary`. It has no
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
    JsonText(body): JsonText,
) -> Result<Response, Problem> {
    let (engine, kept) = (Arc::clone(&app.queue.engine), ready(Ok(body.clone())));
    let request = Submission { address: "/v1/studies", what: "study", headers: &headers, body: &body };
    accept(&app, &owner, &request, kept, move |study, shelf| {
        with_repeated_keys(study, engine.check_study(study, shelf))
    })
    .await
}
