//! `/v1/jobs/{id}/export.stl` and `.ply`: the deformed surfaces of a job at one time.

use super::app::App;
use super::exports::{NoRecording, recorded_row};
use super::extract::{JobPath, Owner, Parameters};
use super::problem::{Problem, ProblemBody};
use super::recording::file_name;
use crate::record::RecordError;
use crate::report::ReadError;
use crate::report::surface::{Surfaces, surfaces_at, write_ply, write_stl};
use crate::service::fair_queue::Lane;
use crate::service::jobs::{JobId, JobsError};
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use utoipa::IntoParams;

/// The time of the surfaces.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SurfaceParameters {
    /// Simulated time [s], of which the nearest with fields is taken; by default the last one.
    time_s: Option<f64>,
}

/// Get the deformed surfaces of all bodies of a job at one time, as one binary STL file in metres.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/export.stl", tag = "jobs", operation_id = "get_stl", params(("id" = uuid::Uuid, Path), SurfaceParameters),
    responses(
        (status = 200, description = "The triangles of the surfaces", body = Vec<u8>, content_type = "model/stl", headers(("Content-Disposition" = String))),
        (status = 400, description = "The recording has no fields around that time", body = ProblemBody, content_type = "application/problem+json"),
        NoRecording,
    )
)]
pub async fn stl(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
    Parameters(parameters): Parameters<SurfaceParameters>,
) -> Result<Response, Problem> {
    surfaces(&app, (&owner, id), &parameters, ("stl", "model/stl"), write_stl).await
}

/// Get the deformed surfaces of all bodies of a job at one time, as one binary PLY file in metres, each triangle with the number of
/// its body.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/export.ply", tag = "jobs", operation_id = "get_ply", params(("id" = uuid::Uuid, Path), SurfaceParameters),
    responses(
        (status = 200, description = "The triangles of the surfaces", body = Vec<u8>, content_type = "model/ply", headers(("Content-Disposition" = String))),
        (status = 400, description = "The recording has no fields around that time", body = ProblemBody, content_type = "application/problem+json"),
        NoRecording,
    )
)]
pub async fn ply(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    JobPath(id): JobPath,
    Parameters(parameters): Parameters<SurfaceParameters>,
) -> Result<Response, Problem> {
    surfaces(&app, (&owner, id), &parameters, ("ply", "model/ply"), write_ply).await
}

/// The surfaces as a file with this extension and media type.
async fn surfaces(
    app: &Arc<App>,
    (owner, id): (&str, JobId),
    parameters: &SurfaceParameters,
    (extension, media_type): (&str, &str),
    write: fn(&Surfaces, &mut dyn Write) -> io::Result<()>,
) -> Result<Response, Problem> {
    let row = recorded_row(app, owner, id, "surfaces").await?;
    let (blobs, blob, time_s) = (Arc::clone(&app.queue.blobs), row.recording_name(), parameters.time_s);
    let work = move || {
        let Some(recording) = blobs.open(&blob).map_err(JobsError::from)? else {
            return Err(Problem::recording_lost());
        };
        let found = surfaces_at(recording, Path::new(&blob), time_s).map_err(|error| problem(&error))?;
        let mut file = Vec::new();
        write(&found, &mut file).map_err(|error| Problem::internal(&error))?;
        Ok(file)
    };
    // All fields are read to find one time.
    let file = app.queue.unless_silent(app.validation_slots.call(owner, Lane::Large, work)).await???;
    let disposition = format!("attachment; filename=\"{}-{id}.{extension}\"", file_name(&row.name));
    let headers = [(header::CONTENT_TYPE, media_type.to_owned()), (header::CONTENT_DISPOSITION, disposition)];
    Ok((headers, file).into_response())
}

fn problem(error: &ReadError) -> Problem {
    match error {
        ReadError::Fields(RecordError::NoFields) => Problem::no_fields(),
        ReadError::NoSuchTime { requested, first, last, .. } => Problem::bad_parameter(format!(
            "`time_s` is {requested} s, but the recording has fields from {first} s to {last} s."
        )),
        error => {
            tracing::error!(%error, "the surfaces of a recording cannot be exported");
            Problem::recording_lost()
        }
    }
}
