//! Blobs as files of a folder, with their names as paths.
//!
//! A blob whose name ends with two hexadecimal digits, its extension apart, is in a folder of these digits: `recordings/1f/…1f.mcap`.
//! So no folder of ids or digests has very many files. Files that an earlier version left beside these folders are blobs, too.

use super::{Blob, BlobDigest, BlobEntry, BlobError, BlobStore, Unnamed};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// File extension of drafts, which are not blobs yet.
const PARTIAL: &str = "partial";

/// Shortest name that is an id or a digest: others are not spread over folders.
const SHORTEST_ID: usize = 16;

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
        for path in places(&self.root, name) {
            match File::open(path) {
                Ok(file) => return Ok(Some(Box::new(file))),
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(BlobError::of(name)(error)),
            }
        }
        // Without the folder itself it is not known what is lost.
        self.root.metadata().map_err(BlobError::of(self.root.display().to_string()))?;
        Ok(None)
    }

    fn delete(&self, name: &str) -> Result<(), BlobError> {
        places(&self.root, name).iter().try_for_each(|path| remove(path)).map_err(BlobError::of(name))
    }

    fn list(&self, shelf: &str) -> Result<Vec<BlobEntry>, BlobError> {
        list(&self.root, shelf).map_err(BlobError::of(shelf))
    }

    fn place(&self, name: &str) -> String {
        let found = places(&self.root, name).into_iter().find(|path| path.exists());
        found.unwrap_or_else(|| self.root.join(name)).display().to_string()
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
pub(super) struct UnnamedFile {
    file: File,
    path: PathBuf,
    root: PathBuf,
}

impl UnnamedFile {
    /// A new file in a folder.
    pub(super) fn create(root: &Path) -> io::Result<Self> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        let count = COUNTER.fetch_add(1, Ordering::Relaxed);
        let path = root.join(format!("{}-{count}.{PARTIAL}", std::process::id()));
        let file = File::create(&path)?;
        file.lock()?;
        Ok(Self { file, path, root: root.to_owned() })
    }

    #[cfg(feature = "cluster")]
    pub(super) fn path(&self) -> &Path {
        &self.path
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
    let places = places(root, name);
    let Some((path, former)) = places.split_first() else { return Err(ErrorKind::InvalidInput.into()) };
    let folder = path.parent().unwrap_or(root);
    create_durably(root, folder)?;
    fs::rename(file, path)?;
    File::open(folder)?.sync_all()?;
    former.iter().try_for_each(|path| remove(path))
}

/// Creates a folder with those above it below the root, which must exist: one that was moved away would be taken for empty. Each is synced in the
/// one that contains it.
fn create_durably(root: &Path, folder: &Path) -> io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let Some(above) = folder.parent().filter(|_| folder != root) else {
        return Err(ErrorKind::NotFound.into());
    };
    create_durably(root, above)?;
    match fs::create_dir(folder) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => Err(error),
        _ => File::open(above)?.sync_all(),
    }
}

/// Where a blob may be: its place, and that of earlier versions.
fn places(root: &Path, name: &str) -> Vec<PathBuf> {
    let flat = root.join(name);
    let digits = Path::new(name).file_name().and_then(|file| digits_of(file.to_str()?));
    match (name.rsplit_once('/'), digits) {
        (Some((shelf, file)), Some(digits)) => vec![root.join(shelf).join(digits).join(file), flat],
        _ => vec![flat],
    }
}

/// The last two characters of a file name before its first dot, if they are hexadecimal digits of an id or a digest.
fn digits_of(file: &str) -> Option<&str> {
    let stem = file.split('.').next()?;
    let digits = stem.get(stem.len().checked_sub(2)?..)?;
    (stem.len() >= SHORTEST_ID && is_digits(digits)).then_some(digits)
}

fn is_digits(text: &str) -> bool {
    text.len() == 2 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

fn list(root: &Path, shelf: &str) -> io::Result<Vec<BlobEntry>> {
    let mut entries = Vec::new();
    list_folder(&root.join(shelf), shelf, &mut entries)?;
    Ok(entries)
}

/// Adds the blobs of a folder, and those of its folders of two digits.
fn list_folder(folder: &Path, shelf: &str, entries: &mut Vec<BlobEntry>) -> io::Result<()> {
    if !folder.is_dir() {
        return Ok(());
    }
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let is_shard = !shelf.is_empty() && entry.file_name().to_str().is_some_and(is_digits);
        if is_shard && entry.file_type()?.is_dir() {
            list_folder(&entry.path(), shelf, entries)?;
            continue;
        }
        // Drafts are in the root folder, next to the shelves.
        let is_draft = shelf.is_empty() && is_partial(&entry.path());
        let is_blob = entry.file_type()?.is_file() && !is_draft;
        // Names of blobs are text; files with other names are skipped.
        if let (true, Ok(name)) = (is_blob, entry.file_name().into_string()) {
            let name = if shelf.is_empty() { name } else { format!("{shelf}/{name}") };
            entries.push(BlobEntry { name, kept: entry.metadata()?.modified()? });
        }
    }
    Ok(())
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
    fn a_root_that_was_moved_away_is_not_made_anew() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("blobs");
        let blobs = FolderBlobs::open(&root).unwrap();
        let file = dir.path().join("recording");
        fs::write(&file, b"abc").unwrap();
        fs::rename(&root, dir.path().join("elsewhere")).unwrap();
        assert!(blobs.adopt(&file, "recordings/00000000-0000-7000-8000-00000000001f.mcap").is_err());
        assert!(!root.exists() && file.exists());
    }

    #[test]
    fn ids_are_spread_over_folders_and_those_of_before_are_found() {
        let dir = tempfile::tempdir().unwrap();
        let blobs = FolderBlobs::open(dir.path()).unwrap();
        let [new, old] = [
            "recordings/00000000-0000-7000-8000-00000000001f.mcap",
            "recordings/00000000-0000-7000-8000-0000000000ab.mcap",
        ];
        let keep = |name: &str| {
            let mut draft = Draft::new(blobs.unnamed().unwrap(), 10);
            draft.append(b"abc").unwrap();
            draft.keep(name).unwrap();
        };
        keep(new);
        assert!(dir.path().join("recordings/1f/00000000-0000-7000-8000-00000000001f.mcap").exists());
        fs::write(dir.path().join(old), b"old").unwrap();
        let mut names: Vec<String> = blobs.list("recordings").unwrap().into_iter().map(|e| e.name).collect();
        names.sort();
        assert_eq!(names, [new, old]);
        assert!(blobs.open(old).unwrap().is_some());
        // The last one of a name counts, wherever the one before it was.
        keep(old);
        assert_eq!(BlobDigest::of(blobs.open(old).unwrap().unwrap()).unwrap().bytes, 3);
        assert!(!dir.path().join(old).exists());
        for name in [new, old] {
            blobs.delete(name).unwrap();
            assert!(blobs.open(name).unwrap().is_none());
        }
        assert!(blobs.list("recordings").unwrap().is_empty());
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
