//! The service: durable jobs over HTTP.
//!
//! [`Service::start`] opens the data folder (recovering jobs of the previous process), starts the workers and listens;
//! [`Service::run_until`] answers until it is stopped. Shutdown proceeds in this order: no new connections and jobs,
//! event streams end, running jobs get a grace period and then return to the queue, open responses finish, the store
//! closes.
//!
//! - [`jobs`]: operations on jobs, without HTTP.
//! - [`http`]: the calls; `http/problem.rs` is the only file that assigns error statuses.
//! - [`shelves`]: names of recordings, meshes, snapshots and results in the [store of blobs](crate::blobs).
//! - [`work`]: processes that run jobs without answering requests.
//! - [`config`], [`metrics`], [`traces`], [`server`]: limits, counters, spans, the listener.
//! - [`fair_queue`]: who validates next; [`readiness`]: whether work is accepted.
//! - [`tokens`], [`access`]: who has access; [`clock`]: identifiers.

pub mod access;
pub mod audit;
mod audit_file;
pub mod clock;
pub mod config;
mod connection;
pub mod doctor;
pub mod fair_queue;
mod held_body;
pub mod http;
pub mod jobs;
mod linger;
pub mod meshes;
pub mod metrics;
mod opening;
pub mod permits;
mod probes;
pub mod readiness;
mod refusals;
mod seats;
pub mod server;
pub mod shelves;
mod stall;
pub mod tokens;
pub mod traces;
pub mod work;

use access::Access;
use audit::Audit;
use config::ServiceConfig;
use fair_queue::QueueLimits;
use http::{App, Attempts, Bodies, Rates, Slots, ValidationSlots};
use jobs::JobsError;
use jobs::deletion::Purged;
use jobs::engine::Engine;
use jobs::queue::Queue;
use jobs::worker;
use metrics::Metrics;
pub use opening::ServiceError;
use opening::open_queue;
use permits::AllPermits;
use readiness::Readiness;
use std::future::Future;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::net::TcpListener;

/// Simultaneous validations of scenes and meshes per worker; each may hold a mesh in memory.
const VALIDATIONS_PER_WORKER: usize = 2;
/// Time between two looks for what is too old.
const PURGE_INTERVAL: Duration = Duration::from_secs(3600);
/// Archives of fields that are sent at once; more wait.
const ARCHIVES_AT_ONCE: usize = 4;

/// Deletes what is older than some days, now and then, until the service shuts down.
async fn keep_for_days(queue: Arc<Queue>, days: u32) {
    let mut closing = queue.closing();
    loop {
        tokio::select! {
            () = queue.blobs_answer() => {}
            _ = closing.wait_for(|closing| *closing) => return,
        }
        match queue.purge(days).await {
            Ok(Purged { jobs, meshes, unreadable }) => {
                if jobs + meshes > 0 {
                    tracing::info!(jobs, meshes, days, "purged what is too old");
                }
                if unreadable > 0 {
                    tracing::error!(
                        unreadable,
                        "what is too old stays, as it cannot be read: `contuse doctor` lists it"
                    );
                }
            }
            // Goes on when it does.
            Err(JobsError::BlobStoreSilent) => continue,
            Err(error) => tracing::error!(%error, "could not purge what is too old"),
        }
        tokio::select! {
            () = tokio::time::sleep(PURGE_INTERVAL) => {}
            _ = closing.wait_for(|closing| *closing) => return,
        }
    }
}

/// Deletes the jobs that ended, and the meshes that were uploaded, more than some days ago, from a data folder that no service uses.
///
/// # Errors
/// If the folder is in use or cannot be used.
pub async fn purge(
    config: ServiceConfig,
    engine: Arc<dyn Engine>,
    older_than_days: u32,
) -> Result<Purged, ServiceError> {
    let queue = open_queue(&Arc::new(config), engine, &Arc::default()).await?;
    let purged = queue.purge(older_than_days).await?;
    queue.removals.wait_for_all().await;
    queue.end().await;
    Ok(purged)
}

/// Limits of validations: the queue is for all owners, of whom each has a part.
fn validations(config: &ServiceConfig) -> QueueLimits {
    let waiting = config.max_validations_waiting;
    QueueLimits {
        at_once: VALIDATIONS_PER_WORKER * config.workers.max(1),
        waiting,
        waiting_of_owner: waiting.div_ceil(config.owners_per_queue()),
        timeout: config.validation_patience,
    }
}

/// A service that is listening on its address.
pub struct Service {
    app: Arc<App>,
    listener: TcpListener,
    address: SocketAddr,
    workers: Vec<JoinHandle<()>>,
}

impl Service {
    /// Opens the data folder, starts the workers and listens.
    ///
    /// # Errors
    /// If the folder is in use or cannot be used, or if the address is not available, or other machines reach it and there are no
    /// tokens.
    pub async fn start(config: ServiceConfig, engine: Arc<dyn Engine>) -> Result<Self, ServiceError> {
        if config.tokens.is_open() && !config.listen.ip().is_loopback() {
            return Err(ServiceError::Exposed { address: config.listen });
        }
        let config = Arc::new(config);
        let listen = |source| ServiceError::Listen { address: config.listen, source };
        let listener = TcpListener::bind(config.listen).await.map_err(listen)?;
        let address = listener.local_addr().map_err(listen)?;
        let metrics = Arc::new(Metrics::default());
        let queue = open_queue(&config, engine, &metrics).await?;
        let audit = Arc::new(Audit::open(&config.store.data, config.max_audit_bytes)?);
        tokio::spawn(Audit::write_counts(Arc::downgrade(&audit)));
        if let Some(days) = config.keep_days {
            tokio::spawn(keep_for_days(Arc::clone(&queue), days));
        }
        let access = Arc::new(Access::new(config.tokens.clone()));
        if let Some(file) = config.tokens_file.clone() {
            let (access, closing) = (Arc::clone(&access), queue.closing());
            tokio::spawn(async move { access.follow(file, closing).await });
        }
        let workers = worker::start(&queue).map_err(ServiceError::Workers)?;
        let validation_slots = ValidationSlots::new(validations(&config));
        let exports = Slots::new(ARCHIVES_AT_ONCE);
        let attempts = Attempts::default();
        let rates = Rates::new(config.max_requests_per_s);
        let permits = AllPermits::of(config.max_connections);
        let app = Arc::new(App {
            queue,
            config,
            access,
            metrics,
            readiness: Readiness::default(),
            audit,
            attempts,
            rates,
            bodies: Bodies::default(),
            permits,
            validation_slots,
            exports,
        });
        Ok(Self { app, listener, address, workers })
    }

    /// The actual address it listens on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Answers until `stop` completes, then shuts down in order. Once `hurry` completes, running jobs get no more
    /// grace.
    pub async fn run_until(self, stop: impl Future<Output = ()>, hurry: impl Future<Output = ()>) {
        let Self { app, listener, workers, .. } = self;
        let (queue, config) = (Arc::clone(&app.queue), Arc::clone(&app.config));
        let serving = tokio::spawn(server::serve(listener, http::router(app), config, queue.closing()));
        stop.await;
        tracing::info!("shutting down");
        work::drain(&queue, workers, hurry).await;
        let _ = serving.await;
        queue.end().await;
        tracing::info!("shut down");
    }
}
