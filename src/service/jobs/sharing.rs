//! Processes that share a job store: leases of the jobs that run here, jobs that another process has lost, and changes by others.

use super::JobsError;
use super::control::StopReason;
use super::queue::Queue;
use super::recovery::recover;
use super::store::{Change, OwnerRequest, SharedStore};
use futures::StreamExt as _;
use std::sync::Arc;
use std::time::Duration;

/// Number of times that a lease is renewed while it lasts.
const RENEWALS_PER_LEASE: u32 = 3;
/// Pause before the changes are asked for again.
const PAUSE: Duration = Duration::from_secs(1);

/// Starts the tasks of a queue whose store is shared. They end with the queue.
pub fn start(queue: &Arc<Queue>) {
    let Some(lease) = queue.store.shared().map(SharedStore::lease) else { return };
    let weak = Arc::downgrade(queue);
    queue.spawn(async move {
        let mut ticks = tokio::time::interval(lease / RENEWALS_PER_LEASE);
        ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        loop {
            ticks.tick().await;
            let Some(queue) = weak.upgrade() else { return };
            if let Err(error) = look_around(&queue).await {
                tracing::warn!(%error, "cannot renew the leases of jobs");
            }
        }
    });
    let weak = Arc::downgrade(queue);
    queue.spawn(async move {
        loop {
            let Some(queue) = weak.upgrade() else { return };
            let Some(shared) = queue.store.shared() else { return };
            let changes = shared.changes().await;
            drop(queue);
            match changes {
                Ok(mut changes) => {
                    while let Some(change) = changes.next().await {
                        let Some(queue) = weak.upgrade() else { return };
                        follow(&queue, change).await;
                    }
                }
                Err(error) => tracing::warn!(%error, "the job store does not announce changes"),
            }
            tokio::time::sleep(PAUSE).await;
        }
    });
}

/// Renews the leases of the jobs that run here, takes those of lost processes, and looks for changes that were not announced.
async fn look_around(queue: &Arc<Queue>) -> Result<(), JobsError> {
    renew(queue).await?;
    recover(queue).await?;
    queue.wake();
    queue.ring(None);
    Ok(())
}

/// Renews the leases of the jobs that run here, and stops those that are no longer wanted, or are those of another process.
async fn renew(queue: &Queue) -> Result<(), JobsError> {
    let (running, Some(shared)) = (queue.running(), queue.store.shared()) else { return Ok(()) };
    if running.is_empty() {
        return Ok(());
    }
    let seqs: Vec<i64> = running.keys().copied().collect();
    let requests = shared.renew(&seqs).await?;
    for (seq, control) in running {
        match requests.get(&seq) {
            Some(OwnerRequest::Result) => {}
            Some(OwnerRequest::Stop | OwnerRequest::Deletion) => control.stop(StopReason::Cancel),
            // Its reports have no effect any more, nor has its return to the queue.
            None => control.stop(StopReason::Shutdown),
        }
    }
    Ok(())
}

/// Passes a change on to those who wait for it here.
async fn follow(queue: &Queue, change: Change) {
    match change {
        Change::Arrival(seq) => {
            queue.wake();
            queue.ring(Some(seq));
        }
        Change::Event(seq) => queue.ring(Some(seq)),
        Change::Request(seq) => {
            queue.ring(Some(seq));
            if queue.running().contains_key(&seq)
                && let Err(error) = renew(queue).await
            {
                // The next renewal sees it.
                tracing::warn!(%error, "cannot see whether a job is still wanted");
            }
        }
        Change::Missed => {
            queue.wake();
            queue.ring(None);
        }
    }
}
