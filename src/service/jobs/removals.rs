//! What is deleted and not yet removed: removed in the background, again and again until the store of blobs lets it go.

use super::JobsError;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{Semaphore, watch};

/// Number of removals at the same time: each may block a thread on a store that does not answer.
const AT_ONCE: usize = 4;
/// Pause after the first attempt.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
/// Longest pause between two attempts.
const LONGEST_PAUSE: Duration = Duration::from_secs(60);

/// The removals of a process. What it does not finish is found by the next one.
#[derive(Debug)]
pub struct Removals {
    names: watch::Sender<BTreeSet<String>>,
    turns: Semaphore,
}

impl Default for Removals {
    fn default() -> Self {
        Self { names: watch::channel(BTreeSet::new()).0, turns: Semaphore::new(AT_ONCE) }
    }
}

impl Removals {
    /// Number of removals that are not done.
    pub fn count(&self) -> u64 {
        self.names.borrow().len() as u64
    }

    /// Whether a removal is not done.
    pub(super) fn has(&self, name: &str) -> bool {
        self.names.borrow().contains(name)
    }

    /// Calls `remove` until it succeeds or the service closes, unless that is being done under this name.
    pub(super) fn start<F>(
        self: &Arc<Self>,
        name: String,
        mut closing: watch::Receiver<bool>,
        remove: impl Fn() -> F + Send + 'static,
    ) where
        F: Future<Output = Result<(), JobsError>> + Send,
    {
        if !self.names.send_if_modified(|names| names.insert(name.clone())) {
            return;
        }
        let removals = Arc::clone(self);
        tokio::spawn(async move {
            let mut pause = FIRST_PAUSE;
            while let Err(error) = removals.in_turn(remove()).await {
                tracing::error!(name, %error, "what was deleted is not yet removed, and is tried again");
                tokio::select! {
                    () = tokio::time::sleep(pause) => {}
                    _ = closing.wait_for(|closing| *closing) => return,
                }
                pause = LONGEST_PAUSE.min(2 * pause);
            }
            removals.names.send_modify(|names| {
                names.remove(&name);
            });
        });
    }

    async fn in_turn(&self, removal: impl Future<Output = Result<(), JobsError>>) -> Result<(), JobsError> {
        // It is never closed.
        let _turn = self.turns.acquire().await;
        removal.await
    }

    /// Waits until a removal is done, for some time at most.
    pub async fn wait(&self, name: &str, within: Duration) {
        let mut names = self.names.subscribe();
        let _ = tokio::time::timeout(within, names.wait_for(|names| !names.contains(name))).await;
    }

    /// Waits until all removals are done.
    pub async fn wait_for_all(&self) {
        // The sender is here.
        let _ = self.names.subscribe().wait_for(BTreeSet::is_empty).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[tokio::test]
    async fn a_removal_is_tried_until_it_succeeds_and_by_one_at_a_time() {
        let (removals, attempts) = (Arc::<Removals>::default(), Arc::new(AtomicU32::new(0)));
        let closing = watch::channel(false).0;
        for _ in 0..2 {
            let attempts = Arc::clone(&attempts);
            removals.start("a".into(), closing.subscribe(), move || {
                let attempt = attempts.fetch_add(1, Ordering::SeqCst);
                std::future::ready(if attempt < 1 { Err(JobsError::BlobStoreSilent) } else { Ok(()) })
            });
        }
        removals.wait("a", Duration::from_millis(10)).await;
        assert_eq!((removals.count(), attempts.load(Ordering::SeqCst)), (1, 1), "no one waits for longer");
        removals.wait_for_all().await;
        assert_eq!((removals.count(), attempts.load(Ordering::SeqCst)), (0, 2));
    }

    #[tokio::test]
    async fn a_removal_ends_with_the_service() {
        let (removals, closing) = (Arc::<Removals>::default(), watch::channel(false).0);
        let watched = Arc::new(());
        let held = Arc::clone(&watched);
        removals.start("a".into(), closing.subscribe(), move || {
            let _ = &held;
            std::future::ready(Err(JobsError::BlobStoreSilent))
        });
        removals.wait("a", Duration::from_millis(50)).await;
        assert_eq!((removals.count(), Arc::strong_count(&watched)), (1, 2));
        closing.send_replace(true);
        tokio::time::sleep(Duration::from_millis(50)).await;
        assert_eq!(Arc::strong_count(&watched), 1);
    }
}
