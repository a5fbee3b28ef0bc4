//! Processes that share a job store: leases of the jobs that run here, jobs that another process has lost, and changes by others.

use super::JobsError;
use super::control::StopReason;
use super::queue::{Held, Queue};
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
    // Apart, since recovery may wait for the object store for longer than a lease lasts.
    let interval = lease / RENEWALS_PER_LEASE;
    repeat(queue, interval, move |queue| async move {
        match tokio::time::timeout(interval, renew(&queue)).await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => tracing::warn!(%error, "cannot renew the leases of jobs"),
            Err(_) => tracing::warn!("the job store does not answer: the leases of jobs are not renewed"),
        }
    });
    repeat(queue, interval, |queue| async move {
        if let Err(error) = recover(&queue).await {
            tracing::warn!(%error, "cannot recover the jobs of lost processes");
        }
        // Changes may not have been announced.
        queue.wake();
        queue.ring(None);
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

/// Does something at intervals until the queue ends.
fn repeat<F: Future<Output = ()> + Send>(
    queue: &Arc<Queue>,
    interval: Duration,
    act: impl Fn(Arc<Queue>) -> F + Send + Sync + 'static,
) {
    let weak = Arc::downgrade(queue);
    queue.spawn(async move {
        let mut ticks = tokio::time::interval(interval);
        ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        loop {
            ticks.tick().await;
            let Some(queue) = weak.upgrade() else { return };
            act(queue).await;
        }
    });
}

/// Renews the leases of the jobs that run here, and stops those that are no longer wanted, or are those of another process.
async fn renew(queue: &Queue) -> Result<(), JobsError> {
    let (running, Some(shared)) = (queue.running(), queue.store.shared()) else { return Ok(()) };
    if running.is_empty() {
        return Ok(());
    }
    let seqs: Vec<i64> = running.iter().map(|held| held.seq).collect();
    let renewed = shared.renew(&seqs).await?;
    for Held { seq, attempt, control } in running {
        match renewed.get(&seq) {
            Some((_, OwnerRequest::Stop | OwnerRequest::Deletion)) => control.stop(StopReason::Cancel),
            Some((current, OwnerRequest::Result)) if *current == attempt => {}
            // Another process has the job, or this one has it again for a later attempt, which waits for this one to stop: its reports
            // have no effect any more, nor has its return to the queue.
            _ => control.stop(StopReason::Shutdown),
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
            if queue.running().iter().any(|held| held.seq == seq)
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
