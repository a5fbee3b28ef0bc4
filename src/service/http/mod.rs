//! The service over HTTP: every call on this screen.

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

/// What handlers work with.
pub struct App {
    /// The jobs.
    pub queue: Arc<Queue>,
    /// Limits and tokens.
    pub config: Arc<ServiceConfig>,
    /// Counters.
    pub metrics: Arc<Metrics>,
    /// Who judges scenes and meshes.
    pub judges: Judges,
}

/// The calls that the contract names.
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

/// Everything that the service answers.
pub fn router(app: Arc<App>) -> Router {
    let (calls, _) = routes().split_for_parts();
    let all = calls
        .route("/", get(viewer::page))
        // Players of recordings know a file by the end of its name, and refuse an address without one.
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
