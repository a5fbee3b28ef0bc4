//! Middleware around every request: access control, metrics, common headers, and panics as error responses.

use super::answers::counted;
use super::app::App;
use super::extract::{Peer, Who};
use super::origin::{is_own_host, is_own_page};
use super::problem::Problem;
use super::recording::REPR_DIGEST;
use crate::service::audit::Entry;
use crate::service::clock::new_id;
use crate::service::jobs::store::NOTICE;
use crate::service::traces::{TRACEPARENT, continue_from};
use axum::Router;
use axum::extract::{DefaultBodyLimit, MatchedPath, Request, State};
use axum::http::{Extensions, HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Version, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use std::any::Any;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Instant;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{Predicate as _, SizeAbove};
use tower_http::cors::CorsLayer;
use tracing::Instrument as _;

/// Header with the disclaimer in every answer.
const CONTUSE_NOTICE: HeaderName = HeaderName::from_static("contuse-notice");

/// Id of a request.
const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
/// Longest id of a request that a client may give.
const LONGEST_ID: usize = 64;

/// Smallest response that is compressed [bytes]: smaller ones take one packet as they are.
const WORTH_COMPRESSING: u64 = 1024;

/// Longest path in the audit log [bytes]: ids are shorter.
const LONGEST_PATH: usize = 200;
/// Beginning of the addresses of what a job found.
const RESULTS: &str = "/v1/jobs/{id}/";
const CROSS_ORIGIN_RESOURCE_POLICY: HeaderName = HeaderName::from_static("cross-origin-resource-policy");
/// Policy of whatever is not a page with a policy of its own: a browser that shows it loads and runs nothing.
const NO_CONTENT: &str = "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Adds all layers to the router; the last one is the first to see a request.
pub fn layered(router: Router<Arc<App>>, app: &Arc<App>) -> Router<Arc<App>> {
    router
        // Handlers that read a body have their own limits; all others get none.
        .layer(DefaultBodyLimit::max(64 << 10))
        .layer(from_fn_with_state(Arc::clone(app), counted))
        .layer(CompressionLayer::new().compress_when(SizeAbove::new(WORTH_COMPRESSING).and(is_text)))
        .layer(CatchPanicLayer::custom(panicked))
        .layer(from_fn_with_state(Arc::clone(app), own_pages))
        .layer(cors(&app.config.cors_origins))
        .layer(from_fn_with_state(Arc::clone(app), observed))
}

/// Whether a response is a text, for clients that accept gzip. Recordings and archives are compressed already and read by ranges,
/// and events have to arrive one by one.
fn is_text(_: StatusCode, _: Version, headers: &HeaderMap, _: &Extensions) -> bool {
    let media_type =
        headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let essence = media_type.split_once(';').map_or(media_type, |(essence, _)| essence).trim_end();
    !headers.contains_key(header::ACCEPT_RANGES)
        && essence != "text/event-stream"
        && (essence.starts_with("text/") || essence.ends_with("json") || essence == "image/svg+xml")
}

/// Response to a request whose handler panicked.
#[allow(clippy::needless_pass_by_value)] // the signature is that of the layer
fn panicked(payload: Box<dyn Any + Send>) -> Response {
    let words = payload.downcast_ref::<&str>().copied().map(str::to_owned);
    let words = words.or_else(|| payload.downcast_ref::<String>().cloned());
    Problem::internal(&words.as_deref().unwrap_or("a handler panicked without words")).into_response()
}

/// Origins of other web pages that may read and change: those listed. A viewer of recordings elsewhere is one.
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
        HeaderName::from_static("job-priority"),
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
    let listed: Vec<HeaderValue> = origins.iter().filter_map(|o| HeaderValue::try_from(o).ok()).collect();
    if listed.is_empty() {
        return CorsLayer::new();
    }
    CorsLayer::new()
        .allow_headers(allowed_headers)
        .expose_headers(exposed_headers)
        .allow_origin(listed)
        .allow_methods([Method::GET, Method::HEAD, Method::POST, Method::DELETE])
}

/// Rejects requests under foreign names, and those of pages of other origins. Browsers send some of them without a preflight
/// request.
async fn own_pages(State(app): State<Arc<App>>, request: Request, next: Next) -> Result<Response, Problem> {
    let config = &app.config;
    if app.access.tokens().is_open() && !is_own_host(request.uri(), request.headers(), &config.hosts) {
        return Err(Problem::foreign_host());
    }
    if !is_own_page(request.uri(), request.headers(), &config.cors_origins) {
        return Err(Problem::cross_origin());
    }
    Ok(next.run(request).await)
}

/// Id of a request in the log and in its answer: that of the client or the proxy before it, otherwise a new one.
fn request_id(headers: &HeaderMap) -> HeaderValue {
    let given = headers.get(REQUEST_ID).filter(|id| {
        let bytes = id.as_bytes();
        (1..=LONGEST_ID).contains(&bytes.len())
            && bytes.iter().all(|b| b.is_ascii_alphanumeric() || b"-_.".contains(b))
    });
    let new = || HeaderValue::try_from(new_id().simple().to_string());
    given.cloned().or_else(|| new().ok()).unwrap_or(HeaderValue::from_static("none"))
}

/// Writes a request to the audit log if it changed or read data of a patient, or tried to. The path has the ids of jobs and meshes. Lists,
/// states and progress are read again and again, and say nothing of a patient. Requests of strangers, and those that are too many of an
/// owner, are only counted.
fn audit(app: &App, entry: &Entry<'_>, route: &str) {
    let Entry { owner, address, method, status, .. } = *entry;
    if !route.starts_with("/v1/") || route.starts_with("/v1/materials") {
        return;
    }
    let is_act = !["GET", "HEAD"].contains(&method) || route.starts_with(RESULTS);
    if owner.is_none() || status == 429 {
        if status >= 400 {
            app.audit.refused(owner, address, status);
        }
    } else if is_act || matches!(status, 401 | 403) {
        app.audit.record(entry);
    }
}

/// Name of a method in series and spans. Methods are chosen by the client: unknown ones do not create series of their own.
fn method_label(method: &Method) -> &str {
    let known = [Method::GET, Method::HEAD, Method::POST, Method::DELETE, Method::OPTIONS];
    if known.contains(method) { method.as_str() } else { "other" }
}

/// Status in counts and in the audit log of a request whose client closed the connection before its answer; what it asked for may have been
/// done. No answer has it.
const HUNG_UP: u16 = 499;

/// A request until it is counted and, where it belongs there, in the audit log: with its answer, or when its client has hung up.
struct Unanswered {
    app: Arc<App>,
    who: Who,
    address: Option<IpAddr>,
    method: Method,
    path: String,
    route: String,
    started: Instant,
    is_counted: bool,
}

impl Unanswered {
    /// Counts the request and writes it to the audit log.
    fn end(&mut self, status: u16, created: Option<&str>) {
        self.is_counted = true;
        let label = method_label(&self.method);
        self.app.metrics.answered(label, &self.route, status, self.started.elapsed());
        let entry = Entry {
            owner: self.who.0.get().map(String::as_str),
            address: self.address,
            method: label,
            path: self.path.get(..LONGEST_PATH).unwrap_or(&self.path),
            created,
            status,
        };
        audit(&self.app, &entry, &self.route);
    }
}

impl Drop for Unanswered {
    fn drop(&mut self) {
        if !self.is_counted {
            self.end(HUNG_UP, None);
        }
    }
}

/// Counts and logs a request, and adds the disclaimer to every answer.
async fn observed(State(app): State<Arc<App>>, mut request: Request, next: Next) -> Response {
    let (method, started) = (request.method().clone(), Instant::now());
    let who = Who::default();
    request.extensions_mut().insert(who.clone());
    let route = request.extensions().get::<MatchedPath>().map_or("other", MatchedPath::as_str).to_owned();
    let id = request_id(request.headers());
    let span = tracing::info_span!(
        "request",
        id = id.to_str().unwrap_or_default(),
        otel.name = format_args!("{} {route}", method_label(&method)),
        otel.kind = "server",
        http.response.status_code = tracing::field::Empty,
    );
    let trace = request.headers().get(TRACEPARENT).and_then(|value| value.to_str().ok());
    continue_from(&span, trace);
    let address = request.extensions().get::<Peer>().map(|Peer(address)| *address);
    let path = request.uri().path().to_owned();
    let mut unanswered = Unanswered { app, who, address, method, path, route, started, is_counted: false };
    let mut response = next.run(request).instrument(span.clone()).await;
    let status = response.status().as_u16();
    span.record("http.response.status_code", status);
    unanswered.end(status, response.headers().get(header::LOCATION).and_then(|value| value.to_str().ok()));
    let Unanswered { app, method, route, .. } = &unanswered;
    let ms = started.elapsed().as_secs_f64() * 1e3;
    span.in_scope(|| tracing::debug!(%method, route, status, ms, "answered"));
    let headers = response.headers_mut();
    headers.insert(REQUEST_ID, id);
    headers.insert(CONTUSE_NOTICE, HeaderValue::from_static(NOTICE));
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(header::REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    headers.entry(header::CONTENT_SECURITY_POLICY).or_insert(HeaderValue::from_static(NO_CONTENT));
    if app.config.cors_origins.is_empty() {
        headers.insert(CROSS_ORIGIN_RESOURCE_POLICY, HeaderValue::from_static("same-origin"));
    }
    response
}
