//! Slots for blocking work on separate threads, so that those of the runtime stay responsive.

use super::problem::Problem;
use crate::service::fair_queue::{FairQueue, Lane, QueueLimits};
use std::sync::Arc;
use tokio::sync::Semaphore;
use tracing::Instrument as _;

/// Limit of simultaneous work of one kind; further work waits.
#[derive(Clone, Debug)]
pub struct Slots(Arc<Semaphore>);

impl Slots {
    /// Allows this many at a time.
    pub fn new(at_once: usize) -> Self {
        Self(Arc::new(Semaphore::new(at_once)))
    }

    /// Performs work as soon as a slot is free.
    ///
    /// # Errors
    /// If the work panics.
    pub async fn call<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let slot = Arc::clone(&self.0).acquire_owned().await.map_err(|e| Problem::internal(&e))?;
        holding(slot, work).await
    }
}

/// Limit of simultaneous validations of scenes, meshes and recordings: each may hold a mesh in memory. Owners take turns,
/// and small scenes do not wait for large ones.
#[derive(Clone, Debug)]
pub struct ValidationSlots(FairQueue);

impl ValidationSlots {
    /// Slots with a limited queue.
    pub fn new(limits: QueueLimits) -> Self {
        Self(FairQueue::new(limits))
    }

    /// Performs work as soon as a slot is free.
    ///
    /// # Errors
    /// If too much work waits already, or for too long, or the work panics.
    pub async fn call<T: Send + 'static>(
        &self,
        owner: &str,
        lane: Lane,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let slot = self.0.enter(owner, lane).instrument(tracing::debug_span!("waiting")).await?;
        let span = tracing::debug_span!("validation");
        holding(slot, move || span.in_scope(work)).await
    }

    /// As [`Self::call`], with work that may ask whether its answer is still wanted: not if the client has disconnected.
    ///
    /// # Errors
    /// As [`Self::call`].
    pub async fn call_while_wanted<T: Send + 'static>(
        &self,
        owner: &str,
        lane: Lane,
        work: impl FnOnce(&dyn Fn() -> bool) -> T + Send + 'static,
    ) -> Result<T, Problem> {
        // The request holds the one end, and is dropped with its connection.
        let wanted = Arc::new(());
        let request = Arc::downgrade(&wanted);
        let answer = self.call(owner, lane, move || work(&|| request.strong_count() > 0)).await;
        drop(wanted);
        answer
    }
}

/// Performs work that holds a slot, which the work releases, not the request: a client that disconnects ends only the
/// latter.
async fn holding<P: Send + 'static, T: Send + 'static>(
    slot: P,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Problem> {
    let working = tokio::task::spawn_blocking(move || {
        let _slot = slot;
        work()
    });
    working.await.map_err(|e| Problem::internal(&e))
}
