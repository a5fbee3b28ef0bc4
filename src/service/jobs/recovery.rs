//! What processes that were lost have left: jobs and files.

use super::JobsError;
use super::failures::worker_lost;
use super::found::Found;
use super::queue::Queue;
use super::store::{JobEnd, Orphan, OwnerRequest, Requeued};
use crate::service::config::Role;
use crate::service::shelves::RESULTS;
use crate::step::Ending;
use crate::study::what_if::trim_shelf;
use std::sync::Arc;
use std::time::Duration;

/// Age from which a blob of stores that are shared is a leftover if no row refers to it.
const SHARED_LEAST_AGE: Duration = Duration::from_secs(86_400);

/// Pause between two attempts to recover what waits for the disk.
const RETRY_INTERVAL: Duration = Duration::from_secs(2);

/// Recovers the jobs whose process was lost: those that were running wait again, or end if they lost it too often.
///
/// # Errors
/// If the store or the files fail for one of them; the others are recovered.
pub async fn recover(queue: &Arc<Queue>) -> Result<(), JobsError> {
    let mut recovered = Ok(());
    for orphan in queue.store.orphans().await? {
        // Otherwise it was taken for lost for a moment, and is not: its process is this one, or this one erases it already.
        if !queue.has(orphan.id) && !queue.removals.has(&orphan.id.to_string()) {
            recovered = recovered.and(recover_one(queue, &orphan).await);
        }
    }
    recovered
}

async fn recover_one(queue: &Arc<Queue>, orphan: &Orphan) -> Result<(), JobsError> {
    let Orphan { seq, id, attempt, request } = *orphan;
    let ending = OrphanEnding::of(request, attempt, queue.config.max_attempts);
    tracing::warn!(job = %id, attempt, ?ending, "found a job without its worker");
    let ending = match ending {
        OrphanEnding::Requeue => {
            queue.with_files(move |queue| queue.folder.remove(id)).await?;
            queue.store.requeue(seq, attempt, Requeued::WorkerLost).await?;
            queue.wake();
            queue.ring(Some(seq));
            return Ok(());
        }
        OrphanEnding::Erase => {
            queue.start_to_erase(seq, id, attempt);
            return Ok(());
        }
        OrphanEnding::Cancel => Ending::Cancelled,
        OrphanEnding::GiveUp => worker_lost(attempt).into(),
    };
    let is_cancelled = ending == Ending::Cancelled;
    let keep = move |queue: &Queue| match queue.keep_recording(id, attempt, false) {
        // Waited for: the job is not to blame.
        Err(error) if queue.has_distant_blobs() || (!is_cancelled && queue.is_storage_away(id, &error)) => {
            Err(error)
        }
        Err(error) => {
            tracing::error!(job = %id, %error, "the recording could not be kept");
            queue.folder.remove(id).map(|()| None)
        }
        kept => kept,
    };
    let recording = queue.with_files(keep).await?;
    let end = JobEnd { ending, summary: None, headline: None, recording, progress: None };
    queue.store.finish(seq, attempt, &end).await?;
    queue.ring(Some(seq));
    Ok(())
}

/// Recovers later what waits for the disk. No job begins before.
pub fn recover_later(queue: &Arc<Queue>) {
    let (weak, waiting) = (Arc::downgrade(queue), queue.end_waits());
    queue.spawn(async move {
        loop {
            tokio::time::sleep(RETRY_INTERVAL).await;
            let Some(queue) = weak.upgrade() else { return };
            match recover(&queue).await {
                Ok(()) => {
                    if let Err(error) = remove_leftovers(&queue).await {
                        tracing::warn!(%error, "files of the last process stay");
                    }
                    break;
                }
                Err(error) => tracing::warn!(%error, "jobs of the last process wait for the disk"),
            }
        }
        drop(waiting);
    });
}

/// Removes unreferenced files of the previous process: files of runs, snapshots, unregistered uploads, results. Recordings without
/// their jobs stay, as the service never leaves any, and then meshes stay, too: an older or empty store may have replaced the one
/// that knew them. In stores that are shared, what is not a day old may be in use.
///
/// # Errors
/// If the store or the files fail.
pub async fn remove_leftovers(queue: &Arc<Queue>) -> Result<(), JobsError> {
    queue.with_files(|queue| queue.folder.remove_leftovers()).await?;
    if queue.config.role == Role::Worker {
        return Ok(());
    }
    let known = queue.store.blobs().await?;
    let least_age = if queue.store.shared().is_some() { SHARED_LEAST_AGE } else { Duration::ZERO };
    queue
        .with_files(move |queue| {
            let found = Found::among(queue.blobs.as_ref(), &known, least_age)?;
            found.report();
            for name in found.removable(&known) {
                queue.blobs.delete(name)?;
            }
            Ok(trim_shelf(queue.blobs.as_ref(), RESULTS)?)
        })
        .await
}

/// What becomes of a job whose worker was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OrphanEnding {
    /// The job waits again.
    Requeue,
    /// The job had been cancelled by its owner.
    Cancel,
    /// The job lost its worker too often, and fails.
    GiveUp,
    /// The job had been deleted by its owner.
    Erase,
}

impl OrphanEnding {
    fn of(request: OwnerRequest, attempt: u32, max_attempts: u32) -> Self {
        match request {
            OwnerRequest::Deletion => Self::Erase,
            OwnerRequest::Stop => Self::Cancel,
            OwnerRequest::Result if attempt >= max_attempts => Self::GiveUp,
            OwnerRequest::Result => Self::Requeue,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orphans_have_the_fate_that_they_deserve() {
        let endings = |max_attempts| {
            let requests = [OwnerRequest::Result, OwnerRequest::Stop, OwnerRequest::Deletion];
            requests.map(|request| OrphanEnding::of(request, 1, max_attempts))
        };
        assert_eq!(endings(2), [OrphanEnding::Requeue, OrphanEnding::Cancel, OrphanEnding::Erase]);
        assert_eq!(endings(1), [OrphanEnding::GiveUp, OrphanEnding::Cancel, OrphanEnding::Erase]);
    }
}
