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
//! - [`config`], [`metrics`], [`server`]: limits, counters, the listener.

pub mod config;
pub mod http;
pub mod jobs;
pub mod meshes;
pub mod metrics;
pub mod server;
pub mod shelves;
mod stall;

use crate::blobs::FolderBlobs;
use config::ServiceConfig;
use http::{App, ValidationSlots};
use jobs::JobsError;
use jobs::data_folder::DataFolder;
use jobs::engine::Engine;
use jobs::queue::{Queue, Storage};
use jobs::store::SqliteStore;
use jobs::worker;
use metrics::Metrics;
use std::future::Future;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::net::TcpListener;

/// Simultaneous validations of scenes and meshes per worker; each may hold a mesh in memory.
const VALIDATIONS_PER_WORKER: usize = 2;
/// Archives of fields that are sent at once; more wait.
const ARCHIVES_AT_ONCE: usize = 4;

/// Why the service did not start.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// The data folder or the store could not be used.
    #[error(transparent)]
    Jobs(#[from] JobsError),
    /// The address is not available.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// Address in the configuration.
        address: SocketAddr,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The workers could not be started.
    #[error("cannot start the workers: {0}")]
    Workers(std::io::Error),
}

/// Time allowed to runs for stopping; a step that takes longer is abandoned.
const LAST_CALL: Duration = Duration::from_secs(5);

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
    /// If the folder is in use or cannot be used, or if the address is not available.
    pub async fn start(config: ServiceConfig, engine: Arc<dyn Engine>) -> Result<Self, ServiceError> {
        let config = Arc::new(config);
        let listen = |source| ServiceError::Listen { address: config.listen, source };
        let listener = TcpListener::bind(config.listen).await.map_err(listen)?;
        let address = listener.local_addr().map_err(listen)?;
        let metrics = Arc::new(Metrics::default());
        let folder = DataFolder::open(&config.data)?;
        let storage = Storage {
            jobs: Arc::new(SqliteStore::open(&folder.store_file()).await?),
            blobs: Arc::new(FolderBlobs::open(&config.data).map_err(JobsError::from)?),
            folder,
        };
        let queue = Queue::open(storage, Arc::clone(&config), engine, Arc::clone(&metrics)).await?;
        let workers = worker::start(&queue).map_err(ServiceError::Workers)?;
        let validation_slots = ValidationSlots::new(VALIDATIONS_PER_WORKER * config.workers.max(1));
        let exports = ValidationSlots::new(ARCHIVES_AT_ONCE);
        let app = Arc::new(App { queue, config, metrics, validation_slots, exports });
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
        let serving =
            tokio::spawn(server::serve(listener, http::router(app), Arc::clone(&config), queue.closing()));
        stop.await;
        tracing::info!("shutting down");
        // Let running jobs finish within the grace period.
        queue.close();
        let joined = tokio::task::spawn_blocking(move || {
            for worker in workers {
                // A worker that panicked outside a run has reported it on standard error.
                let _ = worker.join();
            }
        });
        tokio::pin!(joined);
        let is_early = tokio::select! {
            _ = &mut joined => true,
            () = tokio::time::sleep(config.grace) => false,
            () = hurry => false,
        };
        // Requeue what is still running.
        if !is_early {
            tracing::info!("putting running jobs back into the queue");
            queue.interrupt_all();
            if tokio::time::timeout(LAST_CALL, joined).await.is_err() {
                // Its row says "running": the next start requeues it.
                tracing::warn!("a run did not stop in time and is left behind");
            }
        }
        let _ = serving.await;
        queue.store.close().await;
        tracing::info!("shut down");
    }
}
