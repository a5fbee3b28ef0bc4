//! What jobs leave, and what is old enough to be deleted.

use super::read::job_id;
use super::{Row, SqlStore};
use crate::service::jobs::store::Expired;
use crate::service::jobs::{JobId, JobsError};
use sqlx::Row as _;

impl SqlStore {
    pub(super) async fn add_result(&self, seq: i64, key: &str) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        sqlx::query("INSERT INTO results (job, key) VALUES ($1, $2) ON CONFLICT DO NOTHING")
            .bind(seq)
            .bind(key)
            .execute(&mut *transaction)
            .await?;
        transaction.commit().await?;
        Ok(())
    }

    pub(super) async fn own_results(&self, seq: i64) -> Result<Vec<String>, JobsError> {
        let keys: Vec<(String,)> = sqlx::query_as(
            "SELECT key FROM results own WHERE job = $1
                 AND NOT EXISTS (SELECT 1 FROM results other WHERE other.key = own.key AND other.job <> $1)",
        )
        .bind(seq)
        .fetch_all(&self.pool)
        .await?;
        Ok(keys.into_iter().map(|(key,)| key).collect())
    }

    pub(super) async fn expired_jobs(
        &self,
        older_than_days: u32,
        after: i64,
        limit: u32,
    ) -> Result<(Expired<JobId>, Option<i64>), JobsError> {
        let rows = sqlx::query(concat!(
            "SELECT seq, owner, id FROM jobs
             WHERE deleted = 0 AND state IN ('succeeded', 'failed', 'cancelled')
                 AND ($1 = 0 OR finished_at <= ",
            days_ago!(),
            ") AND seq > $2 ORDER BY seq LIMIT $3"
        ))
        .bind(i64::from(older_than_days))
        .bind(after)
        .bind(i64::from(limit))
        .fetch_all(&self.pool)
        .await?;
        let last = rows.last().map(|row| row.try_get("seq")).transpose()?;
        Ok((expired(&rows, job_id), last))
    }

    pub(super) async fn expired_meshes(&self, older_than_days: u32) -> Result<Expired<String>, JobsError> {
        let rows =
            sqlx::query(concat!("SELECT owner, id FROM meshes WHERE $1 = 0 OR created_at <= ", days_ago!()));
        let rows = rows.bind(i64::from(older_than_days)).fetch_all(&self.pool).await?;
        Ok(expired(&rows, Ok))
    }
}

/// Owners and ids of rows. Those that cannot be read are counted, and do not keep the others.
fn expired<Id>(rows: &[Row], id_of: impl Fn(String) -> Result<Id, JobsError>) -> Expired<Id> {
    let mut expired = Expired { found: Vec::new(), unreadable: 0 };
    for row in rows {
        let id = row.try_get("id").map_err(JobsError::from).and_then(&id_of);
        match id.and_then(|id| Ok((row.try_get("owner")?, id))) {
            Ok(found) => expired.found.push(found),
            Err(error) => {
                tracing::error!(seq = row.try_get::<i64, _>("seq").ok(), %error, "what is too old cannot be read");
                expired.unreadable += 1;
            }
        }
    }
    expired
}
