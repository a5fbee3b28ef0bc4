//! The blob store: bytes that never change under their name. Recordings of jobs that have ended, and uploaded meshes.
//!
//! What still grows (a recording while its job runs, snapshots of it, an upload) is a file in the
//! [`DataFolder`](super::jobs::recordings::DataFolder) of the machine that writes it, and becomes a blob when it is whole.

mod folder;

pub use folder::{FolderBlobs, open_file};

use super::jobs::{JobId, JobsError};
use crate::mesh::read::MeshFormat;
use std::fmt;
use std::io::{Read, Seek};
use std::path::Path;

/// A blob that is read, from any byte on.
pub trait Blob: Read + Seek + Send {}
impl<T: Read + Seek + Send> Blob for T {}

/// What keeps blobs. Its calls wait for a disk or a network: not for threads of the runtime.
pub trait BlobStore: fmt::Debug + Send + Sync + 'static {
    /// Keeps a file of this machine that is whole under a name, all of it or nothing, in place of what had the name. It is durable
    /// when this returns, and the file itself may be gone.
    ///
    /// # Errors
    /// When the file cannot be read or the blob cannot be kept.
    fn put(&self, file: &Path, name: &str) -> Result<(), JobsError>;

    /// Opens a blob; `None` when there is none of this name. Deleted meanwhile, it can still be read to its end.
    ///
    /// # Errors
    /// When it is there and cannot be opened.
    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, JobsError>;

    /// Deletes a blob that may be there.
    ///
    /// # Errors
    /// When it is there and stays.
    fn delete(&self, name: &str) -> Result<(), JobsError>;
}

/// The name of the recording of a job that has ended.
pub fn recording_name(id: JobId) -> String {
    format!("recordings/{id}.mcap")
}

/// The name of an uploaded mesh.
pub fn mesh_name(id: &str, format: MeshFormat) -> String {
    format!("meshes/{id}.{}", format.extension())
}
