//! Whether the disk can store what jobs leave: its free space, files that it accepts, and runs that wait for either.

use super::queue::Queue;
use super::{JobId, JobsError};
use crate::service::clock;
use std::io::ErrorKind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

/// Free space without which nothing can be stored [bytes].
const LEAST_OF_ANY: u64 = 1 << 20;
/// How long it counts that the disk accepted a file.
const WRITTEN_HOLDS: Duration = Duration::from_secs(1);

/// How long a disk that accepts files may refuse a recording.
const LONGEST_REFUSAL: Duration = Duration::from_secs(1);
/// How long an object store that answers may refuse access.
const LONGEST_REFUSAL_AFAR: Duration = Duration::from_secs(60);

/// A run that has ended and waits for the storage, until this is dropped.
pub(super) struct EndWaits(Arc<AtomicUsize>);

impl Drop for EndWaits {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Queue {
    /// Checks that the data folder is that of this process, that a job can be dated, and that the disk has room for one, and accepted a file
    /// a moment ago.
    ///
    /// # Errors
    /// `Replaced`, `WrongClock`, `DiskShort`, `EndsWait`, or why the disk accepts no writes.
    pub(super) fn check_disk(&self) -> Result<(), JobsError> {
        self.folder.check_locks()?;
        if !clock::is_plausible() {
            return Err(JobsError::WrongClock);
        }
        self.check_space()?;
        // What waits for an object store leaves the disk to others.
        if !self.has_distant_blobs() {
            self.check_ends()?;
        }
        let last = || self.written.lock().unwrap_or_else(PoisonError::into_inner);
        if last().is_some_and(|at| at.elapsed() < WRITTEN_HOLDS) {
            return Ok(());
        }
        self.folder.try_write()?;
        *last() = Some(Instant::now());
        Ok(())
    }

    /// Checks that no run that has ended waits for the storage.
    ///
    /// # Errors
    /// `EndsWait`
    pub(super) fn check_ends(&self) -> Result<(), JobsError> {
        let ends = self.ends.load(Ordering::SeqCst);
        if ends > 0 { Err(JobsError::EndsWait { ends }) } else { Ok(()) }
    }

    /// How long a storage that answers may refuse a recording with an error before that is given up: rights to an object store may be back
    /// within a moment, or its probes notice that they are not.
    pub(super) fn longest_refusal(&self, error: &JobsError) -> Duration {
        let is_of_access = error.io_kind() == Some(ErrorKind::PermissionDenied);
        if self.has_distant_blobs() && is_of_access { LONGEST_REFUSAL_AFAR } else { LONGEST_REFUSAL }
    }

    /// Checks that the disk has room for a job, or a mesh.
    ///
    /// # Errors
    /// `DiskShort`, or why the free space is not known.
    pub fn check_space(&self) -> Result<(), JobsError> {
        let (free, least) = (self.folder.free_space()?, self.config.least_free);
        if free < least { Err(JobsError::DiskShort { free, least }) } else { Ok(()) }
    }

    /// Checks that the disk would have room for a job without the files of one that has run, and accepts files where these do not fill it.
    ///
    /// # Errors
    /// `DiskShort`, or why the disk accepts no files.
    pub(super) fn check_disk_without(&self, id: JobId) -> Result<(), JobsError> {
        let (free, own) = (self.folder.free_space()?, self.folder.bytes(id)?);
        let least = self.config.least_free.max(LEAST_OF_ANY);
        if free.saturating_add(own) < least {
            return Err(JobsError::DiskShort { free, least });
        }
        if free < least { Ok(()) } else { self.folder.try_write() }
    }

    /// Whether an error at the end of a run is one of the storage, which may come back: of the machine and its disk, unless the files of
    /// the run itself fill that, or since the object store does not answer. Blocks on it.
    pub(super) fn is_storage_away(&self, id: JobId, error: &JobsError) -> bool {
        let fills_disk = || error.is_storage_full() && self.check_disk_without(id).is_ok();
        if self.has_distant_blobs() { self.is_cut_off() } else { error.is_of_machine() && !fills_disk() }
    }

    /// Lets no job begin here as long as the result is kept, or be submitted if it is the disk: a run that has ended waits for the storage.
    pub(super) fn end_waits(&self) -> EndWaits {
        self.ends.fetch_add(1, Ordering::SeqCst);
        EndWaits(Arc::clone(&self.ends))
    }
}
