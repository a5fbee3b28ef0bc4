//! Blobs: named bytes that never change. Recordings of finished runs, meshes, snapshots, results.
//!
//! A store is a [`BlobStore`]: [`FolderBlobs`] keeps files in a folder. Another store is one file that passes
//! `tests/mod.rs`. Bytes that are still being written have no name: they are a [`Draft`], or a local file that a store
//! [adopts](BlobStore::adopt) when it is complete.

mod digest;
mod draft;
mod folder;
#[cfg(test)]
mod tests;

pub use digest::{BlobDigest, Digester, hexadecimal};
pub use draft::{Draft, Unnamed};
pub use folder::FolderBlobs;

use std::fmt;
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;
use std::time::SystemTime;

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

/// A store of blobs with names like `meshes/ball.msh`: shelf and name. Its calls may block on disk or network.
///
/// A blob exists as a whole or not at all, and is durable when the call that names it returns.
pub trait BlobStore: fmt::Debug + Send + Sync + 'static {
    /// Starts a blob without a name; a [`Draft`] counts and digests its bytes.
    ///
    /// # Errors
    /// When the store cannot accept bytes.
    fn unnamed(&self) -> Result<Box<dyn Unnamed>, BlobError>;

    /// Opens a blob; `None` when it does not exist. Once open, it can be read to its end even if it is deleted.
    ///
    /// # Errors
    /// When it exists but cannot be opened.
    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, BlobError>;

    /// Deletes a blob if it exists.
    ///
    /// # Errors
    /// When it exists but cannot be deleted.
    fn delete(&self, name: &str) -> Result<(), BlobError>;

    /// Blobs of a shelf, in any order.
    ///
    /// # Errors
    /// When they cannot be listed.
    fn list(&self, shelf: &str) -> Result<Vec<BlobEntry>, BlobError>;

    /// Turns a complete local file into a blob, replacing any blob of that name. The file is removed.
    ///
    /// # Errors
    /// When the file cannot be read or the blob cannot be kept.
    fn adopt(&self, file: &Path, name: &str) -> Result<BlobDigest, BlobError> {
        let mut draft = Draft::new(self.unnamed()?, u64::MAX);
        let of_file = || BlobError::of(file.display().to_string());
        draft.append_all(File::open(file).map_err(of_file())?)?;
        let digest = draft.keep(name)?;
        std::fs::remove_file(file).map_err(of_file())?;
        Ok(digest)
    }
}
