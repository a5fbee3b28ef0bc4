//! Blobs as files of a folder, with their names as paths.

use super::{Blob, BlobDigest, BlobEntry, BlobError, BlobStore, Unnamed};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// File extension of drafts, which are not blobs yet.
const PARTIAL: &str = "partial";

/// A folder with one subfolder per shelf. Several processes may use it.
#[derive(Debug)]
pub struct FolderBlobs {
    root: PathBuf,
}

impl FolderBlobs {
    /// Opens a store in a folder, which is created if necessary. Drafts of processes that no longer exist are removed.
    ///
    /// # Errors
    /// When the folder cannot be created or read.
    pub fn open(root: &Path) -> Result<Self, BlobError> {
        let of_root = || BlobError::of(root.display().to_string());
        fs::create_dir_all(root).map_err(of_root())?;
        forget_lost_drafts(root).map_err(of_root())?;
        Ok(Self { root: root.to_owned() })
    }
}

impl BlobStore for FolderBlobs {
    fn unnamed(&self) -> Result<Box<dyn Unnamed>, BlobError> {
        let of_root = BlobError::of(self.root.display().to_string());
        Ok(Box::new(UnnamedFile::create(&self.root).map_err(of_root)?))
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, BlobError> {
        match File::open(self.root.join(name)) {
            Ok(file) => Ok(Some(Box::new(file))),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(BlobError::of(name)(error)),
        }
    }

    fn delete(&self, name: &str) -> Result<(), BlobError> {
        remove(&self.root.join(name)).map_err(BlobError::of(name))
    }

    fn list(&self, shelf: &str) -> Result<Vec<BlobEntry>, BlobError> {
        list(&self.root, shelf).map_err(BlobError::of(shelf))
    }

    /// Nothing is copied: the file, which must be on the same disk as the folder, is renamed.
    fn adopt(&self, file: &Path, name: &str) -> Result<BlobDigest, BlobError> {
        let digest = File::open(file).and_then(BlobDigest::of);
        let digest = digest.map_err(BlobError::of(file.display().to_string()))?;
        name_file(file, &self.root, name).map_err(BlobError::of(name))?;
        Ok(digest)
    }
}

/// A file with a temporary name, locked while it is being written.
struct UnnamedFile {
    file: File,
    path: PathBuf,
    root: PathBuf,
}

impl UnnamedFile {
    fn create(root: &Path) -> io::Result<Self> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        let count = COUNTER.fetch_add(1, Ordering::Relaxed);
        let path = root.join(format!("{}-{count}.{PARTIAL}", std::process::id()));
        let file = File::create(&path)?;
        file.lock()?;
        Ok(Self { file, path, root: root.to_owned() })
    }
}

impl Unnamed for UnnamedFile {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)
    }

    fn open(&self) -> io::Result<Box<dyn Blob>> {
        Ok(Box::new(File::open(&self.path)?))
    }

    fn keep(self: Box<Self>, name: &str) -> io::Result<()> {
        name_file(&self.path, &self.root, name)
    }
}

impl Drop for UnnamedFile {
    fn drop(&mut self) {
        // A kept file has another name; a remaining one is removed when the folder is opened next.
        let _ = fs::remove_file(&self.path);
    }
}

/// Gives a file its name, durably: first its bytes are synced, then it is renamed, then the folder is synced.
fn name_file(file: &Path, root: &Path, name: &str) -> io::Result<()> {
    File::open(file)?.sync_all()?;
    let path = root.join(name);
    let folder = path.parent().unwrap_or(root);
    if !folder.is_dir() {
        fs::create_dir_all(folder)?;
        File::open(root)?.sync_all()?;
    }
    fs::rename(file, &path)?;
    File::open(folder)?.sync_all()
}

fn list(root: &Path, shelf: &str) -> io::Result<Vec<BlobEntry>> {
    let folder = root.join(shelf);
    let mut entries = Vec::new();
    for entry in if folder.is_dir() { Some(fs::read_dir(folder)?) } else { None }.into_iter().flatten() {
        let entry = entry?;
        // Drafts are in the root folder, next to the shelves.
        let is_draft = shelf.is_empty() && is_partial(&entry.path());
        let is_blob = entry.file_type()?.is_file() && !is_draft;
        // Names of blobs are text; files with other names are skipped.
        if let (true, Ok(name)) = (is_blob, entry.file_name().into_string()) {
            let name = if shelf.is_empty() { name } else { format!("{shelf}/{name}") };
            entries.push(BlobEntry { name, kept: entry.metadata()?.modified()? });
        }
    }
    Ok(entries)
}

/// Removes drafts that no process holds: the system releases the lock of a process however it ends.
fn forget_lost_drafts(root: &Path) -> io::Result<()> {
    for entry in fs::read_dir(root)? {
        let path = entry?.path();
        if !is_partial(&path) {
            continue;
        }
        match File::open(&path).map(|file| file.try_lock()) {
            Ok(Err(TryLockError::WouldBlock)) => {}
            _ => remove(&path)?,
        }
    }
    Ok(())
}

fn is_partial(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == PARTIAL)
}

/// Removes a file if it exists.
fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Draft, tests::check};
    use super::*;

    #[test]
    fn it_keeps_what_a_store_promises() {
        let dir = tempfile::tempdir().unwrap();
        check(&FolderBlobs::open(dir.path()).unwrap());
        // Nothing but blobs is left.
        assert!(fs::read_dir(dir.path()).unwrap().all(|entry| entry.unwrap().path().is_dir()));
    }

    #[test]
    fn a_draft_is_removed_when_no_process_writes_it() {
        let dir = tempfile::tempdir().unwrap();
        let blobs = FolderBlobs::open(dir.path()).unwrap();
        let mut draft = Draft::new(blobs.unnamed().unwrap(), 10);
        draft.append(b"abc").unwrap();
        let lost = dir.path().join("1-0.partial");
        fs::write(&lost, b"half of").unwrap();
        FolderBlobs::open(dir.path()).unwrap();
        assert!(!lost.exists());
        draft.keep("a/b").unwrap();
        assert!(blobs.open("a/b").unwrap().is_some());
    }
}
