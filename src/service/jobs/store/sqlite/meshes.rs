//! Who uploaded which mesh, and which blobs are somebody's.

use super::SqliteStore;
use super::read::job_id;
use crate::mesh::read::MeshFormat;
use crate::service::jobs::JobsError;
use crate::service::meshes::{MeshReport, StoredMesh};
use crate::service::shelves::{mesh_name, recording_name};
use std::collections::BTreeSet;

impl SqliteStore {
    pub(super) async fn add_mesh(
        &self,
        owner: &str,
        id: &str,
        format: MeshFormat,
        bytes: u64,
        report: &MeshReport,
    ) -> Result<bool, JobsError> {
        let result = sqlx::query(
            "INSERT INTO meshes (id, owner, format, bytes, report) VALUES (?1, ?2, ?3, ?4, ?5) ON CONFLICT DO NOTHING",
        )
        .bind(id)
        .bind(owner)
        .bind(format.extension())
        .bind(bytes.cast_signed())
        .bind(serde_json::to_string(report)?)
        .execute(&self.pool)
        .await?;
        Ok(result.rows_affected() > 0)
    }

    pub(super) async fn blobs(&self) -> Result<BTreeSet<String>, JobsError> {
        let ids: Vec<(String,)> = sqlx::query_as("SELECT id FROM jobs").fetch_all(&self.pool).await?;
        let ids = ids.into_iter().map(|(id,)| job_id(id).map(recording_name));
        let mut names = ids.collect::<Result<BTreeSet<_>, _>>()?;
        let meshes: Vec<(String, String)> =
            sqlx::query_as("SELECT DISTINCT id, format FROM meshes").fetch_all(&self.pool).await?;
        for (id, format) in meshes {
            names.insert(mesh_name(&id, mesh_format(format)?));
        }
        Ok(names)
    }

    pub(super) async fn mesh(&self, owner: &str, id: &str) -> Result<Option<StoredMesh>, JobsError> {
        let row: Option<(String, i64, String, String)> = sqlx::query_as(
            "SELECT format, bytes, report, created_at FROM meshes WHERE owner = ?1 AND id = ?2",
        )
        .bind(owner)
        .bind(id)
        .fetch_optional(&self.pool)
        .await?;
        row.map(|(format, bytes, report, created_at)| {
            Ok(StoredMesh {
                id: id.to_owned(),
                format: mesh_format(format)?,
                bytes: bytes.cast_unsigned(),
                report: serde_json::from_str(&report)?,
                created_at,
            })
        })
        .transpose()
    }
}

fn mesh_format(name: String) -> Result<MeshFormat, JobsError> {
    MeshFormat::from_name(&format!(".{name}")).ok_or(JobsError::Corrupt { what: "mesh format", value: name })
}
