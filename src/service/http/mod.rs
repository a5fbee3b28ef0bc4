//! The HTTP interface: the list of all calls.

mod answers;
mod app;
mod attempts;
mod bodies;
mod calls;
mod contract;
mod edge;
mod events;
mod exports;
mod extract;
mod fields;
mod jobs;
mod materials;
mod meshes;
mod openapi;
mod origin;
mod pages;
mod preloads;
mod problem;
mod range;
mod rates;
mod recording;
mod sections;
mod slots;
mod studies;
mod submission;
mod surfaces;
mod validation;
mod viewer;
mod what_if;
mod wire;

pub use app::App;
pub use attempts::Attempts;
pub use bodies::Bodies;
pub use extract::{Peer, Sender};
pub use openapi::text as openapi_text;
pub use problem::no_connection;
pub use rates::Rates;
pub use slots::{Slots, ValidationSlots};

use axum::Router;
use axum::response::Redirect;
use axum::routing::get;
use calls::calls;
use std::sync::Arc;

/// All routes of the service.
pub fn router(app: Arc<App>) -> Router {
    let (calls, _) = calls().split_for_parts();
    let all = calls
        .route("/", get(viewer::page))
        // Players of recordings identify a file by its extension, and reject an address without one.
        .route("/v1/jobs/{id}/recording.mcap", get(recording::download))
        .route("/viewer/presets.json", get(viewer::presets))
        .route("/viewer/{*path}", get(viewer::file))
        .route("/openapi.json", get(openapi::page))
        .route("/docs", get(async || Redirect::to("docs/")))
        .route("/docs/", get(viewer::docs))
        .fallback(async || problem::Problem::no_such_address())
        .method_not_allowed_fallback(async || problem::Problem::method_not_allowed());
    edge::layered(all, &app).with_state(app)
}
