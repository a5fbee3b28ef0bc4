//! What of the service is in the files of this machine and in no store of blobs: the file of the job store, the recordings that are
//! still written. One process may use the folder.
//!
//! A run writes `runs/<id>.mcap.partial`, and its recorder gives the file its name when it is whole; then it becomes a
//! [blob](crate::blobs). Everything else that a run writes begins with `<id>.` too, so that it can be found when the job goes.

use super::{JobId, JobsError};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// The data folder, locked for this process as long as this value lives.
#[derive(Debug)]
pub struct DataFolder {
    root: PathBuf,
    // Held for its lock, which the system releases however the process ends.
    _lock: File,
}

impl DataFolder {
    /// Takes a folder, and makes it and its rooms if need be.
    ///
    /// # Errors
    /// `InUse` when another process has it; `File` when it cannot be made.
    pub fn open(root: &Path) -> Result<Self, JobsError> {
        let folder = root.join("runs");
        std::fs::create_dir_all(&folder).map_err(|e| JobsError::file(&folder, e))?;
        let lock_file = root.join("lock");
        let lock = File::create(&lock_file).map_err(|e| JobsError::file(&lock_file, e))?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { root: root.to_owned(), _lock: lock }),
            Err(TryLockError::WouldBlock) => Err(JobsError::InUse { path: root.to_owned() }),
            Err(TryLockError::Error(e)) => Err(JobsError::file(&lock_file, e)),
        }
    }

    /// The file of a job store that is one.
    pub fn store_file(&self) -> PathBuf {
        self.root.join("jobs.sqlite")
    }

    /// The recording of a job until it is a blob.
    pub fn recording(&self, id: JobId) -> PathBuf {
        self.root.join("runs").join(format!("{id}.mcap"))
    }

    /// A snapshot of the recording of a job until it is a blob.
    pub fn snapshot(&self, id: JobId) -> PathBuf {
        self.root.join("runs").join(format!("{id}.snapshot.mcap"))
    }

    /// Removes whatever a run of a job left.
    ///
    /// # Errors
    /// When a file is there and stays.
    pub fn remove(&self, id: JobId) -> Result<(), JobsError> {
        self.remove_all(&format!("{id}."))
    }

    /// Removes whatever runs left. Only while there is none.
    ///
    /// # Errors
    /// When a file is there and stays.
    pub fn sweep(&self) -> Result<(), JobsError> {
        self.remove_all("")
    }

    /// Removes the files of runs whose names begin so.
    fn remove_all(&self, beginning: &str) -> Result<(), JobsError> {
        let folder = self.root.join("runs");
        for entry in std::fs::read_dir(&folder).map_err(|e| JobsError::file(&folder, e))? {
            let entry = entry.map_err(|e| JobsError::file(&folder, e))?;
            if entry.file_name().to_str().is_some_and(|name| name.starts_with(beginning)) {
                std::fs::remove_file(entry.path()).map_err(|e| JobsError::file(entry.path(), e))?;
            }
        }
        Ok(())
    }
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
        folder.sweep().unwrap();
        assert!(!folder.recording(other).exists());
    }
}
