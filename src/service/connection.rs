//! What the connections of the service have in common: limits of HTTP, and the routes.

use super::http::Peer;
use axum::Router;
use axum::response::Response;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::Service;
use hyper_util::rt::TokioTimer;
use hyper_util::service::TowerToHyperService;
use std::convert::Infallible;
use std::net::IpAddr;
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
