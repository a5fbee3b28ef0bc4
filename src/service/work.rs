//! Processes that run the jobs of a shared store, and answer no requests; and how workers end.

use super::config::ServiceConfig;
use super::jobs::JobId;
use super::jobs::engine::Engine;
use super::jobs::queue::Queue;
use super::jobs::worker::{self, Outcome};
use super::opening::{ServiceError, open_queue};
use std::future::Future;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

/// Time allowed to runs for stopping; a step that takes longer is abandoned.
const LAST_CALL: Duration = Duration::from_secs(5);

/// Runs jobs until `stop` completes, and then lets them end as a service does. Once `hurry` completes, they get no more grace.
///
/// # Errors
/// If the stores cannot be used, or the workers not be started.
pub async fn work(
    config: ServiceConfig,
    engine: Arc<dyn Engine>,
    stop: impl Future<Output = ()>,
    hurry: impl Future<Output = ()>,
) -> Result<(), ServiceError> {
    let queue = open_queue(&Arc::new(config), engine, &Arc::default()).await?;
    let workers = worker::start(&queue).map_err(ServiceError::Workers)?;
    stop.await;
    tracing::info!("shutting down");
    drain(&queue, workers, hurry).await;
    queue.end().await;
    Ok(())
}

/// Runs the job that has waited longest: its id and what became of it, or `None` if no job waits. Once `stop` completes, the job has the
/// grace period to end, and then returns to the queue.
///
/// # Errors
/// If the stores cannot be used, the disk has no room, or the worker cannot be started.
pub async fn work_once(
    config: ServiceConfig,
    engine: Arc<dyn Engine>,
    stop: impl Future<Output = ()>,
) -> Result<Option<(JobId, Outcome)>, ServiceError> {
    let grace = config.grace;
    let queue = open_queue(&Arc::new(config), engine, &Arc::default()).await?;
    let worker = worker::start_one(&queue).map_err(ServiceError::Workers)?;
    let ended = tokio::task::spawn_blocking(move || worker.join());
    let stopping = async {
        stop.await;
        tokio::time::sleep(grace).await;
        queue.interrupt_all();
        tokio::time::sleep(LAST_CALL).await;
    };
    let ended = tokio::select! {
        ended = ended => ended,
        () = stopping => {
            let left = hand_back(&queue).await;
            let id = left.first().ok_or_else(|| ServiceError::Workers(std::io::Error::other("the run did not stop in time")))?;
            return Ok(Some((*id, Outcome::NotOver)));
        }
    };
    queue.end().await;
    match ended {
        Ok(Ok(outcome)) => Ok(outcome?),
        // It has reported the panic on standard error.
        _ => Err(ServiceError::Workers(std::io::Error::other("the worker panicked"))),
    }
}

/// Returns to the queue what did not stop in time, and gives its ids.
async fn hand_back(queue: &Queue) -> Vec<JobId> {
    tracing::warn!("a run did not stop in time and is left behind");
    tokio::time::timeout(LAST_CALL, queue.hand_back()).await.unwrap_or_default()
}

/// Ends the workers of a queue: it is closed, running jobs have the grace period to end, or until `hurry` completes, and then return to
/// the queue.
pub(super) async fn drain(queue: &Queue, workers: Vec<JoinHandle<()>>, hurry: impl Future<Output = ()>) {
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
        () = tokio::time::sleep(queue.config.grace) => false,
        () = hurry => false,
    };
    // Requeue what is still running.
    if !is_early {
        tracing::info!("returning running jobs to the queue");
        queue.interrupt_all();
        if tokio::time::timeout(LAST_CALL, joined).await.is_err() {
            // It may wait for the object store.
            hand_back(queue).await;
        }
    }
}
