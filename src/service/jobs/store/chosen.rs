//! Which store of jobs the service has: SQLite, in its data folder.

use super::JobStore;
use super::sqlite::SqliteStore;
use crate::service::jobs::JobsError;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// File of the store in the data folder.
const FILE: &str = "jobs.sqlite";
/// The file with its last transactions.
const LOG: &str = "jobs.sqlite-wal";

/// Where the jobs of a service are stored.
#[derive(Clone, Debug)]
pub struct StoreAddress {
    file: PathBuf,
}

impl StoreAddress {
    /// That of the service with a data folder.
    pub fn of_service(data: &Path) -> Self {
        Self { file: data.join(FILE) }
    }

    /// Whether the store exists; opening it makes a new, empty one otherwise.
    pub fn exists(&self) -> bool {
        self.file.is_file()
    }

    /// What has to be restored from a backup if the store is damaged, for people.
    pub fn to_restore(&self) -> String {
        format!("{FILE} with its {LOG}")
    }

    /// Opens the store, and creates it if necessary.
    ///
    /// # Errors
    /// If it cannot be opened, or not migrated to this version.
    pub async fn open(&self) -> Result<Arc<dyn JobStore>, JobsError> {
        Ok(Arc::new(SqliteStore::open(&self.file).await?))
    }
}

impl fmt::Display for StoreAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(FILE)
    }
}
