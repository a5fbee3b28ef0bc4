//! The calls of the API.

use super::app::App;
use super::contract::Contract;
use super::{
    events, exports, fields, jobs, materials, meshes, pages, recording, sections, studies, surfaces, what_if,
};
use std::sync::Arc;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

/// Calls that are part of the API contract.
pub(super) fn calls() -> OpenApiRouter<Arc<App>> {
    OpenApiRouter::with_openapi(Contract::openapi())
        .routes(routes!(jobs::submit, jobs::list))
        .routes(routes!(jobs::validate))
        .routes(routes!(jobs::get, jobs::delete))
        .routes(routes!(jobs::cancel))
        .routes(routes!(events::follow))
        .routes(routes!(jobs::summary))
        .routes(routes!(jobs::plan))
        .routes(routes!(recording::download))
        .routes(routes!(exports::report))
        .routes(routes!(exports::bundle))
        .routes(routes!(exports::table))
        .routes(routes!(fields::archive))
        .routes(routes!(surfaces::stl))
        .routes(routes!(surfaces::ply))
        .routes(routes!(studies::submit))
        .routes(routes!(what_if::ask))
        .routes(routes!(meshes::upload, meshes::list))
        .routes(routes!(meshes::get, meshes::delete))
        .routes(routes!(meshes::first_scene))
        .routes(routes!(sections::section))
        .routes(routes!(materials::list))
        .routes(routes!(materials::get))
        .routes(routes!(pages::healthz))
        .routes(routes!(pages::readyz))
        .routes(routes!(pages::metrics))
        .routes(routes!(pages::scene_schema))
}
