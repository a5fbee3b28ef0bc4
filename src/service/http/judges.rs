//! Work on threads that may compute and wait for files, so that those of the runtime go on answering.

use super::problem::Problem;
use std::sync::Arc;
use tokio::sync::Semaphore;

/// Scenes, meshes and recordings that may be judged at the same time: each may hold a mesh in memory.
#[derive(Clone, Debug)]
pub struct Judges(Arc<Semaphore>);

impl Judges {
    /// So many at a time.
    pub fn new(at_once: usize) -> Self {
        Self(Arc::new(Semaphore::new(at_once)))
    }

    /// Does a piece of work when there is room for it.
    ///
    /// # Errors
    /// When the work panics.
    pub async fn call<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        let room = Arc::clone(&self.0).acquire_owned().await.map_err(|e| Problem::internal(&e))?;
        let working = tokio::task::spawn_blocking(move || {
            // Given back by the work and not by the request: a client that hangs up ends only the latter.
            let _room = room;
            work()
        });
        working.await.map_err(|e| Problem::internal(&e))
    }
}
