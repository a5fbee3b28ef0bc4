//! Whose job is next, and its claim.

use super::read::claimed_of_row;
use super::{SqlStore, Write, add_event, set_aside};
use crate::service::jobs::JobsError;
use crate::service::jobs::store::{ClaimedJob, Event};
use sqlx::Row as _;

/// Owners with waiting jobs: first the one with the fewest running jobs, then the one whose last turn is longest ago, then the one whose
/// next job came first. Each owner is found by one look at the index, however many jobs wait.
macro_rules! owners_in_turn {
    () => {
        concat!(
            "WITH RECURSIVE waiting (owner) AS (
                 SELECT MIN(owner) FROM jobs",
            by_owner!(),
            " WHERE state = 'queued' AND deleted = 0
                 UNION ALL
                 SELECT (SELECT MIN(j.owner) FROM jobs j",
            by_owner!(),
            "
                         WHERE j.state = 'queued' AND j.deleted = 0 AND j.owner > w.owner)
                 FROM waiting w WHERE w.owner IS NOT NULL)
             SELECT w.owner, (SELECT n.seq FROM jobs n",
            by_owner!(),
            " WHERE n.owner = w.owner AND n.state = 'queued' AND n.deleted = 0
                       ORDER BY n.priority DESC, n.seq LIMIT 1) AS seq
             FROM waiting w WHERE w.owner IS NOT NULL
             ORDER BY (SELECT COUNT(*) FROM jobs r WHERE r.owner = w.owner AND r.state = 'running'),
                      COALESCE((SELECT o.turn FROM owners o WHERE o.owner = w.owner), 0), seq"
        )
    };
}

/// The next job of the owner `$1`.
macro_rules! next_of_owner {
    () => {
        concat!(
            "SELECT seq, id, owner, kind, memory_bytes, alone <> 0 AS alone, attempts, trace FROM jobs",
            by_owner!(),
            "
             WHERE owner = $1 AND state = 'queued' AND deleted = 0 ORDER BY priority DESC, seq LIMIT 1",
            locked_or_skipped!()
        )
    };
}

/// Gives a turn to the owner `$1`.
const TURN: &str =
    "INSERT INTO owners (owner, turn) VALUES ($1, (SELECT COALESCE(MAX(turn), 0) + 1 FROM owners))
     ON CONFLICT (owner) DO UPDATE SET turn = excluded.turn";

impl SqlStore {
    pub(super) async fn claim(&self, free_bytes: Option<u64>) -> Result<Option<ClaimedJob>, JobsError> {
        let mut transaction = self.begin().await?;
        let claimed = loop {
            let Some((seq, next)) = next(&mut transaction).await? else { break None };
            let next = match next {
                Ok(job) if !fits(&job, free_bytes) => break None,
                Ok(job) => with_document(&mut transaction, job).await?,
                unreadable => unreadable,
            };
            match next {
                Ok(job) => break Some(self.start(&mut transaction, job).await?),
                Err(error) => set_aside(&mut transaction, seq, &error).await?,
            }
        };
        // Ended now, not when the connection is used next: a job that does not fit would stay locked, and be overtaken.
        transaction.commit().await?;
        Ok(claimed)
    }

    /// Begins an attempt at a job.
    async fn start(&self, transaction: &mut Write<'_>, job: ClaimedJob) -> Result<ClaimedJob, JobsError> {
        sqlx::query(concat!(
            "UPDATE jobs SET state = 'running', phase = 'loading', attempts = $4, progress = 0, step = 0,
                 simulated_time_s = 0, expected_steps = NULL, eta_s = NULL, ",
            taken!(),
            ", started_at = ",
            now!(),
            "
             WHERE seq = $3"
        ))
        .bind(&self.worker)
        .bind(self.lease.as_secs_f64())
        .bind(job.seq)
        .bind(i64::from(job.attempt))
        .execute(&mut **transaction)
        .await?;
        sqlx::query(TURN).bind(&job.owner).execute(&mut **transaction).await?;
        add_event(transaction, job.seq, &Event::running(job.attempt)).await?;
        Ok(job)
    }
}

/// Number of the next job, which is locked, and the job, if it can be read. Jobs that other processes are claiming are left to them.
async fn next(
    transaction: &mut Write<'_>,
) -> Result<Option<(i64, Result<ClaimedJob, JobsError>)>, JobsError> {
    for of_owner in sqlx::query(owners_in_turn!()).fetch_all(&mut **transaction).await? {
        let owner: String = match of_owner.try_get("owner") {
            Ok(owner) => owner,
            Err(error) => return Ok(Some((of_owner.try_get("seq")?, Err(error.into())))),
        };
        let found = sqlx::query(next_of_owner!()).bind(owner).fetch_optional(&mut **transaction).await?;
        if let Some(row) = found {
            return Ok(Some((row.try_get("seq")?, claimed_of_row(&row))));
        }
    }
    Ok(None)
}

/// A job with its document, which is long: it is not read of one that does not fit.
async fn with_document(
    transaction: &mut Write<'_>,
    job: ClaimedJob,
) -> Result<Result<ClaimedJob, JobsError>, JobsError> {
    let row = sqlx::query("SELECT scene FROM jobs WHERE seq = $1").bind(job.seq);
    let document = row.fetch_one(&mut **transaction).await?.try_get("scene");
    Ok(document.map(|document| ClaimedJob { document, ..job }).map_err(JobsError::from))
}

/// Whether a run of a job fits into so many bytes beside others.
fn fits(job: &ClaimedJob, free_bytes: Option<u64>) -> bool {
    free_bytes.is_none_or(|free| !job.alone && job.memory_bytes <= free)
}
