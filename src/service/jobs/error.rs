//! What can go wrong with jobs.

use std::io::ErrorKind;
use std::path::PathBuf;

/// Why a job could not be kept, found or run.
#[derive(Debug, thiserror::Error)]
pub enum JobsError {
    /// The job store did not answer.
    #[error("the job store failed: {0}")]
    Store(#[from] sqlx::Error),
    /// The tables of the job store could not be brought to this version.
    #[error("the job store could not be migrated: {0}")]
    Migration(#[from] sqlx::migrate::MigrateError),
    /// A row that this version did not write.
    #[error("the job store holds an unknown {what}: {value:?}")]
    Corrupt {
        /// What was read.
        what: &'static str,
        /// The value.
        value: String,
    },
    /// A file or folder that could not be used.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Another process uses the data folder.
    #[error("{} is in use by another process", path.display())]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// Something of the job could not be written as JSON.
    #[error("a part of a job could not be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// As many jobs wait as may wait.
    #[error("{waiting} jobs wait already")]
    QueueFull {
        /// How many.
        waiting: u64,
    },
}

/// SQLite's code for a disk without room (SQLITE_FULL), in the lower byte of a code with details.
const SQLITE_FULL: u32 = 13;
/// SQLite's code for a disk that fails (SQLITE_IOERR).
const SQLITE_IOERR: u32 = 10;

impl JobsError {
    /// Whether the disk had no room.
    pub fn is_storage_full(&self) -> bool {
        match self {
            Self::Store(_) => self.sqlite_code() == Some(SQLITE_FULL),
            Self::File { source, .. } => {
                matches!(source.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
            }
            _ => false,
        }
    }

    /// Whether the disk failed, or the store had too much to do: later it may be otherwise.
    pub fn is_passing(&self) -> bool {
        matches!(self, Self::Store(sqlx::Error::PoolTimedOut)) || self.sqlite_code() == Some(SQLITE_IOERR)
    }

    fn sqlite_code(&self) -> Option<u32> {
        let Self::Store(sqlx::Error::Database(error)) = self else { return None };
        error.code()?.parse::<u32>().ok().map(|code| code & 0xff)
    }

    /// An error about a file.
    pub fn file(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }
}
