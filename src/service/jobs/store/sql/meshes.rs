//! Owners of uploaded meshes, and references to blobs.

use super::read::job_id;
use super::submit::check_kept;
use super::{Row, SqlStore, attempts_of, possible_attempts};
use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use crate::service::jobs::JobsError;
use crate::service::jobs::store::{KnownBlobs, MeshDeletion, Quotas};
use crate::service::meshes::StoredMesh;
use crate::service::shelves::{mesh_name, recording_name, recording_names, result_name};
use sqlx::Row as _;

impl SqlStore {
    pub(super) async fn add_mesh(
        &self,
        owner: &str,
        id: &str,
        format: MeshFormat,
        bytes: u64,
        report: &MeshReport,
        quotas: Quotas,
    ) -> Result<bool, JobsError> {
        let mut transaction = self.begin().await?;
        let result = sqlx::query(
            "INSERT INTO meshes (id, owner, format, bytes, report) VALUES ($1, $2, $3, $4, $5) ON CONFLICT DO NOTHING",
        )
        .bind(id)
        .bind(owner)
        .bind(format.extension())
        .bind(bytes.cast_signed())
        .bind(serde_json::to_string(report)?)
        .execute(&mut *transaction)
        .await?;
        let is_new = result.rows_affected() > 0;
        if is_new {
            check_kept(&mut transaction, owner, quotas).await?;
        }
        transaction.commit().await?;
        Ok(is_new)
    }

    pub(super) async fn blobs(&self) -> Result<KnownBlobs, JobsError> {
        let mut known = KnownBlobs::default();
        let jobs = sqlx::query(
            "SELECT seq, id, attempts, recording_sha256 IS NOT NULL AND deleted = 0 AS is_recorded, recording_attempt FROM jobs",
        );
        for row in jobs.fetch_all(&self.pool).await? {
            if let Err(error) = add_recordings(&mut known, &row) {
                known.doubt(row.try_get("seq").ok(), &error);
            }
        }
        let meshes = sqlx::query("SELECT DISTINCT id, format FROM meshes");
        for row in meshes.fetch_all(&self.pool).await? {
            match mesh_name_of_row(&row) {
                Ok(name) => drop(known.names.insert(name)),
                Err(error) => known.doubt(None, &error),
            }
        }
        let results = sqlx::query("SELECT DISTINCT key FROM results");
        for row in results.fetch_all(&self.pool).await? {
            match row.try_get::<String, _>("key") {
                Ok(key) => drop(known.names.insert(result_name(&key))),
                Err(error) => known.doubt(None, &error.into()),
            }
        }
        Ok(known)
    }

    pub(super) async fn mesh(&self, owner: &str, id: &str) -> Result<Option<StoredMesh>, JobsError> {
        let row = sqlx::query(
            "SELECT id, format, bytes, report, created_at FROM meshes WHERE owner = $1 AND id = $2",
        );
        row.bind(owner).bind(id).fetch_optional(&self.pool).await?.as_ref().map(mesh_of_row).transpose()
    }

    pub(super) async fn meshes(
        &self,
        owner: &str,
        after: &str,
        limit: u32,
    ) -> Result<Vec<StoredMesh>, JobsError> {
        let rows = sqlx::query(
            "SELECT id, format, bytes, report, created_at FROM meshes WHERE owner = $1 AND id > $2 ORDER BY id LIMIT $3",
        );
        let rows = rows.bind(owner).bind(after).bind(i64::from(limit)).fetch_all(&self.pool).await?;
        let reported = |error: &JobsError| tracing::error!(%error, "a mesh cannot be read");
        let mut meshes: Vec<_> =
            rows.iter().filter_map(|row| mesh_of_row(row).inspect_err(reported).ok()).collect();
        // One that cannot be read does not hide the others.
        let lacking = limit - u32::try_from(meshes.len()).unwrap_or(limit);
        if let Some(last) = rows.last().filter(|_| lacking > 0 && rows.len() == limit as usize) {
            meshes.extend(Box::pin(self.meshes(owner, last.try_get("id")?, lacking)).await?);
        }
        Ok(meshes)
    }

    pub(super) async fn delete_mesh(&self, owner: &str, id: &str) -> Result<MeshDeletion, JobsError> {
        let mut transaction = self.begin().await?;
        // Locked first: a job that is being accepted has locked its meshes before, and is seen below, or finds this one gone.
        let mesh: Option<(String,)> =
            sqlx::query_as(concat!("SELECT format FROM meshes WHERE owner = $1 AND id = $2", locked!()))
                .bind(owner)
                .bind(id)
                .fetch_optional(&mut *transaction)
                .await?;
        let Some((format,)) = mesh else { return Ok(MeshDeletion::Unknown) };
        let user: Option<(String,)> = sqlx::query_as(concat!(
            "SELECT id FROM jobs WHERE state IN ('queued', 'running') AND deleted = 0 AND owner = $1 AND ",
            scene_contains!(),
            " LIMIT 1"
        ))
        .bind(owner)
        .bind(id)
        .fetch_optional(&mut *transaction)
        .await?;
        if let Some((job,)) = user {
            return Ok(MeshDeletion::InUse { job: job_id(job)? });
        }
        sqlx::query("DELETE FROM meshes WHERE owner = $1 AND id = $2")
            .bind(owner)
            .bind(id)
            .execute(&mut *transaction)
            .await?;
        let (left,): (i64,) = sqlx::query_as("SELECT COUNT(*) FROM meshes WHERE id = $1 AND format = $2")
            .bind(id)
            .bind(&format)
            .fetch_one(&mut *transaction)
            .await?;
        transaction.commit().await?;
        self.forget_erased().await?;
        let unowned = if left == 0 { Some(mesh_format(format)?) } else { None };
        Ok(MeshDeletion::Deleted { unowned })
    }

    pub(super) async fn has_owner(&self, id: &str, format: MeshFormat) -> Result<bool, JobsError> {
        let (owners,): (i64,) = sqlx::query_as("SELECT COUNT(*) FROM meshes WHERE id = $1 AND format = $2")
            .bind(id)
            .bind(format.extension())
            .fetch_one(&self.pool)
            .await?;
        Ok(owners > 0)
    }
}

/// Adds the names of the recordings that a job has or may have.
fn add_recordings(known: &mut KnownBlobs, row: &Row) -> Result<(), JobsError> {
    let id = job_id(row.try_get("id")?)?;
    known.names.extend(recording_names(id, possible_attempts(row)));
    if row.try_get("is_recorded")? {
        let recorded = attempts_of(row.try_get("recording_attempt")?)?;
        known.recorded.insert(id, recording_name(id, recorded));
    }
    Ok(())
}

fn mesh_name_of_row(row: &Row) -> Result<String, JobsError> {
    Ok(mesh_name(row.try_get("id")?, mesh_format(row.try_get("format")?)?))
}

fn mesh_of_row(row: &Row) -> Result<StoredMesh, JobsError> {
    Ok(StoredMesh {
        id: row.try_get("id")?,
        format: mesh_format(row.try_get("format")?)?,
        bytes: row.try_get::<i64, _>("bytes")?.cast_unsigned(),
        report: serde_json::from_str(row.try_get("report")?)?,
        created_at: row.try_get("created_at")?,
    })
}

fn mesh_format(name: String) -> Result<MeshFormat, JobsError> {
    MeshFormat::from_name(&format!(".{name}")).ok_or(JobsError::Corrupt { what: "mesh format", value: name })
}
