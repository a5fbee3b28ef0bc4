//! A blob, its entry in a directory, and what may go wrong with it.

use std::io::{self, Read, Seek};
use std::time::{Duration, SystemTime};

/// A blob opened for reading, with random access.
pub trait Blob: Read + Seek + Send {}
impl<T: Read + Seek + Send> Blob for T {}

/// Directory entry of a blob.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlobEntry {
    /// Name of the blob, as `shelf/name`.
    pub name: String,
    /// Time at which it was kept.
    pub kept: SystemTime,
}

impl BlobEntry {
    /// Time since it was kept; zero if that is in the future.
    pub fn age(&self) -> Duration {
        self.kept.elapsed().unwrap_or_default()
    }
}

/// Why a blob could not be kept, opened, listed or deleted.
#[derive(Debug, thiserror::Error)]
pub enum BlobError {
    /// The blob exceeds its size limit.
    #[error("more than {most} bytes")]
    TooLarge {
        /// The size limit [bytes].
        most: u64,
    },
    /// The file system, or whatever holds the blobs, failed.
    #[error("{name}: {source}")]
    Failed {
        /// Name of the blob, or of the file to become one.
        name: String,
        /// Error of the file system.
        source: io::Error,
    },
}

impl From<io::Error> for BlobError {
    fn from(source: io::Error) -> Self {
        Self::Failed { name: "a blob being written".into(), source }
    }
}

impl BlobError {
    /// Wraps a failure of the store for the blob `name`.
    pub fn of(name: impl Into<String>) -> impl FnOnce(io::Error) -> Self {
        let name = name.into();
        |source| Self::Failed { name, source }
    }
}
