//! What the connections of the service have in common: limits of HTTP, and the routes.

use super::held_body::holding;
use super::http::Peer;
use super::seats::{Answering, Seat};
use axum::Router;
use axum::response::Response;
use futures::future::BoxFuture;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::Service;
use hyper_util::rt::TokioTimer;
use hyper_util::service::TowerToHyperService;
use std::convert::Infallible;
use std::future::pending;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

/// Maximum number of header fields in a request.
const MAX_HEADERS: usize = 64;
/// Maximum size of the head of a request in bytes.
const MAX_HEAD_BYTES: usize = 32 << 10;

/// HTTP/1.1 with limits, and some time for each head.
pub(super) fn http(head_time: Duration) -> http1::Builder {
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(head_time);
    http.max_headers(MAX_HEADERS).max_buf_size(MAX_HEAD_BYTES);
    http
}

/// All routes, for the requests of one connection.
pub(super) struct Routes {
    routes: TowerToHyperService<Router>,
    peer: IpAddr,
}

impl Routes {
    /// The routes for a connection from an address.
    pub fn new(app: Router, peer: IpAddr) -> Self {
        Self { routes: TowerToHyperService::new(app), peer }
    }
}

impl Service<Request<Incoming>> for Routes {
    type Response = Response;
    type Error = Infallible;
    type Future = <TowerToHyperService<Router> as Service<Request<Incoming>>>::Future;

    fn call(&self, mut request: Request<Incoming>) -> Self::Future {
        request.extensions_mut().insert(Peer(self.peer));
        self.routes.call(request)
    }
}

/// The routes, for the requests of a connection on a seat.
pub(super) struct Seated {
    routes: Routes,
    seat: Arc<Seat>,
}

impl Seated {
    /// The routes for the connection on a seat.
    pub fn new(routes: Routes, seat: Arc<Seat>) -> Self {
        Self { routes, seat }
    }
}

impl Service<Request<Incoming>> for Seated {
    type Response = Response;
    type Error = Infallible;
    type Future = BoxFuture<'static, Result<Response, Infallible>>;

    fn call(&self, request: Request<Incoming>) -> Self::Future {
        // A connection whose seat is given up is closed at once: what it asks for is not begun.
        let Some(answering) = Answering::on(&self.seat) else { return Box::pin(pending()) };
        let answer = self.routes.call(request);
        Box::pin(async move { Ok(answer.await?.map(|body| holding(body, answering))) })
    }
}
