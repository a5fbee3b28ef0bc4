//! What is left of the process before this one.

use super::lifecycle::JobEnd;
use super::{Store, add_event, event};
use crate::service::jobs::{FinalRecording, JobFailure, JobFailureCause, JobId, JobState, JobsError};
use serde_json::json;

/// What becomes of a job whose worker was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recovered {
    /// It waits again.
    Requeue,
    /// Its owner had cancelled it.
    Cancel,
    /// It lost its worker too often.
    GiveUp,
    /// Its owner had deleted it.
    Erase,
}

impl Store {
    /// The jobs whose worker was lost, and those that were hidden but not erased: number, id, attempt, and what is to
    /// become of them. Only right at the start, while no worker of this process has begun.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn orphans(&self, max_attempts: u32) -> Result<Vec<(i64, JobId, u32, Recovered)>, JobsError> {
        let rows: Vec<(i64, String, u32, bool, bool)> = sqlx::query_as(
            "SELECT seq, id, attempts, cancel_requested, deleted FROM jobs WHERE state = 'running' OR deleted = 1
             ORDER BY seq",
        )
        .fetch_all(&self.pool)
        .await?;
        rows.into_iter()
            .map(|(seq, id, attempts, cancel_requested, deleted)| {
                let fate = match (deleted, cancel_requested, attempts >= max_attempts) {
                    (true, _, _) => Recovered::Erase,
                    (_, true, _) => Recovered::Cancel,
                    (_, _, true) => Recovered::GiveUp,
                    _ => Recovered::Requeue,
                };
                let id = id.parse().map_err(|_| JobsError::Corrupt { what: "job id", value: id })?;
                Ok((seq, id, attempts, fate))
            })
            .collect()
    }

    /// Lets a job wait again whose worker was lost. The attempt counts: it may be the job that kills its workers.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn requeue_orphan(&self, seq: i64) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        sqlx::query(
            "UPDATE jobs SET state = 'queued', phase = 'waiting', started_at = NULL, eta_s = NULL, progress = 0, step = 0,
                 simulated_time_s = 0 WHERE seq = ?1",
        )
        .bind(seq)
        .execute(&mut *transaction)
        .await?;
        let data = json!({ "state": "queued", "reason": "the process that ran it was lost" });
        add_event(&mut transaction, seq, event::REQUEUED, &data).await?;
        transaction.commit().await?;
        Ok(())
    }

    /// Ends a job whose worker was lost: cancelled if its owner wanted that, else failed.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn end_orphan(
        &self,
        seq: i64,
        attempt: u32,
        cancelled: bool,
        recording: Option<FinalRecording>,
    ) -> Result<(), JobsError> {
        let failure = (!cancelled).then(|| JobFailure {
            cause: JobFailureCause::WorkerLost,
            message: format!("the process that ran it was lost {attempt} times"),
            remedy:
                "Look at the memory of the machine and at the log of the service; a smaller scene may pass."
                    .into(),
            time_s: None,
            step: None,
            element: None,
        });
        let state = if cancelled { JobState::Cancelled } else { JobState::Failed };
        let end = JobEnd { state, failure, summary: None, recording, progress: None };
        self.finish(seq, attempt, &end).await?;
        Ok(())
    }
}
