//! Extractors of request data. Those of axum answer errors in plain text; these answer problem documents.

use super::app::App;
use super::problem::Problem;
use crate::service::jobs::JobId;
use crate::service::jobs::held_text::HeldText;
use crate::service::tokens::{Grant, Scope};
use axum::extract::{FromRequest, FromRequestParts, Path, Query, Request};
use axum::http::request::Parts;
use axum::http::{Extensions, HeaderMap, Method, header};
use serde::de::DeserializeOwned;
use std::convert::Infallible;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::{Arc, OnceLock};

/// Address of the counters.
const METRICS: &str = "/metrics";

/// Owner of a request: the name of its bearer token, empty if the service is open to everyone.
#[derive(Clone, Debug)]
pub struct Owner(pub String);

/// Owner of a request for the audit log, once known.
#[derive(Clone, Debug, Default)]
pub(super) struct Who(pub Arc<OnceLock<String>>);

/// Address of the client, or of the proxy before it.
#[derive(Clone, Copy, Debug)]
pub struct Peer(pub IpAddr);

impl FromRequestParts<Arc<App>> for Owner {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, Problem> {
        let tokens = app.access.tokens();
        let known = |name: &str| {
            if let Some(who) = parts.extensions.get::<Who>() {
                // Set once: a request has one owner.
                let _ = who.0.set(name.to_owned());
            }
            Ok(Self(name.to_owned()))
        };
        if tokens.is_open() {
            return known("");
        }
        let value = parts.headers.get(header::AUTHORIZATION).and_then(|v| v.to_str().ok());
        let token =
            value.and_then(|v| v.split_once(' ')).filter(|(scheme, _)| scheme.eq_ignore_ascii_case("bearer"));
        if let Some(grant) = token.and_then(|(_, token)| tokens.grant(token.trim())) {
            let owner = known(grant.owner);
            let needed = needed_scope(parts);
            // Whatever is refused below is in the audit log.
            if let Some(wait_s) = app.rates.take(grant.owner) {
                return Err(Problem::too_many_requests(wait_s));
            }
            return match grant {
                Grant { is_expired: true, .. } => Err(Problem::expired_token()),
                Grant { scope, .. } if scope < needed => Err(Problem::beyond_scope(scope, needed)),
                Grant { .. } => owner,
            };
        }
        // A request without a token tries none.
        let peer = parts.extensions.get::<Peer>().filter(|_| value.is_some());
        match peer.and_then(|Peer(address)| app.attempts.wrong(*address)) {
            Some(wait_s) => Err(Problem::too_many_wrong_tokens(wait_s)),
            None => Err(Problem::unauthorized()),
        }
    }
}

/// Scope that a request needs.
fn needed_scope(parts: &Parts) -> Scope {
    match parts.method {
        _ if parts.uri.path() == METRICS => Scope::Metrics,
        Method::GET | Method::HEAD => Scope::Read,
        _ => Scope::Submit,
    }
}

/// Whose limits of memory and of simultaneous requests hold: those of the owner of the token, of the address where there are no tokens.
#[derive(Clone, Debug)]
pub struct Sender(pub String);

impl FromRequestParts<Arc<App>> for Sender {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Infallible> {
        Ok(sender_of(&parts.extensions))
    }
}

/// The sender of a request whose owner is known.
pub(super) fn sender_of(extensions: &Extensions) -> Sender {
    let owner = extensions.get::<Who>().and_then(|who| who.0.get()).filter(|name| !name.is_empty());
    Sender(owner.cloned().unwrap_or_else(|| peer_of(extensions).0.to_string()))
}

impl FromRequestParts<Arc<App>> for Peer {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Infallible> {
        Ok(peer_of(&parts.extensions))
    }
}

/// Address of the client of a request.
fn peer_of(extensions: &Extensions) -> Peer {
    extensions.get().copied().unwrap_or(Peer(Ipv4Addr::UNSPECIFIED.into()))
}

/// Id of a job in the path. An invalid id is answered like a missing job.
#[derive(Clone, Copy, Debug)]
pub struct JobPath(pub JobId);

impl FromRequestParts<Arc<App>> for JobPath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, Problem> {
        let Path(text) =
            Path::<String>::from_request_parts(parts, app).await.map_err(|_| Problem::no_such_job())?;
        // Only the canonical form: one job has one address.
        match text.parse::<JobId>() {
            Ok(id) if id.to_string() == text => Ok(Self(id)),
            _ => Err(Problem::no_such_job()),
        }
    }
}

/// Query parameters of a request.
#[derive(Clone, Copy, Debug)]
pub struct Parameters<T>(pub T);

impl<T: DeserializeOwned> FromRequestParts<Arc<App>> for Parameters<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, Problem> {
        let Query(value) = Query::<T>::from_request_parts(parts, app)
            .await
            .map_err(|e| Problem::bad_parameter(e.body_text()))?;
        Ok(Self(value))
    }
}

/// The text of a JSON body, not yet parsed: that takes a slot, since it takes more memory than the text.
#[derive(Debug)]
pub struct JsonBody(pub HeldText);

impl FromRequest<Arc<App>> for JsonBody {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &Arc<App>) -> Result<Self, Problem> {
        if !is_json(request.headers()) {
            return Err(Problem::unsupported_media_type("application/json"));
        }
        let limit = app.config.runs.budget.document_bytes;
        if declared_length(request.headers()).is_some_and(|n| n > limit) {
            return Err(Problem::too_large(limit));
        }
        let Sender(sender) = sender_of(request.extensions());
        let _permit = app.permits.uploads.take(sender.clone())?;
        let reading = app.bodies.receive(&sender, request.into_body(), limit);
        match tokio::time::timeout(app.config.request_timeout, reading).await {
            Err(_) => Err(Problem::too_slow()),
            Ok(received) => received.map(Self),
        }
    }
}

/// Declared length of a body.
pub fn declared_length(headers: &HeaderMap) -> Option<u64> {
    headers.get(header::CONTENT_LENGTH)?.to_str().ok()?.parse().ok()
}

/// Whether a body is declared as JSON, with or without parameters.
fn is_json(headers: &HeaderMap) -> bool {
    media_type(headers).is_some_and(|m| m == "application/json" || m.ends_with("+json"))
}

/// The media type of a body in lower case, without parameters.
pub fn media_type(headers: &HeaderMap) -> Option<String> {
    let text = headers.get(header::CONTENT_TYPE)?.to_str().ok()?;
    Some(text.split(';').next().unwrap_or_default().trim().to_ascii_lowercase())
}
