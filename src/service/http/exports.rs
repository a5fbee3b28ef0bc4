//! Exports from a job's recording: a report, tables, a bundle for clinical systems.

use super::app::App;
use super::extract::{JobPath, Owner};
use super::problem::{Problem, ProblemBody};
use crate::report::html::Origin;
use crate::report::{ReadError, RecordedRun, csv, fhir, html};
use crate::service::fair_queue::Lane;
use crate::service::jobs::store::Job;
use crate::service::jobs::{JobId, JobsError};
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use sha2::{Digest, Sha256};
use std::path::Path;
use std::sync::Arc;
use utoipa::IntoResponses;

/// Largest recording that is read in well below a second [bytes].
const SMALL_RECORDING: u64 = 8 << 20;

/// Answers to requests for what is made of a recording, where there is none.
#[derive(IntoResponses)]
#[allow(dead_code)] // never made: the contract is generated from it
pub(super) enum NoRecording {
    /// No such job, or it left no recording, or one without fields where fields are requested
    #[response(status = 404, content_type = "application/problem+json")]
    NoSuchJob(ProblemBody),
    /// The job has not ended
    #[response(status = 409, content_type = "application/problem+json")]
    NotEnded(ProblemBody),
    /// Its recording was removed from the disk, or damaged
    #[response(status = 410, content_type = "application/problem+json")]
    Gone(ProblemBody),
    /// The storage does not answer
    #[response(status = 503, content_type = "application/problem+json", headers(("Retry-After" = u64, description = "Seconds")))]
    Silent(ProblemBody),
}

/// Get the report of a job: one self-contained page with pictures, for reading or printing.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/report", tag = "jobs", operation_id = "get_report", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 200, description = "The report as a page with its pictures", body = String, content_type = "text/html"),
        NoRecording,
    )
)]
pub async fn report(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
) -> Result<Response, Problem> {
    let (run, row) = recorded(&app, &owner, id, "report").await?;
    let origin = Origin {
        // Without tokens an owner has no name.
        submitted_by: Some(owner.as_str()).filter(|name| !name.is_empty()),
        submitted_at: Some(&row.created_at),
        computed_at: row.finished_at.as_deref(),
    };
    let page = html::page(&run, &origin).map_err(|error| Problem::internal(&error))?;
    let policy = content_security_policy(&page);
    let headers = [
        (header::CONTENT_TYPE, "text/html; charset=utf-8".to_owned()),
        (header::CONTENT_SECURITY_POLICY, policy),
    ];
    Ok((headers, page).into_response())
}

/// Policy of a report: its own style sheet, by digest, and nothing else.
fn content_security_policy(page: &str) -> String {
    let style = page.split_once("<style>").and_then(|(_, rest)| rest.split_once("</style>"));
    let digest = BASE64_STANDARD.encode(Sha256::digest(style.map_or("", |(style, _)| style)));
    format!(
        "default-src 'none'; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'"
    )
}

/// Get a job as a FHIR R4 Bundle: Observations with their numerical errors, the Device that made them, their
/// Provenance.
///
/// The codes belong to a separate code system; units are UCUM.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/fhir", tag = "jobs", operation_id = "get_fhir", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 200, description = "Bundle of observations with their units and errors", body = serde_json::Value, content_type = "application/fhir+json"),
        NoRecording,
    )
)]
pub async fn bundle(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
) -> Result<Response, Problem> {
    let (run, row) = recorded(&app, &owner, id, "bundle").await?;
    let finished = row.finished_at.as_deref();
    let bundle = fhir::bundle(&run, finished.unwrap_or(&row.created_at), finished);
    Ok(([(header::CONTENT_TYPE, "application/fhir+json")], bundle.to_string()).into_response())
}

/// Get force, patch area and energies of a job over time, as CSV.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/export.csv", tag = "jobs", operation_id = "get_csv", params(("id" = uuid::Uuid, Path)),
    responses(
        (status = 200, description = "Table of the recorded steps, with a header", body = String, content_type = "text/csv"),
        NoRecording,
    )
)]
pub async fn table(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
) -> Result<Response, Problem> {
    let (run, _) = recorded(&app, &owner, id, "table").await?;
    let mut text = Vec::new();
    csv::write(&run, &mut text).map_err(|error| Problem::internal(&error))?;
    Ok(([(header::CONTENT_TYPE, "text/csv; charset=utf-8")], text).into_response())
}

/// The recording of a job that has ended, read on a thread that may wait for files.
async fn recorded(app: &Arc<App>, owner: &str, id: JobId, what: &str) -> Result<(RecordedRun, Job), Problem> {
    let row = recorded_row(app, owner, id, what).await?;
    let (blobs, name) = (Arc::clone(&app.queue.blobs), row.recording_name());
    let read = move || {
        let blob = blobs.open(&name)?;
        Ok::<_, JobsError>(blob.map(|blob| RecordedRun::of(blob, Path::new(&name))))
    };
    let lane = match &row.recording {
        Some(recording) if recording.bytes <= SMALL_RECORDING => Lane::Small,
        _ => Lane::Large,
    };
    match app.queue.unless_silent(app.validation_slots.call(owner, lane, read)).await?? {
        Err(error) if error.is_passing() => Err(error.into()),
        Ok(Some(Ok(run))) => Ok((run, row)),
        // From a run that lost its worker, or from another engine.
        Ok(Some(Err(ReadError::NoSummary { .. } | ReadError::Numbers { .. }))) => {
            Err(Problem::never(what, row.state))
        }
        other => {
            tracing::error!(job = %id, ?other, "a recording cannot be read");
            Err(Problem::recording_lost())
        }
    }
}

/// A job that has ended with a recording; `what` is to be made of it.
pub(super) async fn recorded_row(app: &App, owner: &str, id: JobId, what: &str) -> Result<Job, Problem> {
    let row = app.queue.store.job(owner, id).await?.ok_or_else(Problem::no_such_job)?;
    if !row.state.is_final() {
        return Err(Problem::not_yet(what, row.state));
    }
    if row.recording.is_none() {
        return Err(Problem::never(what, row.state));
    }
    Ok(row)
}
