//! The HTTP interface: the list of all calls.

mod edge;
mod events;
mod exports;
mod extract;
mod jobs;
mod judges;
mod materials;
mod meshes;
mod openapi;
mod pages;
mod problem;
mod range;
mod recording;
mod studies;
mod viewer;
mod what_if;
mod wire;

pub use judges::Judges;
pub use openapi::text as openapi_text;

use super::config::ServiceConfig;
use super::jobs::queue::Queue;
use super::metrics::Metrics;
use axum::Router;
use axum::response::Redirect;
use axum::routing::get;
use std::sync::Arc;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

/// Shared state of the handlers.
pub struct App {
    /// Queue that stores, starts and stops jobs.
    pub queue: Arc<Queue>,
    /// Limits and access tokens of the service.
    pub config: Arc<ServiceConfig>,
    /// Counters served to Prometheus.
    pub metrics: Arc<Metrics>,
    /// Threads for the validation of scenes and meshes.
    pub judges: Judges,
}

/// Calls that are part of the API contract.
fn routes() -> OpenApiRouter<Arc<App>> {
    OpenApiRouter::with_openapi(openapi::Contract::openapi())
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
        .routes(routes!(studies::submit))
        .routes(routes!(what_if::ask))
        .routes(routes!(meshes::upload))
        .routes(routes!(meshes::get))
        .routes(routes!(materials::list))
        .routes(routes!(materials::get))
        .routes(routes!(pages::healthz))
        .routes(routes!(pages::readyz))
        .routes(routes!(pages::metrics))
        .routes(routes!(pages::scene_schema))
}

/// All routes of the service.
pub fn router(app: Arc<App>) -> Router {
    let (calls, _) = routes().split_for_parts();
    let all = calls
        .route("/", get(viewer::page))
        // Players of recordings identify a file by its extension, and reject an address without one.
        .route("/v1/jobs/{id}/recording.mcap", get(recording::download))
        .route("/viewer/presets.json", get(viewer::presets))
        .route("/viewer/{*path}", get(viewer::file))
        .route("/openapi.json", get(pages::openapi_json))
        .route("/docs", get(async || Redirect::to("docs/")))
        .route("/docs/", get(viewer::docs))
        .fallback(async || problem::Problem::no_such_address())
        .method_not_allowed_fallback(async || problem::Problem::method_not_allowed());
    edge::layered(all, &app).with_state(app)
}
