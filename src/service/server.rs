//! The listener: accepts connections within limits, and lets them finish when the service shuts down.
//!
//! `axum::serve` sets no limits on slow headers, on their size, on clients that do not read or on the number of
//! connections; this does.

use super::config::ServiceConfig;
use super::http::Peer;
use super::linger::Lingering;
use super::permits::Permits;
use super::stall::StallTimeout;
use axum::Router;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::AsyncWriteExt as _;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, watch};

/// Maximum number of header fields in a request.
const MAX_HEADERS: usize = 64;
/// Maximum size of the head of a request in bytes.
const MAX_HEAD_BYTES: usize = 32 << 10;
/// Time allowed for refusing a connection.
const REFUSAL_TIME: Duration = Duration::from_secs(1);
/// Pause after a failure to accept a connection (too many open files).
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Answers requests until `closing` becomes true, then until every connection has been answered or `grace` is over.
pub async fn serve(
    listener: TcpListener,
    app: Router,
    config: Arc<ServiceConfig>,
    mut closing: watch::Receiver<bool>,
) {
    let connections = Arc::new(Semaphore::new(config.max_connections));
    let of_addresses = Permits::new(config.max_connections);
    let graceful = GracefulShutdown::new();
    // One task per connection, within the limits.
    loop {
        let stream = tokio::select! {
            accepted = accept(&listener, &connections) => accepted,
            _ = closing.wait_for(|closing| *closing) => break,
        };
        let Some((stream, peer, permit)) = stream else { continue };
        let Ok(of_address) = of_addresses.take(peer) else {
            tokio::spawn(async move {
                refuse(stream).await;
                drop(permit);
            });
            continue;
        };
        let routes = TowerToHyperService::new(app.clone());
        let service = service_fn(move |mut request: Request<Incoming>| {
            request.extensions_mut().insert(Peer(peer));
            routes.call(request)
        });
        let stream = Lingering::new(stream, (permit, of_address));
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(config.request_timeout)
            .max_headers(MAX_HEADERS)
            .max_buf_size(MAX_HEAD_BYTES)
            .serve_connection(
                TokioIo::new(StallTimeout::new(stream, config.request_timeout, config.least_rate)),
                service,
            );
        let connection = graceful.watch(connection);
        tokio::spawn(async move {
            if let Err(error) = connection.await {
                tracing::debug!(%error, "a connection broke");
            }
        });
    }
    // No new connections from here on.
    drop(listener);
    if tokio::time::timeout(config.grace, graceful.shutdown()).await.is_err() {
        tracing::warn!("some connections did not end in time");
    }
}

/// Closes a connection of an address that has as many as it may, and says so.
async fn refuse(mut stream: TcpStream) {
    const ANSWER: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nRetry-After: 10\r\nConnection: close\r\n\
        Content-Type: text/plain; charset=utf-8\r\nContent-Length: 41\r\n\r\nToo many connections from your address.\r\n";
    // A client that does not see it sees the end.
    let answered = async {
        stream.write_all(ANSWER).await?;
        stream.shutdown().await
    };
    let _ = tokio::time::timeout(REFUSAL_TIME, answered).await;
}

/// The next connection, within the limit on their number.
async fn accept(
    listener: &TcpListener,
    connections: &Arc<Semaphore>,
) -> Option<(TcpStream, IpAddr, tokio::sync::OwnedSemaphorePermit)> {
    let permit = Arc::clone(connections).acquire_owned().await.ok()?;
    match listener.accept().await {
        Ok((stream, peer)) => {
            // Events are small and must not be delayed.
            let _ = stream.set_nodelay(true);
            Some((stream, peer.ip().to_canonical(), permit))
        }
        Err(error) => {
            tracing::warn!(%error, "cannot accept a connection");
            tokio::time::sleep(ACCEPT_PAUSE).await;
            None
        }
    }
}
