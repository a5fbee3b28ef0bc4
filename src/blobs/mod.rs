//! Blobs: bytes that never change under their name. Recordings of runs that have ended, meshes, snapshots, results.
//!
//! A store is a [`BlobStore`]: [`FolderBlobs`] keeps files of a folder. Another one is a file of its own that passes
//! `tests/mod.rs`. What still grows has no name: it is a [`Draft`], or a file of the machine that writes it, which a store
//! [adopts](BlobStore::adopt) when it is whole.

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

/// A blob that is read, from any byte on.
pub trait Blob: Read + Seek + Send {}
impl<T: Read + Seek + Send> Blob for T {}

/// What a store says of a blob without opening it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlobEntry {
    /// Its name.
    pub name: String,
    /// When it was kept.
    pub kept: SystemTime,
}

/// Why a blob was not kept, opened, listed or deleted.
#[derive(Debug, thiserror::Error)]
pub enum BlobError {
    /// It has more bytes than it may have.
    #[error("more than {most} bytes")]
    TooLarge {
        /// So many it may have.
        most: u64,
    },
    /// The store failed.
    #[error("{name}: {source}")]
    Failed {
        /// The blob, or the file that was to be one.
        name: String,
        /// Why.
        source: io::Error,
    },
}

impl From<io::Error> for BlobError {
    fn from(source: io::Error) -> Self {
        Self::Failed { name: "what is to be a blob".into(), source }
    }
}

impl BlobError {
    /// The store failed with this blob.
    pub fn of(name: impl Into<String>) -> impl FnOnce(io::Error) -> Self {
        let name = name.into();
        |source| Self::Failed { name, source }
    }
}

/// What keeps blobs, under names like `meshes/ball.msh`: shelf and name. Its calls wait for a disk or a network.
///
/// A blob is there as a whole or not at all, and durable when the call that names it returns.
pub trait BlobStore: fmt::Debug + Send + Sync + 'static {
    /// A place for bytes that are to come and have no name yet; a [`Draft`] counts and digests them.
    ///
    /// # Errors
    /// When the store takes nothing.
    fn unnamed(&self) -> Result<Box<dyn Unnamed>, BlobError>;

    /// Opens a blob; `None` when there is none of this name. Deleted meanwhile, it can still be read to its end.
    ///
    /// # Errors
    /// When it is there and cannot be opened.
    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, BlobError>;

    /// Deletes a blob that may be there.
    ///
    /// # Errors
    /// When it is there and stays.
    fn delete(&self, name: &str) -> Result<(), BlobError>;

    /// The blobs of a shelf, in any order.
    ///
    /// # Errors
    /// When they cannot be listed.
    fn list(&self, shelf: &str) -> Result<Vec<BlobEntry>, BlobError>;

    /// Makes a file of this machine that is whole a blob, in place of what had the name. The file goes.
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
