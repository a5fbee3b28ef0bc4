//! From the queue to the end.

use super::{Store, add_event, event};
use crate::service::jobs::{FinalRecording, JobFailure, JobId, JobState, JobsError, RunProgress};
use serde_json::json;
use sqlx::{Sqlite, Transaction};

/// A job that a worker took.
#[derive(Clone, Debug)]
pub struct ClaimedJob {
    /// Order of arrival.
    pub seq: i64,
    /// Its id.
    pub id: JobId,
    /// Whose it is.
    pub owner: String,
    /// The scene document.
    pub scene: Vec<u8>,
    /// Which attempt this is, from 1.
    pub attempt: u32,
}

/// How a job ended.
#[derive(Clone, Debug)]
pub struct JobEnd {
    /// The final state.
    pub state: JobState,
    /// Why it failed.
    pub failure: Option<JobFailure>,
    /// Its summary, JSON text.
    pub summary: Option<String>,
    /// Its recording.
    pub recording: Option<FinalRecording>,
    /// How far it came, when that is known.
    pub progress: Option<RunProgress>,
}

/// What became of a wish to cancel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelAnswer {
    /// It waited, and is cancelled.
    Cancelled {
        /// Order of arrival.
        seq: i64,
    },
    /// It runs, and will stop.
    Stopping,
    /// It was cancelled before.
    AlreadyCancelled,
    /// It ended otherwise before.
    TooLate(JobState),
    /// There is no such job.
    Unknown,
}

/// What became of a wish to delete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeleteAnswer {
    /// Nobody works on it: it can be erased.
    Idle {
        /// Order of arrival.
        seq: i64,
    },
    /// It runs: its worker erases it when it has stopped.
    Running {
        /// Order of arrival.
        seq: i64,
    },
    /// There is no such job.
    Unknown,
}

impl Store {
    /// Takes the job that has waited longest.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn claim(&self) -> Result<Option<ClaimedJob>, JobsError> {
        let mut transaction = self.begin().await?;
        let row: Option<(i64, String, String, Vec<u8>, u32)> = sqlx::query_as(
            "UPDATE jobs SET state = 'running', phase = 'loading', attempts = attempts + 1, progress = 0, step = 0,
                 simulated_time_s = 0, expected_steps = NULL, eta_s = NULL,
                 started_at = strftime('%Y-%m-%dT%H:%M:%fZ', 'now')
             WHERE seq = (SELECT seq FROM jobs WHERE state = 'queued' AND deleted = 0 ORDER BY seq LIMIT 1)
             RETURNING seq, id, owner, scene, attempts",
        )
        .fetch_optional(&mut *transaction)
        .await?;
        let Some((seq, id, owner, scene, attempt)) = row else { return Ok(None) };
        add_event(&mut transaction, seq, event::RUNNING, &json!({ "state": "running", "attempt": attempt }))
            .await?;
        transaction.commit().await?;
        let id = id.parse().map_err(|_| JobsError::Corrupt { what: "job id", value: id })?;
        Ok(Some(ClaimedJob { seq, id, owner, scene, attempt }))
    }

    /// Says how far an attempt has come.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn record_progress(
        &self,
        seq: i64,
        attempt: u32,
        progress: &RunProgress,
    ) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        if write_progress(&mut transaction, seq, attempt, progress).await? {
            add_event(&mut transaction, seq, event::PROGRESS, &serde_json::to_value(progress)?).await?;
            transaction.commit().await?;
        }
        Ok(())
    }

    /// Keeps a part of the result of an attempt as an event.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn record_event(
        &self,
        seq: i64,
        attempt: u32,
        kind: &str,
        data: &serde_json::Value,
    ) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        let running: Option<(i64,)> =
            sqlx::query_as("SELECT seq FROM jobs WHERE seq = ?1 AND state = 'running' AND attempts = ?2")
                .bind(seq)
                .bind(attempt)
                .fetch_optional(&mut *transaction)
                .await?;
        if running.is_some() {
            add_event(&mut transaction, seq, kind, data).await?;
            transaction.commit().await?;
        }
        Ok(())
    }

    /// Ends an attempt. False when the attempt was over already.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn finish(&self, seq: i64, attempt: u32, end: &JobEnd) -> Result<bool, JobsError> {
        let mut transaction = self.begin().await?;
        if let Some(progress) = &end.progress {
            write_progress(&mut transaction, seq, attempt, progress).await?;
        }
        let failure = end.failure.as_ref().map(serde_json::to_string).transpose()?;
        let result = sqlx::query(
            "UPDATE jobs SET state = ?3, phase = 'done', eta_s = NULL, failure = ?4, summary = ?5,
                 recording_bytes = ?6, recording_sha256 = ?7, recording_complete = ?8,
                 progress = CASE WHEN ?3 = 'succeeded' THEN 1 ELSE progress END,
                 finished_at = strftime('%Y-%m-%dT%H:%M:%fZ', 'now')
             WHERE seq = ?1 AND state = 'running' AND attempts = ?2",
        )
        .bind(seq)
        .bind(attempt)
        .bind(end.state.as_str())
        .bind(failure)
        .bind(&end.summary)
        .bind(end.recording.as_ref().map(|r| r.bytes.cast_signed()))
        .bind(end.recording.as_ref().map(|r| r.sha256.as_str()))
        .bind(end.recording.as_ref().map(|r| r.complete))
        .execute(&mut *transaction)
        .await?;
        if result.rows_affected() == 0 {
            return Ok(false);
        }
        let data = json!({ "state": end.state, "failure": end.failure });
        add_event(&mut transaction, seq, end.state.as_str(), &data).await?;
        transaction.commit().await?;
        Ok(true)
    }

    /// Puts a job back that its worker had to drop. The attempt does not count: it was not the job's fault.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn put_back(&self, seq: i64, attempt: u32, reason: &str) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        let result = sqlx::query(
            "UPDATE jobs SET state = 'queued', phase = 'waiting', attempts = attempts - 1, started_at = NULL, eta_s = NULL,
                 progress = 0, step = 0, simulated_time_s = 0
             WHERE seq = ?1 AND state = 'running' AND attempts = ?2",
        )
        .bind(seq)
        .bind(attempt)
        .execute(&mut *transaction)
        .await?;
        if result.rows_affected() > 0 {
            add_event(
                &mut transaction,
                seq,
                event::REQUEUED,
                &json!({ "state": "queued", "reason": reason }),
            )
            .await?;
            transaction.commit().await?;
        }
        Ok(())
    }

    /// Cancels a job that waits, or notes that one that runs has to stop.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn cancel(&self, owner: &str, id: JobId) -> Result<CancelAnswer, JobsError> {
        let mut transaction = self.begin().await?;
        let Some((seq, state)) = find(&mut transaction, owner, id).await? else {
            return Ok(CancelAnswer::Unknown);
        };
        let answer = match state {
            JobState::Queued => {
                sqlx::query(
                    "UPDATE jobs SET state = 'cancelled', phase = 'done', cancel_requested = 1,
                         finished_at = strftime('%Y-%m-%dT%H:%M:%fZ', 'now') WHERE seq = ?1",
                )
                .bind(seq)
                .execute(&mut *transaction)
                .await?;
                add_event(
                    &mut transaction,
                    seq,
                    "cancelled",
                    &json!({ "state": "cancelled", "failure": null }),
                )
                .await?;
                CancelAnswer::Cancelled { seq }
            }
            JobState::Running => {
                sqlx::query("UPDATE jobs SET cancel_requested = 1 WHERE seq = ?1")
                    .bind(seq)
                    .execute(&mut *transaction)
                    .await?;
                CancelAnswer::Stopping
            }
            JobState::Cancelled => CancelAnswer::AlreadyCancelled,
            JobState::Succeeded | JobState::Failed => CancelAnswer::TooLate(state),
        };
        transaction.commit().await?;
        Ok(answer)
    }

    /// Hides a job for good: nobody can ask for it any more, and its idempotency key is free.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn hide(&self, owner: &str, id: JobId) -> Result<DeleteAnswer, JobsError> {
        let mut transaction = self.begin().await?;
        let Some((seq, state)) = find(&mut transaction, owner, id).await? else {
            return Ok(DeleteAnswer::Unknown);
        };
        sqlx::query(
            "UPDATE jobs SET deleted = 1, cancel_requested = 1, idempotency_key = NULL WHERE seq = ?1",
        )
        .bind(seq)
        .execute(&mut *transaction)
        .await?;
        transaction.commit().await?;
        Ok(if state == JobState::Running {
            DeleteAnswer::Running { seq }
        } else {
            DeleteAnswer::Idle { seq }
        })
    }

    /// Whether a job was hidden.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn is_hidden(&self, seq: i64) -> Result<bool, JobsError> {
        let row: Option<(bool,)> = sqlx::query_as("SELECT deleted FROM jobs WHERE seq = ?1")
            .bind(seq)
            .fetch_optional(&self.pool)
            .await?;
        Ok(row.is_none_or(|(deleted,)| deleted))
    }

    /// Whether a job was cancelled or hidden.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn is_unwanted(&self, seq: i64) -> Result<bool, JobsError> {
        let row: Option<(bool, bool)> =
            sqlx::query_as("SELECT deleted, cancel_requested FROM jobs WHERE seq = ?1")
                .bind(seq)
                .fetch_optional(&self.pool)
                .await?;
        Ok(row.is_none_or(|(deleted, cancelled)| deleted || cancelled))
    }

    /// Erases a hidden job with its events.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn erase(&self, seq: i64) -> Result<(), JobsError> {
        sqlx::query("DELETE FROM jobs WHERE seq = ?1 AND deleted = 1").bind(seq).execute(&self.pool).await?;
        Ok(())
    }
}

/// Number and state of a job of an owner.
async fn find(
    transaction: &mut Transaction<'_, Sqlite>,
    owner: &str,
    id: JobId,
) -> Result<Option<(i64, JobState)>, JobsError> {
    let row: Option<(i64, String)> =
        sqlx::query_as("SELECT seq, state FROM jobs WHERE owner = ?1 AND id = ?2 AND deleted = 0")
            .bind(owner)
            .bind(id.to_string())
            .fetch_optional(&mut **transaction)
            .await?;
    row.map(|(seq, state)| {
        let known = JobState::from_name(&state).ok_or(JobsError::Corrupt { what: "state", value: state })?;
        Ok((seq, known))
    })
    .transpose()
}

/// Writes how far an attempt has come; false when the attempt is over.
async fn write_progress(
    transaction: &mut Transaction<'_, Sqlite>,
    seq: i64,
    attempt: u32,
    progress: &RunProgress,
) -> Result<bool, JobsError> {
    let result = sqlx::query(
        "UPDATE jobs SET phase = ?3, progress = ?4, step = ?5, expected_steps = ?6, simulated_time_s = ?7, eta_s = ?8
         WHERE seq = ?1 AND state = 'running' AND attempts = ?2",
    )
    .bind(seq)
    .bind(attempt)
    .bind(progress.phase.as_str())
    .bind(progress.progress)
    .bind(progress.step.cast_signed())
    .bind(progress.expected_steps.map(u64::cast_signed))
    .bind(progress.simulated_time_s)
    .bind(progress.eta_s)
    .execute(&mut **transaction)
    .await?;
    Ok(result.rows_affected() > 0)
}
