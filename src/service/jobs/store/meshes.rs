//! Who uploaded which mesh.

use super::Store;
use crate::service::jobs::JobsError;
use crate::service::meshes::{MeshFormat, MeshReport};

/// An uploaded mesh.
#[derive(Clone, Debug)]
pub struct StoredMesh {
    /// SHA-256 of its bytes, hexadecimal.
    pub id: String,
    /// Its format.
    pub format: MeshFormat,
    /// Its size [bytes].
    pub bytes: u64,
    /// What it holds.
    pub report: MeshReport,
    /// When it came first, RFC 3339.
    pub created_at: String,
}

impl Store {
    /// Notes an uploaded mesh; false when the owner had it already.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn add_mesh(
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

    /// A mesh of an owner.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn mesh(&self, owner: &str, id: &str) -> Result<Option<StoredMesh>, JobsError> {
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
                format: MeshFormat::from_extension(&format)
                    .ok_or(JobsError::Corrupt { what: "mesh format", value: format })?,
                bytes: bytes.cast_unsigned(),
                report: serde_json::from_str(&report)?,
                created_at,
            })
        })
        .transpose()
    }
}
