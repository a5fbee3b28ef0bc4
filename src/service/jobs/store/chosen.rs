//! Which stores a service has: of jobs in SQLite or PostgreSQL, of blobs in files or in an S3-compatible store.

use super::JobStore;
use super::database_address::DatabaseAddress;
use super::sqlite::SqliteStore;
use crate::blobs::{BlobError, BlobStore, FolderBlobs};
use crate::service::jobs::JobsError;
use clap::Args;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// File of the store in the data folder.
const FILE: &str = "jobs.sqlite";
/// The file with its last transactions.
const LOG: &str = "jobs.sqlite-wal";
/// How long a process has a job without a sign of life [s].
const LEASE_S: u64 = 15;

/// How long a request to an object store is tried that a run or a client waits for.
pub const PATIENCE: Duration = Duration::from_secs(180);
/// How long it is tried to find out whether the store answers.
pub const PROBE_PATIENCE: Duration = Duration::from_secs(5);

/// Where a service stores its data; flags of all commands that open its stores.
#[derive(Args, Clone)]
pub struct StoreAddress {
    /// Data folder of this process: recordings being written, and without --database and --blobs all jobs, meshes and recordings.
    #[arg(long, env = "CONTUSE_DATA", default_value = "data")]
    pub data: PathBuf,
    /// Database of the jobs, postgres://user@host/name, which any number of processes share [default: a file in the data folder]
    #[arg(long, env = "CONTUSE_DATABASE", hide_env_values = true, requires = "blobs", value_parser = DatabaseAddress)]
    pub database: Option<String>,
    /// Store of recordings, meshes and results, s3://bucket/prefix, with endpoint and credentials in the variables AWS_* [default: the
    /// data folder]
    #[arg(long, env = "CONTUSE_BLOBS", hide_env_values = true, requires = "database")]
    pub blobs: Option<String>,
    /// Time in seconds after which a process that shares a database and gives no sign of life loses its jobs to the others.
    #[arg(long, env = "CONTUSE_LEASE_S", default_value_t = LEASE_S, value_parser = clap::value_parser!(u64).range(1..))]
    pub lease_s: u64,
}

impl StoreAddress {
    /// With all stores in one data folder.
    pub fn in_folder(data: impl Into<PathBuf>) -> Self {
        Self { data: data.into(), database: None, blobs: None, lease_s: LEASE_S }
    }

    /// Whether other processes may use the stores at the same time.
    pub fn is_shared(&self) -> bool {
        self.database.is_some()
    }

    /// Whether the job store exists; opening it makes a new, empty one otherwise.
    pub fn exists(&self) -> bool {
        self.is_shared() || self.data.join(FILE).is_file()
    }

    /// Number of the last changes of the job store that are lost; PostgreSQL cares for its own. Only while no process uses it.
    pub async fn lost_changes(&self) -> u32 {
        if self.is_shared() { 0 } else { SqliteStore::lost_changes(&self.data.join(FILE)).await }
    }

    /// Keeps in mind that they are lost, after the store was opened and closed.
    ///
    /// # Errors
    /// If the note cannot be written.
    pub async fn note_lost_changes(&self, lost: u32) -> Result<(), JobsError> {
        SqliteStore::note_lost_changes(&self.data.join(FILE), lost).await
    }

    /// What has to be restored from a backup if the job store is damaged, for people.
    pub fn to_restore(&self) -> String {
        if self.is_shared() { self.to_string() } else { format!("{FILE} with its {LOG}") }
    }

    /// Opens the job store, and creates it if necessary.
    ///
    /// # Errors
    /// If it cannot be opened, or not migrated to this version.
    pub async fn open(&self) -> Result<Arc<dyn JobStore>, JobsError> {
        match &self.database {
            None => Ok(Arc::new(SqliteStore::open(&self.data.join(FILE)).await?)),
            #[cfg(feature = "cluster")]
            Some(url) => {
                let lease = Duration::from_secs(self.lease_s);
                Ok(Arc::new(super::postgres::PostgresStore::open(url, lease).await?))
            }
            #[cfg(not(feature = "cluster"))]
            Some(_) => {
                use crate::service::jobs::StoreFault;
                Err(JobsError::Store { fault: StoreFault::Other, source: WITHOUT_CLUSTER.into() })
            }
        }
    }

    /// Opens the store of recordings, meshes and results, and creates it if necessary. While one on other machines does not answer, a
    /// request is tried for `patience`. Within a runtime.
    ///
    /// # Errors
    /// If it cannot be opened.
    #[cfg_attr(not(feature = "cluster"), allow(unused_variables))] // a folder answers at once
    pub fn open_blobs(&self, patience: Duration) -> Result<Arc<dyn BlobStore>, BlobError> {
        match &self.blobs {
            None => Ok(Arc::new(FolderBlobs::open(&self.data)?)),
            #[cfg(feature = "cluster")]
            Some(url) => Ok(Arc::new(crate::blobs::ObjectBlobs::open(url, &self.data, patience)?)),
            #[cfg(not(feature = "cluster"))]
            Some(url) => Err(BlobError::of(url)(std::io::Error::other(WITHOUT_CLUSTER))),
        }
    }
}

#[cfg(not(feature = "cluster"))]
const WITHOUT_CLUSTER: &str = "this program was built without the feature `cluster`";

impl fmt::Display for StoreAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.is_shared() { "the PostgreSQL database" } else { FILE })
    }
}

/// Without the address of the database, which may hold a password.
impl fmt::Debug for StoreAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self} with {}, blobs in {}", self.data.display(), self.blobs.as_deref().unwrap_or("it"))
    }
}
