//! Slots for blocking work on separate threads, so that those of the runtime stay responsive.

use super::problem::Problem;
use std::sync::Arc;
use tokio::sync::Semaphore;

/// Limit of simultaneous validations of scenes, meshes and recordings: each may hold a mesh in memory.
#[derive(Clone, Debug)]
pub struct ValidationSlots(Arc<Semaphore>);

impl ValidationSlots {
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
        let working = tokio::task::spawn_blocking(move || {
            // Released by the work, not by the request: a client that disconnects ends only the latter.
            let _slot = slot;
            work()
        });
        working.await.map_err(|e| Problem::internal(&e))
    }
}
