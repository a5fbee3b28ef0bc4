//! What can go wrong with jobs.

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

impl JobsError {
    /// An error about a file.
    pub fn file(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }
}
