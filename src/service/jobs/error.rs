//! What can go wrong with jobs.

use crate::blobs::BlobError;
use std::error::Error;
use std::io::ErrorKind;
use std::path::PathBuf;

/// Why a job could not be kept, found or run.
#[derive(Debug, thiserror::Error)]
pub enum JobsError {
    /// The job store did not answer.
    #[error("the job store failed: {source}")]
    Store {
        /// What of it is worth knowing, whichever store it is.
        fault: StoreFault,
        /// Why, in the words of the store.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The tables of the job store could not be brought to this version.
    #[error("the job store could not be migrated: {0}")]
    Migration(#[source] Box<dyn Error + Send + Sync>),
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
    /// A blob that could not be used.
    #[error(transparent)]
    Blob(#[from] BlobError),
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

/// How a job store failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreFault {
    /// It has no room.
    Full,
    /// Its disk failed, or it had too much to do: later it may be otherwise.
    Passing,
    /// Anything else.
    Other,
}

impl JobsError {
    /// Whether there was no room.
    pub fn is_storage_full(&self) -> bool {
        match self {
            Self::Store { fault, .. } => *fault == StoreFault::Full,
            _ => matches!(self.io_kind(), Some(ErrorKind::StorageFull | ErrorKind::QuotaExceeded)),
        }
    }

    /// How a file or a blob failed.
    pub fn io_kind(&self) -> Option<ErrorKind> {
        match self {
            Self::File { source, .. } | Self::Blob(BlobError::Failed { source, .. }) => Some(source.kind()),
            _ => None,
        }
    }

    /// Whether it may be otherwise later.
    pub fn is_passing(&self) -> bool {
        matches!(self, Self::Store { fault: StoreFault::Passing, .. })
    }

    /// An error about a file.
    pub fn file(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }
}
