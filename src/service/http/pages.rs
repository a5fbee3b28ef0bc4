//! Pages about the service itself: liveness, readiness, metrics, API documents.

use super::app::App;
use super::extract::Owner;
use super::problem::{Problem, ProblemBody};
use crate::scene::scene_schema as schema_of_scenes;
use crate::service::jobs::queue::Queue;
use crate::service::metrics::{MEDIA_TYPE, Reading};
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use std::sync::{Arc, LazyLock};

static SCENE_SCHEMA: LazyLock<String> = LazyLock::new(|| format!("{:#}\n", schema_of_scenes()));

/// Check that the process is alive.
#[utoipa::path(get, path = "/healthz", tag = "service", operation_id = "healthz",
    responses((status = 200, description = "The process is alive", body = String, content_type = "text/plain")))]
pub async fn healthz() -> &'static str {
    "ok\n"
}

/// Check that the service accepts work.
#[utoipa::path(get, path = "/readyz", tag = "service", operation_id = "readyz",
    responses(
        (status = 200, description = "The service accepts work", body = String, content_type = "text/plain"),
        (status = 503, description = "The service is shutting down, its disk or its audit log accepts no writes, or its object store does not answer", body = ProblemBody, content_type = "application/problem+json")))]
pub async fn readyz(State(app): State<Arc<App>>) -> Result<&'static str, Problem> {
    if app.queue.is_closing() {
        return Err(Problem::unavailable("The service is shutting down."));
    }
    let check = async {
        let written = match app.queue.with_files(Queue::check_storage).await {
            Ok(()) => app.queue.store.try_write().await,
            Err(error) => Err(error),
        };
        let is_written =
            written.inspect_err(|error| tracing::error!(%error, "nothing can be written")).is_ok();
        let audit = Arc::clone(&app.audit);
        is_written && app.queue.with_files(move |_| Ok(audit.accepts_lines())).await.unwrap_or(false)
    };
    if app.readiness.is_ready(check).await {
        Ok("ok\n")
    } else {
        Err(Problem::unavailable("The storage of the service, or its audit log, accepts no writes."))
    }
}

/// Get counters for Prometheus.
#[utoipa::path(get, path = "/metrics", tag = "service", operation_id = "metrics",
    responses((status = 200, description = "Queue, jobs, runs, processes, memory, disk, stores and requests, as OpenMetrics 1.0", body = String, content_type = "application/openmetrics-text")))]
pub async fn metrics(State(app): State<Arc<App>>, _: Owner) -> Result<Response, Problem> {
    let reading = Reading { audit_faults: app.audit.failures(), ..app.queue.reading().await? };
    let text = app.metrics.render(&reading);
    Ok(([(header::CONTENT_TYPE, MEDIA_TYPE)], text).into_response())
}

/// Get the JSON Schema of a scene document.
#[utoipa::path(get, path = "/scene.schema.json", tag = "service", operation_id = "scene_schema",
    responses((status = 200, description = "JSON Schema, draft 2020-12", body = serde_json::Value, content_type = "application/schema+json")))]
pub async fn scene_schema() -> Response {
    ([(header::CONTENT_TYPE, "application/schema+json")], SCENE_SCHEMA.as_str()).into_response()
}
