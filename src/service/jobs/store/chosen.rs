//! The job store of the service: which one it is, and its files in the data folder.

use super::JobStore;
use super::sqlite::SqliteStore;
use crate::service::jobs::JobsError;
use std::path::Path;
use std::sync::Arc;

/// File of the store in the data folder.
pub const STORE_FILE: &str = "jobs.sqlite";
/// The file with its last transactions.
pub const STORE_LOG: &str = "jobs.sqlite-wal";

/// Opens the store in a file, which is created if necessary.
///
/// # Errors
/// If the file cannot be opened, or not migrated to this version.
pub async fn open_store(file: &Path) -> Result<Arc<dyn JobStore>, JobsError> {
    Ok(Arc::new(SqliteStore::open(file).await?))
}
