//! The local data folder, outside of any blob store: the file of the job store, and recordings that are still being
//! written. Only one process may use the folder.
//!
//! A run writes `runs/<id>.mcap.partial`, which its recorder renames when complete; then it becomes a
//! [blob](crate::blobs). All other files of a run begin with `<id>.` as well, so that they can be removed with the job.

use super::{JobId, JobsError};
use std::fs::{DirEntry, File, Metadata, TryLockError};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long the lock of a process that has ended is waited for.
const LAST_HOLD: Duration = Duration::from_secs(2);

/// The data folder, locked for this process during the life of this value.
#[derive(Debug)]
pub struct DataFolder {
    root: PathBuf,
    locks: Vec<Lock>,
}

/// A file or folder that is held for its lock, which the system releases however the process ends.
#[derive(Debug)]
struct Lock {
    path: PathBuf,
    held: File,
}

impl Lock {
    /// Locks what is open; `None` if its file system does not lock it. A process that was killed may hold it for a moment.
    fn take(path: PathBuf, held: File) -> Result<Option<Self>, JobsError> {
        let mut locked = held.try_lock();
        let begun = Instant::now();
        while matches!(locked, Err(TryLockError::WouldBlock)) && begun.elapsed() < LAST_HOLD {
            std::thread::sleep(LAST_HOLD / 20);
            locked = held.try_lock();
        }
        match locked {
            Ok(()) => Ok(Some(Self { path, held })),
            Err(TryLockError::WouldBlock) => {
                Err(JobsError::InUse { path: path.parent().unwrap_or(&path).to_owned() })
            }
            Err(TryLockError::Error(error)) => {
                tracing::debug!(path = %path.display(), %error, "it cannot be locked");
                Ok(None)
            }
        }
    }

    /// Whether the path is still that of what is locked.
    fn is_in_place(&self) -> bool {
        let held = self.held.metadata();
        std::fs::metadata(&self.path).is_ok_and(|found| held.is_ok_and(|held| is_same(&found, &held)))
    }
}

impl DataFolder {
    /// Locks a folder, creating it and its subfolders if necessary. Another process needs all locks: one that is in place refuses it.
    ///
    /// # Errors
    /// `InUse` if another process has it; `File` if it cannot be created or locked.
    pub fn open(root: &Path) -> Result<Self, JobsError> {
        let folder = root.join("runs");
        std::fs::create_dir_all(&folder).map_err(|e| JobsError::file(&folder, e))?;
        // Whoever may not enter it reads no file in it, whenever that was written.
        restrict(root).map_err(|e| JobsError::file(root, e))?;
        let file = root.join("lock");
        let opened = File::create(&file).map_err(|e| JobsError::file(&file, e))?;
        let mut locks = Vec::from_iter(Lock::take(file, opened)?);
        // A file is easily removed. Some file systems of networks lock no folders.
        if let Ok(opened) = File::open(&folder) {
            locks.extend(Lock::take(folder, opened)?);
        }
        if locks.is_empty() {
            let error = std::io::Error::new(ErrorKind::Unsupported, "its file system has no locks");
            return Err(JobsError::file(root, error));
        }
        Ok(Self { root: root.to_owned(), locks })
    }

    /// Checks that no other process can have taken the folder, and that runs can write there: the last lock, that of their folder where its
    /// file system has such.
    ///
    /// # Errors
    /// `Replaced`
    pub fn check_locks(&self) -> Result<(), JobsError> {
        let is_ours = self.locks.last().is_some_and(Lock::is_in_place);
        if is_ours { Ok(()) } else { Err(JobsError::Replaced { path: self.root.clone() }) }
    }

    /// Recording of a job until it becomes a blob.
    pub fn recording(&self, id: JobId) -> PathBuf {
        self.root.join("runs").join(format!("{id}.mcap"))
    }

    /// Snapshot of the recording of a job until it becomes a blob.
    pub fn snapshot(&self, id: JobId) -> PathBuf {
        self.root.join("runs").join(format!("{id}.snapshot.mcap"))
    }

    /// Free space of the disk that this process may use [bytes].
    ///
    /// # Errors
    /// If the system does not say.
    pub fn free_space(&self) -> Result<u64, JobsError> {
        free_space(&self.root).map_err(|error| JobsError::file(&self.root, error))
    }

    /// Checks that the disk accepts a file. It has no name, so that no listing meets it and nothing of it stays.
    ///
    /// # Errors
    /// Why it does not.
    pub fn try_write(&self) -> Result<(), JobsError> {
        let write = || tempfile::tempfile_in(&self.root)?.write_all(&vec![0; 64 << 10]);
        write().map_err(|error| JobsError::file(&self.root, error))
    }

    /// Size of all files of a run [bytes].
    ///
    /// # Errors
    /// If they cannot be listed.
    pub fn bytes(&self, id: JobId) -> Result<u64, JobsError> {
        let mut bytes = 0;
        self.for_each(&format!("{id}."), |entry| {
            bytes += entry.metadata()?.len();
            Ok(())
        })?;
        Ok(bytes)
    }

    /// Removes all files of a run.
    ///
    /// # Errors
    /// If an existing file cannot be removed.
    pub fn remove(&self, id: JobId) -> Result<(), JobsError> {
        self.remove_all(&format!("{id}."))
    }

    /// Removes all files of all runs. Only if no run is active.
    ///
    /// # Errors
    /// If an existing file cannot be removed.
    pub fn remove_leftovers(&self) -> Result<(), JobsError> {
        self.remove_all("")
    }

    /// Removes the files of runs with this prefix.
    fn remove_all(&self, beginning: &str) -> Result<(), JobsError> {
        self.for_each(beginning, |entry| std::fs::remove_file(entry.path()))
    }

    /// Does something with each file of runs with this prefix.
    fn for_each(
        &self,
        beginning: &str,
        mut act: impl FnMut(&DirEntry) -> std::io::Result<()>,
    ) -> Result<(), JobsError> {
        let folder = self.root.join("runs");
        for entry in std::fs::read_dir(&folder).map_err(|e| JobsError::file(&folder, e))? {
            let entry = entry.map_err(|e| JobsError::file(&folder, e))?;
            if entry.file_name().to_str().is_some_and(|name| name.starts_with(beginning)) {
                act(&entry).map_err(|e| JobsError::file(entry.path(), e))?;
            }
        }
        Ok(())
    }
}

/// What other users of the machine may read or enter in a folder, itself included, with its mode: nothing if they may not enter it.
///
/// # Errors
/// If it cannot be read.
#[cfg(unix)]
pub fn open_to_others(root: &Path) -> Result<Vec<(PathBuf, u32)>, JobsError> {
    use std::os::unix::fs::PermissionsExt as _;
    let (mut found, mut unseen) = (Vec::new(), vec![root.to_owned()]);
    while let Some(path) = unseen.pop() {
        let at_path = |error| JobsError::file(&path, error);
        // What a link names is elsewhere, or found by itself.
        let entry = match std::fs::symlink_metadata(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            entry => entry.map_err(at_path)?,
        };
        let mode = entry.permissions().mode() & 0o777;
        let is_closed = mode.trailing_zeros() >= 6;
        if is_closed || entry.is_symlink() {
            continue;
        }
        if entry.is_dir() {
            for entry in std::fs::read_dir(&path).map_err(at_path)? {
                unseen.push(entry.map_err(at_path)?.path());
            }
        }
        found.push((path, mode));
    }
    found.sort();
    Ok(found)
}

/// The system has no modes.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn open_to_others(_: &Path) -> Result<Vec<(PathBuf, u32)>, JobsError> {
    Ok(Vec::new())
}

/// Closes a folder, and the files in it, for other users of the machine.
#[cfg(unix)]
fn restrict(folder: &Path) -> std::io::Result<()> {
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::PermissionsExt as _;
    set_permissions(folder, Permissions::from_mode(0o700))?;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let close = || -> std::io::Result<()> {
            if entry.file_type()?.is_file() && entry.metadata()?.permissions().mode() & 0o077 > 0 {
                set_permissions(entry.path(), Permissions::from_mode(0o600))?;
            }
            Ok(())
        };
        // Whoever else uses the folder may remove a file meanwhile.
        close().or_else(|error| if error.kind() == ErrorKind::NotFound { Ok(()) } else { Err(error) })?;
    }
    Ok(())
}

/// Whether two paths, or a path and what is open, are one file.
#[cfg(unix)]
fn is_same(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (one.dev(), one.ino()) == (other.dev(), other.ino())
}

#[cfg(not(unix))]
fn is_same(_: &Metadata, _: &Metadata) -> bool {
    true
}

#[cfg(unix)]
fn free_space(folder: &Path) -> std::io::Result<u64> {
    let disk = rustix::fs::statvfs(folder)?;
    Ok(disk.f_bavail.saturating_mul(disk.f_frsize))
}

#[cfg(not(unix))]
fn free_space(_: &Path) -> std::io::Result<u64> {
    Ok(u64::MAX)
}

#[cfg(not(unix))]
fn restrict(_: &Path) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_process_has_the_folder() {
        let dir = tempfile::tempdir().unwrap();
        let first = DataFolder::open(dir.path()).unwrap();
        assert!(matches!(DataFolder::open(dir.path()), Err(JobsError::InUse { .. })));
        drop(first);
        DataFolder::open(dir.path()).unwrap();
    }

    #[test]
    fn without_the_file_of_the_lock_the_folder_is_still_taken() {
        let dir = tempfile::tempdir().unwrap();
        let first = DataFolder::open(dir.path()).unwrap();
        std::fs::remove_file(dir.path().join("lock")).unwrap();
        first.check_locks().unwrap();
        assert!(matches!(DataFolder::open(dir.path()), Err(JobsError::InUse { .. })));
        std::fs::rename(dir.path().join("runs"), dir.path().join("before")).unwrap();
        let second = DataFolder::open(dir.path()).unwrap();
        assert!(matches!(first.check_locks(), Err(JobsError::Replaced { .. })));
        second.check_locks().unwrap();
    }

    #[test]
    fn what_is_removed_is_of_one_job() {
        let dir = tempfile::tempdir().unwrap();
        let folder = DataFolder::open(dir.path()).unwrap();
        let [id, other] = [JobId::now_v7(), JobId::now_v7()];
        for id in [id, other] {
            std::fs::write(folder.recording(id), b"abc").unwrap();
        }
        folder.remove(id).unwrap();
        folder.remove(id).unwrap();
        assert!(!folder.recording(id).exists() && folder.recording(other).exists());
        folder.remove_leftovers().unwrap();
        assert!(!folder.recording(other).exists());
    }
}
