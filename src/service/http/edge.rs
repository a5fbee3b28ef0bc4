//! Middleware around every request: access control, metrics, common headers, and panics as error responses.

use super::app::App;
use super::problem::Problem;
use super::recording::REPR_DIGEST;
use super::wire::NOTICE;
use axum::Router;
use axum::extract::{DefaultBodyLimit, MatchedPath, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use std::any::Any;
use std::sync::Arc;
use std::time::Instant;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::cors::{Any as AnyOrigin, CorsLayer};

/// Header with the disclaimer in every answer.
const CONTUSE_NOTICE: HeaderName = HeaderName::from_static("contuse-notice");

/// Adds all layers to the router; the last one is the first to see a request.
pub fn layered(router: Router<Arc<App>>, app: &Arc<App>) -> Router<Arc<App>> {
    router
        // Handlers that read a body have their own limits; all others get none.
        .layer(DefaultBodyLimit::max(64 << 10))
        .layer(CatchPanicLayer::custom(panicked))
        .layer(from_fn_with_state(Arc::clone(app), same_origin))
        .layer(cors(&app.config.cors_origins))
        .layer(from_fn_with_state(Arc::clone(app), observed))
}

/// Response to a request whose handler panicked.
#[allow(clippy::needless_pass_by_value)] // the signature is that of the layer
fn panicked(payload: Box<dyn Any + Send>) -> Response {
    let words = payload.downcast_ref::<&str>().copied().map(str::to_owned);
    let words = words.or_else(|| payload.downcast_ref::<String>().cloned());
    Problem::internal(&words.as_deref().unwrap_or("a handler panicked without words")).into_response()
}

/// Origins of web pages that may read and change. By default pages of any origin may read (a viewer of recordings is
/// one) and none may change: an unrelated page must not start or stop jobs.
fn cors(origins: &[String]) -> CorsLayer {
    let allowed_headers = [
        header::AUTHORIZATION,
        header::CONTENT_TYPE,
        header::RANGE,
        header::IF_RANGE,
        header::IF_MATCH,
        header::IF_NONE_MATCH,
        HeaderName::from_static("last-event-id"),
        HeaderName::from_static("idempotency-key"),
    ];
    let exposed_headers = [
        header::ACCEPT_RANGES,
        header::CONTENT_DISPOSITION,
        header::CONTENT_LENGTH,
        header::CONTENT_LOCATION,
        header::CONTENT_RANGE,
        header::ETAG,
        header::LOCATION,
        header::RETRY_AFTER,
        REPR_DIGEST,
        CONTUSE_NOTICE,
        HeaderName::from_static("idempotent-replayed"),
    ];
    let layer = CorsLayer::new().allow_headers(allowed_headers).expose_headers(exposed_headers);
    // Without listed origins, pages of any origin may only read.
    let listed: Vec<HeaderValue> = origins.iter().filter_map(|o| HeaderValue::try_from(o).ok()).collect();
    if listed.is_empty() {
        layer.allow_origin(AnyOrigin).allow_methods([Method::GET, Method::HEAD])
    } else {
        layer.allow_origin(listed).allow_methods([Method::GET, Method::HEAD, Method::POST, Method::DELETE])
    }
}

/// Rejects changes requested by a page of another origin. Browsers send some of them without a preflight request.
async fn same_origin(State(app): State<Arc<App>>, request: Request, next: Next) -> Result<Response, Problem> {
    let is_safe = matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS);
    if !is_safe && !may_change(request.headers(), &app.config.cors_origins) {
        return Err(Problem::cross_origin());
    }
    Ok(next.run(request).await)
}

/// Whether a request comes from no page, from a page of this service, or from one of an allowed origin.
fn may_change(headers: &HeaderMap, origins: &[String]) -> bool {
    let Some(origin) = headers.get(header::ORIGIN) else { return true };
    let Ok(origin) = origin.to_str() else { return false };
    let host = headers.get(header::HOST).and_then(|h| h.to_str().ok());
    let is_same = origin.split_once("://").is_some_and(|(_, authority)| Some(authority) == host);
    is_same || origins.iter().any(|o| o == origin)
}

/// Counts and logs a request, and adds the disclaimer to every answer.
async fn observed(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let started = Instant::now();
    let method = request.method().clone();
    let route = request.extensions().get::<MatchedPath>().map_or("other", MatchedPath::as_str).to_owned();
    let mut response = next.run(request).await;
    let (status, duration) = (response.status().as_u16(), started.elapsed());
    // Methods are chosen by the client: unknown ones do not create separate series.
    let known = [Method::GET, Method::HEAD, Method::POST, Method::DELETE, Method::OPTIONS];
    let label = if known.contains(&method) { method.as_str() } else { "other" };
    app.metrics.answered(label, &route, status, duration);
    tracing::debug!(%method, route, status, ms = duration.as_secs_f64() * 1e3, "answered");
    let headers = response.headers_mut();
    headers.insert(CONTUSE_NOTICE, HeaderValue::from_static(NOTICE));
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, "127.0.0.1:8080".parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, origin.parse().unwrap());
        }
        headers
    }

    #[test]
    fn pages_of_other_origins_change_nothing() {
        let listed = ["https://viewer.example".to_owned()];
        assert!(may_change(&headers(None), &[]));
        assert!(may_change(&headers(Some("http://127.0.0.1:8080")), &[]));
        assert!(!may_change(&headers(Some("https://evil.example")), &listed));
        assert!(!may_change(&headers(Some("null")), &[]));
        assert!(may_change(&headers(Some("https://viewer.example")), &listed));
    }
}
