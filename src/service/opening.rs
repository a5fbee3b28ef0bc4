//! How a process of the service opens its stores.

use super::config::ServiceConfig;
use super::jobs::data_folder::DataFolder;
use super::jobs::deletion::REMOVAL_PATIENCE;
use super::jobs::engine::Engine;
use super::jobs::pulse::{self, Pulse};
use super::jobs::queue::{Queue, Storage};
use super::jobs::recovery::{recover, recover_later, remove_leftovers};
use super::jobs::store::{Identity, JobStore, PATIENCE, PROBE_PATIENCE, StoreAddress};
use super::jobs::{JobsError, ownership, sharing};
use super::metrics::Metrics;
use crate::blobs::{BlobError, BlobStore};
use std::net::SocketAddr;
use std::sync::Arc;

/// What is lost with the last changes of the job store, if any are.
pub(super) async fn lost_log(address: &StoreAddress) -> Option<(u32, String)> {
    let lost = address.lost_changes().await;
    let words = format!(
        "the log of jobs.sqlite is lost, or a part of it, and with it the last changes ({lost}) before the process that made them was \
         ended: jobs submitted with them are missing, jobs that ended run again, and jobs that were deleted are back"
    );
    (lost > 0).then_some((lost, words))
}

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
    /// Without tokens, whoever reaches the address could use the service.
    #[error(
        "without tokens the service listens on this machine only, not on {address}: give tokens with --tokens-file \
         (`contuse token NAME` makes them), or listen on 127.0.0.1:{}", address.port()
    )]
    Exposed {
        /// Address in the configuration.
        address: SocketAddr,
    },
    /// The workers could not be started.
    #[error("cannot start the workers: {0}")]
    Workers(std::io::Error),
}

/// Opens the data folder, and recovers the jobs of lost processes.
pub(super) async fn open_queue(
    config: &Arc<ServiceConfig>,
    engine: Arc<dyn Engine>,
    metrics: &Arc<Metrics>,
) -> Result<Arc<Queue>, JobsError> {
    let folder = DataFolder::open(&config.store.data)?;
    if let Some((_, words)) = lost_log(&config.store).await {
        tracing::error!("{words}; `contuse doctor` says what can be recovered");
    }
    let tried = check_blobs(&config.store).await?;
    let blobs = config.store.open_blobs(PATIENCE)?;
    let jobs = Box::pin(config.store.open()).await?;
    let pulse = match tried {
        Some(tried) => {
            Some(Arc::new(Pulse::of(Arc::clone(&tried), claim_blobs(tried, jobs.as_ref()).await?)))
        }
        None => None,
    };
    let storage = Storage { jobs, blobs, pulse: pulse.clone(), folder };
    let queue = Queue::new(storage, Arc::clone(config), engine, Arc::clone(metrics));
    match recover(&queue).await {
        Ok(()) => {
            // What the process before this one was asked to delete.
            let _ = tokio::time::timeout(REMOVAL_PATIENCE, queue.removals.wait_for_all()).await;
            remove_leftovers(&queue).await?;
        }
        Err(error) if queue.store.shared().is_none() && error.is_of_machine() => {
            tracing::error!(%error, "jobs of the last process wait for the disk");
            recover_later(&queue);
        }
        Err(error) => return Err(error),
    }
    if let Some(pulse) = pulse {
        queue.spawn(Pulse::follow(Arc::downgrade(&pulse)));
    }
    sharing::start(&queue);
    Ok(queue)
}

/// Checks the store of blobs, if it is on other machines, and gives it without patience.
async fn check_blobs(address: &StoreAddress) -> Result<Option<Arc<dyn BlobStore>>, JobsError> {
    if address.blobs.is_none() {
        return Ok(None);
    }
    let blobs = address.open_blobs(PROBE_PATIENCE)?;
    let checked = Arc::clone(&blobs);
    on_a_thread(move || pulse::check(checked.as_ref())).await?;
    Ok(Some(blobs))
}

/// Makes sure that a store of blobs is that of a database.
async fn claim_blobs(blobs: Arc<dyn BlobStore>, jobs: &dyn JobStore) -> Result<Option<Identity>, JobsError> {
    let Some(shared) = jobs.shared() else { return Ok(None) };
    let own = shared.identity().await?;
    let claimed = own.clone();
    on_a_thread(move || ownership::claim(blobs.as_ref(), &claimed)).await?;
    if !own.has_blobs {
        shared.note_blobs().await?;
    }
    Ok(Some(Identity { has_blobs: true, ..own }))
}

/// Does work that may wait for blobs.
pub(super) async fn on_a_thread<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, JobsError> + Send + 'static,
) -> Result<T, JobsError> {
    let working = tokio::task::spawn_blocking(work);
    working.await.unwrap_or_else(|error| Err(BlobError::from(std::io::Error::other(error)).into()))
}
