//! The service: jobs that survive, over HTTP.
//!
//! [`Service::start`] opens the data folder (taking over what the process before it left), starts the workers and
//! listens; [`Service::run_until`] answers until it is told to stop. The order of the end: no new connection and no new
//! job, event streams end, running jobs get their grace and then go back to the queue, answers finish, the store closes.
//!
//! - [`jobs`]: what can be asked of jobs, without HTTP.
//! - [`http`]: the calls; `http/problem.rs` is the only place that knows status codes.
//! - [`shelves`]: what recordings, meshes, snapshots and results are called in the [store of blobs](crate::blobs).
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
use http::{App, Judges};
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

/// Scenes and meshes judged at the same time for each worker; each may hold a mesh in memory.
const JUDGES_PER_WORKER: usize = 2;

/// Why the service did not start.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// The data folder or the store could not be used.
    #[error(transparent)]
    Jobs(#[from] JobsError),
    /// The address could not be listened on.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// The workers could not be started.
    #[error("cannot start the workers: {0}")]
    Workers(std::io::Error),
}

/// How long runs may take to stop when they were told to; a step that takes longer is given up.
const LAST_CALL: Duration = Duration::from_secs(5);

/// A service that listens.
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
    /// When the folder is in use or cannot be used, or when the address cannot be listened on.
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
        let judges = Judges::new(JUDGES_PER_WORKER * config.workers.max(1));
        let app = Arc::new(App { queue, config, metrics, judges });
        Ok(Self { app, listener, address, workers })
    }

    /// The address that it listens on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Answers until `stop` is done, then shuts down in order. When `hurry` is done too, running jobs get no more grace.
    pub async fn run_until(self, stop: impl Future<Output = ()>, hurry: impl Future<Output = ()>) {
        let Self { app, listener, workers, .. } = self;
        let (queue, config) = (Arc::clone(&app.queue), Arc::clone(&app.config));
        let serving =
            tokio::spawn(server::serve(listener, http::router(app), Arc::clone(&config), queue.closing()));
        stop.await;
        tracing::info!("shutting down");
        queue.close();
        let joined = tokio::task::spawn_blocking(move || {
            for worker in workers {
                // A worker that panicked outside a run has said so on standard error.
                let _ = worker.join();
            }
        });
        tokio::pin!(joined);
        let is_early = tokio::select! {
            _ = &mut joined => true,
            () = tokio::time::sleep(config.grace) => false,
            () = hurry => false,
        };
        if !is_early {
            tracing::info!("putting running jobs back into the queue");
            queue.interrupt_all();
            if tokio::time::timeout(LAST_CALL, joined).await.is_err() {
                // Its row says "running": the next start puts it back.
                tracing::warn!("a run did not stop in time and is left behind");
            }
        }
        let _ = serving.await;
        queue.store.close().await;
        tracing::info!("shut down");
    }
}
