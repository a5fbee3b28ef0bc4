//! State changes of jobs, from the queue to the end.

use super::read::job_id;
use super::{Row, SqlStore, Write, add_event, attempts_of, possible_attempts, set_aside};
use crate::service::jobs::store::{
    CancelAnswer, DeleteAnswer, Event, JobEnd, Orphan, OwnerRequest, Requeued,
};
use crate::service::jobs::{JobId, JobState, JobsError, Progress};
use crate::step::Ending;
use sqlx::Row as _;

impl SqlStore {
    pub(super) async fn record_progress(
        &self,
        seq: i64,
        attempt: u32,
        progress: &Progress,
    ) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        if self.write_progress(&mut transaction, seq, attempt, progress).await? {
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
        let running: Option<(i64,)> = sqlx::query_as(concat!(
            "SELECT seq FROM jobs WHERE seq = $1 AND state = 'running' AND attempts = $2 AND worker = $3",
            locked!()
        ))
        .bind(seq)
        .bind(i64::from(attempt))
        .bind(&self.worker)
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
            self.write_progress(&mut transaction, seq, attempt, progress).await?;
        }
        let failure = end.ending.failure().map(serde_json::to_string).transpose()?;
        let headline = end.headline.as_ref().map(serde_json::to_string).transpose()?;
        let result = sqlx::query(concat!(
            "UPDATE jobs SET state = $4, phase = 'done', eta_s = NULL, failure = $5, summary = $6,
                 recording_bytes = $7, recording_sha256 = $8, recording_complete = $9, recording_attempt = $2, kept_bytes = length(scene) + $10,
                 withheld = $11, headline = $12,
                 progress = CASE WHEN $4 = 'succeeded' THEN 1 ELSE progress END, finished_at = ",
            now!(),
            "
             WHERE seq = $1 AND state = 'running' AND attempts = $2 AND worker = $3"
        ))
        .bind(seq)
        .bind(i64::from(attempt))
        .bind(&self.worker)
        .bind(JobState::of(&end.ending).as_str())
        .bind(failure)
        .bind(&end.summary)
        .bind(end.recording.as_ref().map(|r| r.bytes.cast_signed()))
        .bind(end.recording.as_ref().map(|r| r.sha256.as_str()))
        .bind(end.recording.as_ref().map(|r| r.complete))
        .bind(end.kept_bytes().cast_signed())
        .bind(end.is_withheld())
        .bind(headline)
        .execute(&mut *transaction)
        .await?;
        // An attempt that is over changes nothing. That it is has to be durable.
        if result.rows_affected() == 0 {
            transaction.commit().await?;
            return Ok(false);
        }
        add_event(&mut transaction, seq, &Event::ended(&end.ending)).await?;
        transaction.commit().await?;
        Ok(true)
    }

    pub(super) async fn requeue(&self, seq: i64, attempt: u32, why: Requeued) -> Result<bool, JobsError> {
        let mut transaction = self.begin().await?;
        let result = sqlx::query(
            "UPDATE jobs SET state = 'queued', phase = 'waiting', attempts = attempts - $4, started_at = NULL, eta_s = NULL,
                 progress = 0, step = 0, simulated_time_s = 0, alone = CASE WHEN $5 THEN 1 ELSE alone END
             WHERE seq = $1 AND state = 'running' AND attempts = $2 AND worker = $3",
        )
        .bind(seq)
        .bind(i64::from(attempt))
        .bind(&self.worker)
        .bind(i64::from(why.attempts_forgiven()))
        .bind(why == Requeued::ProcessLost)
        .execute(&mut *transaction)
        .await?;
        if result.rows_affected() == 0 {
            transaction.commit().await?;
            return Ok(false);
        }
        add_event(&mut transaction, seq, &Event::requeued(why)).await?;
        transaction.commit().await?;
        Ok(true)
    }

    pub(super) async fn cancel(&self, owner: &str, id: JobId) -> Result<CancelAnswer, JobsError> {
        let mut transaction = self.begin().await?;
        let Some((seq, state, _)) = find(&mut transaction, owner, id).await? else {
            return Ok(CancelAnswer::Unknown);
        };
        let answer = match state {
            JobState::Queued => {
                sqlx::query(concat!(
                    "UPDATE jobs SET state = 'cancelled', phase = 'done', cancel_requested = 1, finished_at = ",
                    now!(),
                    " WHERE seq = $1"
                ))
                .bind(seq)
                .execute(&mut *transaction)
                .await?;
                add_event(&mut transaction, seq, &Event::ended(&Ending::Cancelled)).await?;
                CancelAnswer::Cancelled { seq }
            }
            JobState::Running => {
                sqlx::query("UPDATE jobs SET cancel_requested = 1 WHERE seq = $1")
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
        let Some((seq, state, attempts)) = find(&mut transaction, owner, id).await? else {
            return Ok(DeleteAnswer::Unknown);
        };
        sqlx::query(
            "UPDATE jobs SET deleted = 1, cancel_requested = 1, idempotency_key = NULL WHERE seq = $1",
        )
        .bind(seq)
        .execute(&mut *transaction)
        .await?;
        // Whoever hides a job that no one has erases it, unless this process is lost.
        if state != JobState::Running {
            sqlx::query(concat!("UPDATE jobs SET ", taken!(), " WHERE seq = $3"))
                .bind(&self.worker)
                .bind(self.lease.as_secs_f64())
                .bind(seq)
                .execute(&mut *transaction)
                .await?;
        }
        transaction.commit().await?;
        Ok(if state == JobState::Running {
            DeleteAnswer::Running { seq }
        } else {
            DeleteAnswer::Idle { seq, attempts }
        })
    }

    pub(super) async fn request(&self, seq: i64) -> Result<OwnerRequest, JobsError> {
        let row: Option<(bool, bool)> =
            sqlx::query_as("SELECT deleted <> 0, cancel_requested <> 0 FROM jobs WHERE seq = $1")
                .bind(seq)
                .fetch_optional(&self.pool)
                .await?;
        Ok(row.map_or(OwnerRequest::Deletion, |(deleted, cancelled)| OwnerRequest::of(deleted, cancelled)))
    }

    pub(super) async fn orphans(&self) -> Result<Vec<Orphan>, JobsError> {
        let mut transaction = self.begin().await?;
        let rows = sqlx::query(concat!(
            "UPDATE jobs SET ",
            taken!(),
            " WHERE (state = 'running' OR deleted = 1) AND ",
            is_lost!(),
            "
             RETURNING seq, id, attempts, deleted <> 0 AS deleted, cancel_requested <> 0 AS cancelled"
        ))
        .bind(&self.worker)
        .bind(self.lease.as_secs_f64())
        .fetch_all(&mut *transaction)
        .await?;
        let mut orphans = Vec::new();
        for row in rows {
            match orphan_of_row(&row) {
                Ok(orphan) => orphans.push(orphan),
                Err(error) => set_aside(&mut transaction, row.try_get("seq")?, &error).await?,
            }
        }
        transaction.commit().await?;
        orphans.sort_unstable_by_key(|orphan| orphan.seq);
        Ok(orphans)
    }

    pub(super) async fn erase(&self, seq: i64) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        sqlx::query("DELETE FROM jobs WHERE seq = $1 AND deleted = 1")
            .bind(seq)
            .execute(&mut *transaction)
            .await?;
        transaction.commit().await?;
        self.forget_erased().await
    }

    /// Writes the progress of an attempt; false if the attempt is over.
    async fn write_progress(
        &self,
        transaction: &mut Write<'_>,
        seq: i64,
        attempt: u32,
        progress: &Progress,
    ) -> Result<bool, JobsError> {
        let result = sqlx::query(
            "UPDATE jobs SET phase = $4, progress = $5, step = $6, expected_steps = $7, simulated_time_s = $8, eta_s = $9
             WHERE seq = $1 AND state = 'running' AND attempts = $2 AND worker = $3",
        )
        .bind(seq)
        .bind(i64::from(attempt))
        .bind(&self.worker)
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
}

/// Number, state and attempts of a job of an owner, to be changed or deleted.
async fn find(
    transaction: &mut Write<'_>,
    owner: &str,
    id: JobId,
) -> Result<Option<(i64, JobState, u32)>, JobsError> {
    let row = sqlx::query(concat!(
        "SELECT seq, state, attempts FROM jobs WHERE owner = $1 AND id = $2 AND deleted = 0",
        locked!()
    ))
    .bind(owner)
    .bind(id.to_string())
    .fetch_optional(&mut **transaction)
    .await?;
    row.map(|row| {
        let state: String = row.try_get("state")?;
        let known = JobState::from_name(&state).ok_or(JobsError::Corrupt { what: "state", value: state })?;
        Ok((row.try_get("seq")?, known, possible_attempts(&row)))
    })
    .transpose()
}

fn orphan_of_row(row: &Row) -> Result<Orphan, JobsError> {
    let request = OwnerRequest::of(row.try_get("deleted")?, row.try_get("cancelled")?);
    let attempt = match request {
        OwnerRequest::Deletion => possible_attempts(row),
        _ => attempts_of(row.try_get("attempts")?)?,
    };
    Ok(Orphan { seq: row.try_get("seq")?, id: job_id(row.try_get("id")?)?, attempt, request })
}
