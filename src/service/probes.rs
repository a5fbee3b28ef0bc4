//! Probes of an orchestrator that find all connections taken: their questions are short, and answered nevertheless.
//!
//! A probe often comes from the address that has too many connections, that of a proxy or of this machine.

use super::connection::{Routes, http};
use super::http::no_connection;
use super::permits::NoPermit;
use axum::Router;
use futures::future::Either;
use hyper::Request;
use hyper::body::Incoming;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::TokioIo;
use std::collections::VecDeque;
use std::future::ready;
use std::net::IpAddr;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::task::AbortHandle;
use tokio::time::timeout;

/// What is answered.
const PROBES: [&str; 2] = ["/healthz", "/readyz"];
/// Number of connections beyond the limits: the oldest one makes room for the next, so that none of them locks out a probe.
const MOST: usize = 64;
/// Time allowed to a client for the head of its request.
const HEAD_TIME: Duration = Duration::from_secs(1);
/// Time allowed for everything.
const LONGEST: Duration = Duration::from_secs(5);

/// Connections beyond the limits.
pub(super) struct Probes {
    app: Router,
    open: VecDeque<AbortHandle>,
}

impl Probes {
    /// None yet.
    pub fn new(app: Router) -> Self {
        Self { app, open: VecDeque::with_capacity(MOST) }
    }

    /// Answers a connection that has no permit, if it asks what a probe asks; any other is refused with the reason.
    pub fn answer(&mut self, stream: TcpStream, peer: IpAddr, refused: NoPermit) {
        if self.open.len() >= MOST
            && let Some(oldest) = self.open.pop_front()
        {
            oldest.abort();
        }
        let routes = Routes::new(self.app.clone(), peer);
        let service = service_fn(move |request: Request<Incoming>| {
            if PROBES.contains(&request.uri().path()) {
                Either::Left(routes.call(request))
            } else {
                Either::Right(ready(Ok(no_connection(refused))))
            }
        });
        let connection = http(HEAD_TIME).keep_alive(false).serve_connection(TokioIo::new(stream), service);
        self.open
            .push_back(tokio::spawn(async move { drop(timeout(LONGEST, connection).await) }).abort_handle());
    }
}
