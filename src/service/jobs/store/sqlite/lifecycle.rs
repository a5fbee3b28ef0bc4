//! State changes of jobs, from the queue to the end.

use super::read::{job_id, kind_of_name};
use super::{SqliteStore, Write, add_event};
use crate::service::jobs::store::{
    CancelAnswer, ClaimedJob, DeleteAnswer, Event, JobEnd, Orphan, OwnerRequest, Requeued,
};
use crate::service::jobs::{JobId, JobState, JobsError, Progress};
use crate::step::Ending;
use sqlx::Row as _;

impl SqliteStore {
    pub(super) async fn claim(&self, free_bytes: Option<u64>) -> Result<Option<ClaimedJob>, JobsError> {
        let mut transaction = self.begin().await?;
        let row = sqlx::query(
            "UPDATE jobs SET state = 'running', phase = 'loading', attempts = attempts + 1, progress = 0, step = 0,
                 simulated_time_s = 0, expected_steps = NULL, eta_s = NULL,
                 started_at = strftime('%Y-%m-%dT%H:%M:%fZ', 'now')
             WHERE seq = (SELECT seq FROM jobs WHERE state = 'queued' AND deleted = 0 ORDER BY seq LIMIT 1)
                 AND (?1 IS NULL OR (alone = 0 AND memory_bytes <= ?1))
             RETURNING seq, id, owner, kind, scene, attempts, memory_bytes, alone",
        )
        .bind(free_bytes.map(|bytes| i64::try_from(bytes).unwrap_or(i64::MAX)))
        .fetch_optional(&mut *transaction)
        .await?;
        let Some(row) = row else { return Ok(None) };
        let (seq, attempt) = (row.try_get("seq")?, row.try_get("attempts")?);
        add_event(&mut transaction, seq, &Event::running(attempt)).await?;
        transaction.commit().await?;
        let id: String = row.try_get("id")?;
        Ok(Some(ClaimedJob {
            seq,
            id: job_id(id)?,
            owner: row.try_get("owner")?,
            kind: kind_of_name(row.try_get("kind")?)?,
            document: row.try_get("scene")?,
            memory_bytes: row.try_get::<i64, _>("memory_bytes")?.cast_unsigned(),
            alone: row.try_get("alone")?,
            attempt,
        }))
    }

    pub(super) async fn record_progress(
        &self,
        seq: i64,
        attempt: u32,
        progress: &Progress,
    ) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        if write_progress(&mut transaction, seq, attempt, progress).await? {
            add_event(&mut transaction, seq, &Event::progress(progress)?).await?;
            transaction.commit().await?;
        }
        Ok(())
    }

    pub(super) async fn record_event(
        &self,
        seq: i64,
        attempt: u32,
        event: &Event<'_>,
    ) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        let running: Option<(i64,)> =
            sqlx::query_as("SELECT seq FROM jobs WHERE seq = ?1 AND state = 'running' AND attempts = ?2")
                .bind(seq)
                .bind(attempt)
                .fetch_optional(&mut *transaction)
                .await?;
        if running.is_some() {
            add_event(&mut transaction, seq, event).await?;
            transaction.commit().await?;
        }
        Ok(())
    }

    pub(super) async fn finish(&self, seq: i64, attempt: u32, end: &JobEnd) -> Result<bool, JobsError> {
        let mut transaction = self.begin().await?;
        if let Some(progress) = &end.progress {
            write_progress(&mut transaction, seq, attempt, progress).await?;
        }
        let failure = end.ending.failure().map(serde_json::to_string).transpose()?;
        let result = sqlx::query(
            "UPDATE jobs SET state = ?3, phase = 'done', eta_s = NULL, failure = ?4, summary = ?5,
                 recording_bytes = ?6, recording_sha256 = ?7, recording_complete = ?8,
                 progress = CASE WHEN ?3 = 'succeeded' THEN 1 ELSE progress END,
                 finished_at = strftime('%Y-%m-%dT%H:%M:%fZ', 'now')
             WHERE seq = ?1 AND state = 'running' AND attempts = ?2",
        )
        .bind(seq)
        .bind(attempt)
        .bind(JobState::of(&end.ending).as_str())
        .bind(failure)
        .bind(&end.summary)
        .bind(end.recording.as_ref().map(|r| r.bytes.cast_signed()))
        .bind(end.recording.as_ref().map(|r| r.sha256.as_str()))
        .bind(end.recording.as_ref().map(|r| r.complete))
        .execute(&mut *transaction)
        .await?;
        // An attempt that is over changes nothing.
        if result.rows_affected() == 0 {
            return Ok(false);
        }
        add_event(&mut transaction, seq, &Event::ended(&end.ending)).await?;
        transaction.commit().await?;
        Ok(true)
    }

    pub(super) async fn requeue(&self, seq: i64, attempt: u32, why: Requeued) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        let result = sqlx::query(
            "UPDATE jobs SET state = 'queued', phase = 'waiting', attempts = attempts - ?3, started_at = NULL, eta_s = NULL,
                 progress = 0, step = 0, simulated_time_s = 0, alone = MAX(alone, ?4)
             WHERE seq = ?1 AND state = 'running' AND attempts = ?2",
        )
        .bind(seq)
        .bind(attempt)
        .bind(why.attempts_forgiven())
        .bind(why == Requeued::ProcessLost)
        .execute(&mut *transaction)
        .await?;
        if result.rows_affected() > 0 {
            add_event(&mut transaction, seq, &Event::requeued(why)).await?;
            transaction.commit().await?;
        }
        Ok(())
    }

    pub(super) async fn cancel(&self, owner: &str, id: JobId) -> Result<CancelAnswer, JobsError> {
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
                add_event(&mut transaction, seq, &Event::ended(&Ending::Cancelled)).await?;
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

    pub(super) async fn hide(&self, owner: &str, id: JobId) -> Result<DeleteAnswer, JobsError> {
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

    pub(super) async fn request(&self, seq: i64) -> Result<OwnerRequest, JobsError> {
        let row: Option<(bool, bool)> =
            sqlx::query_as("SELECT deleted, cancel_requested FROM jobs WHERE seq = ?1")
                .bind(seq)
                .fetch_optional(&self.pool)
                .await?;
        Ok(row.map_or(OwnerRequest::Deletion, |(deleted, cancelled)| request_of(deleted, cancelled)))
    }

    pub(super) async fn orphans(&self) -> Result<Vec<Orphan>, JobsError> {
        let rows: Vec<(i64, String, u32, bool, bool)> = sqlx::query_as(
            "SELECT seq, id, attempts, deleted, cancel_requested FROM jobs WHERE state = 'running' OR deleted = 1
             ORDER BY seq",
        )
        .fetch_all(&self.pool)
        .await?;
        let mut orphans = Vec::new();
        for (seq, id, attempt, deleted, cancel_requested) in rows {
            match job_id(id) {
                Ok(id) => {
                    orphans.push(Orphan { seq, id, attempt, request: request_of(deleted, cancel_requested) });
                }
                // The others are recovered, and this one is found by `contuse doctor`.
                Err(error) => tracing::error!(seq, %error, "a job cannot be read"),
            }
        }
        Ok(orphans)
    }

    pub(super) async fn erase(&self, seq: i64) -> Result<(), JobsError> {
        sqlx::query("DELETE FROM jobs WHERE seq = ?1 AND deleted = 1").bind(seq).execute(&self.pool).await?;
        self.empty_the_log().await
    }
}

fn request_of(deleted: bool, cancel_requested: bool) -> OwnerRequest {
    match (deleted, cancel_requested) {
        (true, _) => OwnerRequest::Deletion,
        (false, true) => OwnerRequest::Stop,
        (false, false) => OwnerRequest::Result,
    }
}

/// Number and state of a job of an owner.
async fn find(
    transaction: &mut Write<'_>,
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

/// Writes the progress of an attempt; false if the attempt is over.
async fn write_progress(
    transaction: &mut Write<'_>,
    seq: i64,
    attempt: u32,
    progress: &Progress,
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
