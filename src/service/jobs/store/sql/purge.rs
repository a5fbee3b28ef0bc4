//! What jobs leave, and what is old enough to be deleted.

use super::SqlStore;
use super::read::job_id;
use crate::service::jobs::{JobId, JobsError};

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
        limit: u32,
    ) -> Result<Vec<(String, JobId)>, JobsError> {
        let rows: Vec<(String, String)> = sqlx::query_as(concat!(
            "SELECT owner, id FROM jobs
             WHERE deleted = 0 AND finished_at IS NOT NULL AND state IN ('succeeded', 'failed', 'cancelled')
                 AND finished_at <= ",
            days_ago!(),
            "
             ORDER BY finished_at LIMIT $2"
        ))
        .bind(i64::from(older_than_days))
        .bind(i64::from(limit))
        .fetch_all(&self.pool)
        .await?;
        rows.into_iter().map(|(owner, id)| Ok((owner, job_id(id)?))).collect()
    }

    pub(super) async fn expired_meshes(
        &self,
        older_than_days: u32,
    ) -> Result<Vec<(String, String)>, JobsError> {
        let rows = sqlx::query_as(concat!("SELECT owner, id FROM meshes WHERE created_at <= ", days_ago!()));
        Ok(rows.bind(i64::from(older_than_days)).fetch_all(&self.pool).await?)
    }
}
