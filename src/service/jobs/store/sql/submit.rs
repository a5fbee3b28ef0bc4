//! Submission of a job, at most once per key.

use super::read::{job_id, job_of_row};
use super::{Db, SqlStore, Write, add_event};
use crate::service::clock::new_id;
use crate::service::jobs::JobsError;
use crate::service::jobs::store::{Event, Job, Kept, NewJob, Quotas, Submitted};
use sqlx::Executor;

impl SqlStore {
    pub(super) async fn kept(&self, owner: &str) -> Result<Kept, JobsError> {
        kept_in(&self.pool, owner).await
    }

    pub(super) async fn replay(
        &self,
        owner: &str,
        key: &str,
        body_sha256: &str,
    ) -> Result<Option<Submitted>, JobsError> {
        let earlier: Option<(String, String)> =
            sqlx::query_as("SELECT id, body_sha256 FROM jobs WHERE owner = $1 AND idempotency_key = $2")
                .bind(owner)
                .bind(key)
                .fetch_optional(&self.pool)
                .await?;
        let Some((id, sha256)) = earlier else { return Ok(None) };
        if sha256 != body_sha256 {
            return Ok(Some(Submitted::KeyReused));
        }
        let id = job_id(id)?;
        Ok(self.job(owner, id).await?.map(|row| Submitted::Replayed(Box::new(row))))
    }

    pub(super) async fn submit(&self, new: &NewJob, quotas: Quotas) -> Result<Submitted, JobsError> {
        let id = new_id();
        let mut transaction = self.begin().await?;
        let inserted: Option<(i64,)> = sqlx::query_as(
            "INSERT INTO jobs (id, owner, idempotency_key, body_sha256, scene, name, content_hash, end_time_s, warnings, kind, memory_bytes,
                  priority, trace, kept_bytes)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, length($5))
             ON CONFLICT (owner, idempotency_key) WHERE idempotency_key IS NOT NULL DO NOTHING RETURNING seq",
        )
        .bind(id.to_string())
        .bind(&new.owner)
        .bind(&new.idempotency_key)
        .bind(&new.body_sha256)
        .bind(&new.document)
        .bind(&new.name)
        .bind(&new.content_hash)
        .bind(new.end_time_s)
        .bind(serde_json::to_string(&new.warnings)?)
        .bind(new.kind.as_str())
        .bind(new.memory_bytes.cast_signed())
        .bind(new.priority.number())
        .bind(&new.trace)
        .fetch_optional(&mut *transaction)
        .await?;
        // Two requests with one key may both have found no job: the second one finds it here, when it is durable.
        let Some((seq,)) = inserted else {
            transaction.commit().await?;
            let key = new.idempotency_key.as_deref().unwrap_or_default();
            let earlier = self.replay(&new.owner, key, &new.body_sha256).await?;
            return Ok(earlier.ok_or(sqlx::Error::RowNotFound)?);
        };
        let position = within_quotas(&mut transaction, new, quotas).await?;
        for mesh in &new.meshes {
            let found: Option<(i64,)> =
                sqlx::query_as(concat!("SELECT bytes FROM meshes WHERE owner = $1 AND id = $2", shared!()))
                    .bind(&new.owner)
                    .bind(mesh)
                    .fetch_optional(&mut *transaction)
                    .await?;
            if found.is_none() {
                return Ok(Submitted::MeshGone { id: mesh.clone() });
            }
        }
        add_event(&mut transaction, seq, &Event::queued(&new.name)).await?;
        let row = sqlx::query("SELECT * FROM job_rows WHERE seq = $1")
            .bind(seq)
            .fetch_one(&mut *transaction)
            .await?;
        let job = Job { queue_position: Some(position), ..job_of_row(&row)? };
        transaction.commit().await?;
        Ok(Submitted::Created(Box::new(job)))
    }
}

/// Checks the quotas with a job that was inserted, and gives its position among the waiting jobs of its owner.
async fn within_quotas(transaction: &mut Write<'_>, new: &NewJob, quotas: Quotas) -> Result<u64, JobsError> {
    let (all, of_owner, position): (i64, i64, i64) = sqlx::query_as(
        "SELECT (SELECT COALESCE(MAX(n), 0) FROM state_counts WHERE state = 'queued'), CAST(COALESCE(SUM(n), 0) AS BIGINT),
             CAST(COALESCE(SUM(CASE WHEN priority >= $2 THEN n END), 0) AS BIGINT)
         FROM waiting_counts WHERE owner = $1",
    )
    .bind(&new.owner)
    .bind(new.priority.number())
    .fetch_one(&mut **transaction)
    .await?;
    quotas.check_waiting(all.cast_unsigned(), of_owner.cast_unsigned())?;
    check_kept(transaction, &new.owner, quotas).await?;
    Ok(position.cast_unsigned())
}

/// Checks what an owner keeps.
pub(super) async fn check_kept(
    transaction: &mut Write<'_>,
    owner: &str,
    quotas: Quotas,
) -> Result<(), JobsError> {
    if quotas.let_owners_keep_all() {
        return Ok(());
    }
    quotas.check_kept(kept_in(&mut **transaction, owner).await?)
}

/// What an owner keeps.
async fn kept_in(database: impl Executor<'_, Database = Db>, owner: &str) -> Result<Kept, JobsError> {
    let (jobs, bytes): (i64, i64) = sqlx::query_as(
        "SELECT COUNT(*), CAST(COALESCE(SUM(kept_bytes), 0) + (SELECT COALESCE(SUM(bytes), 0) FROM meshes WHERE owner = $1) AS BIGINT)
         FROM jobs WHERE owner = $1",
    )
    .bind(owner)
    .fetch_one(database)
    .await?;
    Ok(Kept { jobs: jobs.cast_unsigned(), bytes: bytes.cast_unsigned() })
}
