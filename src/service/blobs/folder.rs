//! Blobs as files of a folder, called by their names.

use super::{Blob, BlobStore};
use crate::service::jobs::JobsError;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A folder with a folder in it for each kind of blob.
#[derive(Debug)]
pub struct FolderBlobs {
    root: PathBuf,
}

impl FolderBlobs {
    /// Blobs in `root`, whose folders are there.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }
}

impl BlobStore for FolderBlobs {
    /// A file that already is where the blob belongs stays there.
    fn put(&self, file: &Path, name: &str) -> Result<(), JobsError> {
        let path = self.root.join(name);
        File::open(file).and_then(|f| f.sync_all()).map_err(|e| JobsError::file(file, e))?;
        if file != path {
            fs::rename(file, &path).map_err(|e| JobsError::file(&path, e))?;
        }
        // A rename is durable only when its folder is.
        let Some(folder) = path.parent() else { return Ok(()) };
        File::open(folder).and_then(|f| f.sync_all()).map_err(|e| JobsError::file(folder, e))
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, JobsError> {
        open_file(&self.root.join(name))
    }

    fn delete(&self, name: &str) -> Result<(), JobsError> {
        let path = self.root.join(name);
        match fs::remove_file(&path) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(JobsError::file(path, e)),
            _ => Ok(()),
        }
    }
}

/// Opens a file that may be there.
///
/// # Errors
/// When it is there and cannot be opened.
pub fn open_file(path: &Path) -> Result<Option<Box<dyn Blob>>, JobsError> {
    match File::open(path) {
        Ok(file) => Ok(Some(Box::new(file))),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(JobsError::file(path, e)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Seek, SeekFrom};

    #[test]
    fn a_blob_is_put_read_from_any_byte_on_and_deleted() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("meshes")).unwrap();
        let blobs = FolderBlobs::new(dir.path());
        let file = dir.path().join("upload");
        fs::write(&file, b"abc").unwrap();
        blobs.put(&file, "meshes/a.msh").unwrap();
        assert!(!file.exists());
        // What is in its place already stays there.
        blobs.put(&dir.path().join("meshes/a.msh"), "meshes/a.msh").unwrap();
        let mut blob = blobs.open("meshes/a.msh").unwrap().unwrap();
        blobs.delete("meshes/a.msh").unwrap();
        blobs.delete("meshes/a.msh").unwrap();
        assert!(blobs.open("meshes/a.msh").unwrap().is_none());
        let mut rest = String::new();
        blob.seek(SeekFrom::Start(1)).unwrap();
        blob.read_to_string(&mut rest).unwrap();
        assert_eq!(rest, "bc");
    }
}
