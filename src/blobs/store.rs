//! What a store of blobs does.

use super::blob::{Blob, BlobEntry, BlobError};
use super::digest::BlobDigest;
use super::draft::{Draft, Unnamed};
use std::fmt;
use std::fs::File;
use std::path::Path;

/// A store of blobs with names like `meshes/ball.msh`: shelf and name. Its calls may block on disk or network.
///
/// A blob exists as a whole or not at all, and is durable when the call that names it returns.
pub trait BlobStore: fmt::Debug + Send + Sync + 'static {
    /// Starts a blob without a name; a [`Draft`] counts and digests its bytes.
    ///
    /// # Errors
    /// When the store cannot accept bytes.
    fn unnamed(&self) -> Result<Box<dyn Unnamed>, BlobError>;

    /// Opens a blob; `None` when it does not exist. Once open, it is read as it was even if it is deleted or replaced, or reading fails.
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

    /// Where a blob is or would be, for people: the path of a file, if the store keeps files.
    fn place(&self, name: &str) -> String {
        name.to_owned()
    }

    /// Turns a complete local file into a blob, replacing any blob of that name. The file is removed. It is tried once: the file stays
    /// for another time.
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
