//! Files that still grow: one folder that one process may use, with the recordings of its runs, snapshots of them, and uploads.
//!
//! A run writes `<id>.mcap.partial`, and its recorder gives the file its name when it is whole; then it can become a
//! [blob](crate::service::blobs). Everything else that a job has begins with `<id>.` too, so that it can be found when the job
//! goes.

use super::{JobId, JobsError};
use sha2::{Digest, Sha256};
use std::fs::{File, TryLockError};
use std::io::{self, Read};
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
        for folder in [
            root.to_owned(),
            root.join("recordings"),
            root.join("meshes"),
            root.join("uploads"),
            root.join("results"),
        ] {
            std::fs::create_dir_all(&folder).map_err(|e| JobsError::file(&folder, e))?;
        }
        let lock_file = root.join("lock");
        let lock = File::create(&lock_file).map_err(|e| JobsError::file(&lock_file, e))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(JobsError::InUse { path: root.to_owned() }),
            Err(TryLockError::Error(e)) => return Err(JobsError::file(&lock_file, e)),
        }
        let folder = Self { root: root.to_owned(), _lock: lock };
        folder.sweep()?;
        Ok(folder)
    }

    /// The file of a job store that is one.
    pub fn store_file(&self) -> PathBuf {
        self.root.join("jobs.sqlite")
    }

    /// Results by content.
    pub fn results(&self) -> PathBuf {
        self.root.join("results")
    }

    /// Uploads that have not ended yet.
    pub fn uploads(&self) -> PathBuf {
        self.root.join("uploads")
    }

    /// The recording of a job until it is a blob.
    pub fn recording(&self, id: JobId) -> PathBuf {
        self.root.join("recordings").join(format!("{id}.mcap"))
    }

    /// Removes whatever a job left.
    ///
    /// # Errors
    /// When a file is there and stays.
    pub fn remove_recordings(&self, id: JobId) -> Result<(), JobsError> {
        self.remove_files(id, "")
    }

    /// Removes the files of a job whose name goes on like this after the id and a point.
    fn remove_files(&self, id: JobId, rest: &str) -> Result<(), JobsError> {
        let folder = self.root.join("recordings");
        let beginning = format!("{id}.{rest}");
        for entry in std::fs::read_dir(&folder).map_err(|e| JobsError::file(&folder, e))? {
            let entry = entry.map_err(|e| JobsError::file(&folder, e))?;
            if entry.file_name().to_str().is_some_and(|name| name.starts_with(&beginning)) {
                remove(&entry.path())?;
            }
        }
        Ok(())
    }

    /// Whether the disk takes what is written: a small file is written and removed.
    ///
    /// # Errors
    /// When it does not.
    pub fn try_write(&self) -> Result<(), JobsError> {
        let file = self.uploads().join(format!("try-{}", JobId::new_v4()));
        let written = std::fs::write(&file, vec![0; 64 << 10]).map_err(|e| JobsError::file(&file, e));
        remove(&file).and(written)
    }

    /// What a snapshot of the recording of a job that runs is called.
    pub fn snapshot(&self, id: JobId, number: u32) -> PathBuf {
        self.root.join("recordings").join(format!("{id}.{SNAPSHOT}{number}.mcap"))
    }

    /// Removes the snapshots of a job.
    ///
    /// # Errors
    /// When a file is there and stays.
    pub fn remove_snapshots(&self, id: JobId) -> Result<(), JobsError> {
        self.remove_files(id, SNAPSHOT)
    }

    /// Removes what the process before this one can have left: uploads that will never end, snapshots that nobody knows.
    fn sweep(&self) -> Result<(), JobsError> {
        for (folder, mark) in [(self.uploads(), ""), (self.root.join("recordings"), SNAPSHOT)] {
            for entry in std::fs::read_dir(&folder).map_err(|e| JobsError::file(&folder, e))? {
                let entry = entry.map_err(|e| JobsError::file(&folder, e))?;
                if entry.file_name().to_str().is_some_and(|name| name.contains(mark)) {
                    remove(&entry.path())?;
                }
            }
        }
        Ok(())
    }
}

/// In the name of a snapshot, before its number.
const SNAPSHOT: &str = "snapshot-";

/// Size and digest of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileDigest {
    /// Its size [bytes].
    pub bytes: u64,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

impl FileDigest {
    /// Reads to the end.
    ///
    /// # Errors
    /// When that fails.
    pub fn of(mut input: impl Read) -> io::Result<Self> {
        let mut sha = Sha256::new();
        let mut buffer = vec![0_u8; 1 << 20];
        let mut bytes = 0;
        loop {
            let n = input.read(&mut buffer)?;
            if n == 0 {
                return Ok(Self { bytes, sha256: hexadecimal(&sha.finalize()) });
            }
            sha.update(&buffer[..n]);
            bytes += n as u64;
        }
    }
}

/// Lower-case hexadecimal digits of bytes.
pub fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Removes a file that may be there.
fn remove(path: &Path) -> Result<(), JobsError> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(JobsError::file(path, e)),
        _ => Ok(()),
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
        folder.remove_recordings(id).unwrap();
        folder.remove_recordings(id).unwrap();
        assert!(!folder.recording(id).exists() && folder.recording(other).exists());
    }

    #[test]
    fn a_digest_is_that_of_the_bytes() {
        let digest = FileDigest::of(&b"abc"[..]).unwrap();
        assert_eq!(digest.bytes, 3);
        // SHA-256 of "abc", FIPS 180-2, appendix B.1.
        assert_eq!(digest.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
