//! A new job, once.

use super::{JobRow, Store, add_event, event};
use crate::service::jobs::engine::SceneProblem;
use crate::service::jobs::{JobId, JobsError};
use serde_json::json;
use sqlx::{Sqlite, Transaction};

/// What a new job is made of.
#[derive(Clone, Debug)]
pub struct NewJob {
    /// Whose it is.
    pub owner: String,
    /// The client's name for the request, by which it may ask twice.
    pub idempotency_key: Option<String>,
    /// SHA-256 of the address and the body of the request, hexadecimal.
    pub body_sha256: String,
    /// The scene document as it came.
    pub scene: Vec<u8>,
    /// Name of the scene.
    pub name: String,
    /// Digest of the document and its meshes.
    pub content_hash: String,
    /// Simulated time to the end [s].
    pub end_time_s: f64,
    /// What is odd about the scene.
    pub warnings: Vec<SceneProblem>,
}

/// What became of a submission.
#[derive(Clone, Debug)]
pub enum Submitted {
    /// A new job.
    Created(Box<JobRow>),
    /// The job of an earlier request with the same key and the same body.
    Replayed(Box<JobRow>),
    /// The key belongs to a request with another body.
    KeyReused,
}

impl Store {
    /// The job of an earlier request with this key; `None` when there was none.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn replay(
        &self,
        owner: &str,
        key: &str,
        body_sha256: &str,
    ) -> Result<Option<Submitted>, JobsError> {
        let earlier: Option<(String, String)> =
            sqlx::query_as("SELECT id, body_sha256 FROM jobs WHERE owner = ?1 AND idempotency_key = ?2")
                .bind(owner)
                .bind(key)
                .fetch_optional(&self.pool)
                .await?;
        let Some((id, sha256)) = earlier else { return Ok(None) };
        if sha256 != body_sha256 {
            return Ok(Some(Submitted::KeyReused));
        }
        let id = id.parse().map_err(|_| JobsError::Corrupt { what: "job id", value: id })?;
        Ok(self.job(owner, id).await?.map(|row| Submitted::Replayed(Box::new(row))))
    }

    /// Keeps a new job. It is durable when this returns.
    ///
    /// # Errors
    /// `QueueFull` when `max_queued` jobs wait already; or when the store fails.
    pub async fn submit(&self, new: &NewJob, max_queued: u64) -> Result<Submitted, JobsError> {
        let id = JobId::now_v7();
        let mut transaction = self.begin().await?;
        // Two requests with one key may both have seen no job: the one that comes second sees it here.
        if let Some(key) = &new.idempotency_key
            && let Some(sha256) = body_of_key(&mut transaction, &new.owner, key).await?
        {
            drop(transaction);
            if sha256 != new.body_sha256 {
                return Ok(Submitted::KeyReused);
            }
            let earlier = self.replay(&new.owner, key, &new.body_sha256).await?;
            return earlier.ok_or(JobsError::Store(sqlx::Error::RowNotFound));
        }
        let (waiting,): (i64,) =
            sqlx::query_as("SELECT COUNT(*) FROM jobs WHERE state = 'queued' AND deleted = 0")
                .fetch_one(&mut *transaction)
                .await?;
        if waiting.cast_unsigned() >= max_queued {
            return Err(JobsError::QueueFull { waiting: waiting.cast_unsigned() });
        }
        let result = sqlx::query(
            "INSERT INTO jobs (id, owner, idempotency_key, body_sha256, scene, name, content_hash, end_time_s, warnings)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
        )
        .bind(id.to_string())
        .bind(&new.owner)
        .bind(&new.idempotency_key)
        .bind(&new.body_sha256)
        .bind(&new.scene)
        .bind(&new.name)
        .bind(&new.content_hash)
        .bind(new.end_time_s)
        .bind(serde_json::to_string(&new.warnings)?)
        .execute(&mut *transaction)
        .await?;
        let created = json!({ "state": "queued", "name": new.name });
        add_event(&mut transaction, result.last_insert_rowid(), event::QUEUED, &created).await?;
        transaction.commit().await?;
        let row = self.job(&new.owner, id).await?.ok_or(JobsError::Store(sqlx::Error::RowNotFound))?;
        Ok(Submitted::Created(Box::new(row)))
    }
}

/// Digest of the body that came with a key.
async fn body_of_key(
    transaction: &mut Transaction<'_, Sqlite>,
    owner: &str,
    key: &str,
) -> Result<Option<String>, JobsError> {
    let found: Option<(String,)> =
        sqlx::query_as("SELECT body_sha256 FROM jobs WHERE owner = ?1 AND idempotency_key = ?2")
            .bind(owner)
            .bind(key)
            .fetch_optional(&mut **transaction)
            .await?;
    Ok(found.map(|(sha256,)| sha256))
}
