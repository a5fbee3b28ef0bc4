//! The listener: accepts connections within limits, and lets them finish when the service shuts down.
//!
//! `axum::serve` sets no limits on slow headers, on their size, on clients that do not read or on the number of
//! connections; this does.

use super::config::ServiceConfig;
use super::connection::{Routes, Seated, http};
use super::linger::Lingering;
use super::probes::Probes;
use super::seats::Seats;
use super::stall::StallTimeout;
use axum::Router;
use hyper_util::rt::TokioIo;
use hyper_util::server::graceful::GracefulShutdown;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

/// Pause after a failure to accept a connection (too many open files).
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Answers requests until `closing` becomes true, then until every connection has been answered or `grace` is over.
pub async fn serve(
    listener: TcpListener,
    app: Router,
    config: Arc<ServiceConfig>,
    mut closing: watch::Receiver<bool>,
) {
    let seats = Seats::new(config.max_connections);
    let mut probes = Probes::new(app.clone());
    let graceful = GracefulShutdown::new();
    // One task per connection, within the limits.
    loop {
        let accepted = tokio::select! {
            accepted = accept(&listener) => accepted,
            _ = closing.wait_for(|closing| *closing) => break,
        };
        let Some((stream, peer)) = accepted else { continue };
        let seat = match seats.take(peer) {
            Ok(seat) => seat,
            Err(refused) => {
                probes.answer(stream, peer, refused);
                continue;
            }
        };
        let stream = Lingering::new(stream, Arc::clone(&seat));
        let stream = StallTimeout::new(stream, config.request_timeout, config.least_rate);
        let routes = Seated::new(Routes::new(app.clone(), peer), Arc::clone(&seat));
        let connection = http(config.request_timeout).serve_connection(TokioIo::new(stream), routes);
        let connection = graceful.watch(connection);
        tokio::spawn(async move {
            tokio::select! {
                ended = connection => if let Err(error) = ended {
                    tracing::debug!(%error, "a connection broke");
                },
                () = seat.given_up() => tracing::debug!("an idle connection made room for another"),
            }
        });
    }
    // No new connections from here on.
    drop(listener);
    if tokio::time::timeout(config.grace, graceful.shutdown()).await.is_err() {
        tracing::warn!("some connections did not end in time");
    }
}

/// The next connection.
async fn accept(listener: &TcpListener) -> Option<(TcpStream, IpAddr)> {
    match listener.accept().await {
        Ok((stream, peer)) => {
            // Events are small and must not be delayed.
            let _ = stream.set_nodelay(true);
            Some((stream, peer.ip().to_canonical()))
        }
        Err(error) => {
            tracing::warn!(%error, "cannot accept a connection");
            tokio::time::sleep(ACCEPT_PAUSE).await;
            None
        }
    }
}
