//! `/v1/meshes/{id}/section`: the outlines of the parts of an uploaded mesh in a plane.

use super::app::App;
use super::extract::{Owner, Parameters};
use super::meshes::{get, reading};
use super::problem::{Problem, ProblemBody};
use crate::mesh::section::{Plane, Section};
use crate::scene::document::Axis;
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// The plane of a section.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct SectionParameters {
    /// The axis that it is perpendicular to: `x`, `y` or `z`.
    #[param(value_type = String)]
    normal: Axis,
    /// Its coordinate on that axis, in the unit of the file; of a scan in metres. By default in the middle.
    at: Option<f64>,
}

/// Cut an uploaded mesh, scan or closed surface by a plane.
///
/// The outlines of its parts or labels, to draw them; of large scans, those of groups of voxels.
#[utoipa::path(
    get, path = "/v1/meshes/{id}/section", tag = "meshes", operation_id = "get_mesh_section",
    params(("id" = String, Path, description = "SHA-256 of the file"), SectionParameters),
    responses(
        (status = 200, description = "The outlines of the parts in the plane", body = Section),
        (status = 400, description = "A parameter of the query is not valid", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "No mesh of this owner has this id", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "It cannot be cut, or outlines have too many points", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "Too many validations of this token are waiting", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Too many validations are waiting", body = ProblemBody, content_type = "application/problem+json"),
    )
)]
pub async fn section(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    path: Result<Path<String>, PathRejection>,
    Parameters(SectionParameters { normal, at }): Parameters<SectionParameters>,
) -> Result<Json<Section>, Problem> {
    if at.is_some_and(|at| !at.is_finite()) {
        return Err(Problem::bad_parameter("`at` must be a finite number."));
    }
    let Json(mesh) = get(State(Arc::clone(&app)), Owner(owner.clone()), path).await?;
    let plane = Plane { axis: normal as usize, at };
    reading(&app, &owner, vec![mesh], move |engine, file| engine.section(file, plane)).await
}
