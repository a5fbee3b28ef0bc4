//! Which stores a service has: of jobs in SQLite, of blobs in files, both in its data folder.

use super::JobStore;
use super::sqlite::SqliteStore;
use crate::blobs::{BlobError, BlobStore, FolderBlobs};
use crate::service::jobs::JobsError;
use clap::Args;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// File of the store in the data folder.
const FILE: &str = "jobs.sqlite";
/// The file with its last transactions.
const LOG: &str = "jobs.sqlite-wal";

/// Where a service stores its data; flags of all commands that open its stores.
#[derive(Args, Clone, Debug)]
pub struct StoreAddress {
    /// Data folder of the service: jobs, meshes and recordings.
    #[arg(long, env = "CONTUSE_DATA", default_value = "data")]
    pub data: PathBuf,
}

impl StoreAddress {
    /// With all stores in one data folder.
    pub fn in_folder(data: impl Into<PathBuf>) -> Self {
        Self { data: data.into() }
    }

    /// Whether the job store exists; opening it makes a new, empty one otherwise.
    pub fn exists(&self) -> bool {
        self.data.join(FILE).is_file()
    }

    /// What has to be restored from a backup if the job store is damaged, for people.
    pub fn to_restore(&self) -> String {
        format!("{FILE} with its {LOG}")
    }

    /// Opens the job store, and creates it if necessary.
    ///
    /// # Errors
    /// If it cannot be opened, or not migrated to this version.
    pub async fn open(&self) -> Result<Arc<dyn JobStore>, JobsError> {
        Ok(Arc::new(SqliteStore::open(&self.data.join(FILE)).await?))
    }

    /// Opens the store of recordings, meshes and results, and creates it if necessary.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open_blobs(&self) -> Result<Arc<dyn BlobStore>, BlobError> {
        Ok(Arc::new(FolderBlobs::open(&self.data)?))
    }
}

impl fmt::Display for StoreAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(FILE)
    }
}
