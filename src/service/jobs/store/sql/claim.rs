//! Whose job is next, and its claim.

use super::read::{job_id, kind_of_name};
use super::{SqlStore, Write, add_event, attempts_of};
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
             SELECT w.owner FROM waiting w WHERE w.owner IS NOT NULL
             ORDER BY (SELECT COUNT(*) FROM jobs r WHERE r.owner = w.owner AND r.state = 'running'),
                      COALESCE((SELECT o.turn FROM owners o WHERE o.owner = w.owner), 0),
                      (SELECT n.seq FROM jobs n",
            by_owner!(),
            " WHERE n.owner = w.owner AND n.state = 'queued' AND n.deleted = 0
                       ORDER BY n.priority DESC, n.seq LIMIT 1)"
        )
    };
}

/// The next job of the owner `$1`, and whether its run fits into `$2` bytes beside others.
macro_rules! next_of_owner {
    () => {
        concat!(
            "SELECT seq, $2 IS NULL OR (alone = 0 AND memory_bytes <= $2) FROM jobs",
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
        let Some((seq, owner)) = next(&mut transaction, free_bytes).await? else {
            // Ended now, not when the connection is used next: a job that does not fit would stay locked, and be overtaken.
            transaction.commit().await?;
            return Ok(None);
        };
        let row = sqlx::query(concat!(
            "UPDATE jobs SET state = 'running', phase = 'loading', attempts = attempts + 1, progress = 0, step = 0,
                 simulated_time_s = 0, expected_steps = NULL, eta_s = NULL, ", taken!(), ", started_at = ", now!(), "
             WHERE seq = $3
             RETURNING id, kind, scene, attempts, memory_bytes, alone <> 0 AS alone, trace"
        ))
        .bind(&self.worker)
        .bind(self.lease.as_secs_f64())
        .bind(seq)
        .fetch_one(&mut *transaction)
        .await?;
        let attempt = attempts_of(row.try_get("attempts")?)?;
        sqlx::query(TURN).bind(&owner).execute(&mut *transaction).await?;
        add_event(&mut transaction, seq, &Event::running(attempt)).await?;
        transaction.commit().await?;
        Ok(Some(ClaimedJob {
            seq,
            id: job_id(row.try_get("id")?)?,
            owner,
            kind: kind_of_name(row.try_get("kind")?)?,
            document: row.try_get("scene")?,
            memory_bytes: row.try_get::<i64, _>("memory_bytes")?.cast_unsigned(),
            alone: row.try_get("alone")?,
            attempt,
            trace: row.try_get("trace")?,
        }))
    }
}

/// Number and owner of the next job, which is locked, if its run fits. Jobs that other processes are claiming are left to them.
async fn next(
    transaction: &mut Write<'_>,
    free_bytes: Option<u64>,
) -> Result<Option<(i64, String)>, JobsError> {
    let owners: Vec<(String,)> = sqlx::query_as(owners_in_turn!()).fetch_all(&mut **transaction).await?;
    for (owner,) in owners {
        let found: Option<(i64, bool)> = sqlx::query_as(next_of_owner!())
            .bind(&owner)
            .bind(free_bytes.map(|bytes| i64::try_from(bytes).unwrap_or(i64::MAX)))
            .fetch_optional(&mut **transaction)
            .await?;
        if let Some((seq, fits)) = found {
            return Ok(fits.then_some((seq, owner)));
        }
    }
    Ok(None)
}
