//! What jobs leave, and what is old enough to be deleted.

use super::SqliteStore;
use super::read::job_id;
use crate::service::jobs::{JobId, JobsError};

impl SqliteStore {
    pub(super) async fn add_result(&self, seq: i64, key: &str) -> Result<(), JobsError> {
        sqlx::query("INSERT INTO results (job, key) VALUES (?1, ?2) ON CONFLICT DO NOTHING")
            .bind(seq)
            .bind(key)
            .execute(&self.pool)
            .await?;
        Ok(())
    }

    pub(super) async fn own_results(&self, seq: i64) -> Result<Vec<String>, JobsError> {
        let keys: Vec<(String,)> = sqlx::query_as(
            "SELECT key FROM results own WHERE job = ?1
                 AND NOT EXISTS (SELECT 1 FROM results other WHERE other.key = own.key AND other.job <> ?1)",
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
        let rows: Vec<(String, String)> = sqlx::query_as(
            "SELECT owner, id FROM jobs
             WHERE deleted = 0 AND finished_at IS NOT NULL AND state IN ('succeeded', 'failed', 'cancelled')
                 AND finished_at <= strftime('%Y-%m-%dT%H:%M:%fZ', 'now', ?1)
             ORDER BY finished_at LIMIT ?2",
        )
        .bind(days_ago(older_than_days))
        .bind(limit)
        .fetch_all(&self.pool)
        .await?;
        rows.into_iter().map(|(owner, id)| Ok((owner, job_id(id)?))).collect()
    }

    pub(super) async fn expired_meshes(
        &self,
        older_than_days: u32,
    ) -> Result<Vec<(String, String)>, JobsError> {
        let rows = sqlx::query_as(
            "SELECT owner, id FROM meshes WHERE created_at <= strftime('%Y-%m-%dT%H:%M:%fZ', 'now', ?1)",
        );
        Ok(rows.bind(days_ago(older_than_days)).fetch_all(&self.pool).await?)
    }

    /// Empties the write-ahead log, in which erased rows would still be found. While a statement reads the store, a part of it
    /// stays until the next time.
    pub(super) async fn empty_the_log(&self) -> Result<(), JobsError> {
        sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").fetch_optional(&self.pool).await?;
        Ok(())
    }
}

/// Modifier of SQLite's dates.
fn days_ago(days: u32) -> String {
    format!("-{days} days")
}
