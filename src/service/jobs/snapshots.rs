//! Snapshots of recordings that are still being written: numbered blobs.
//!
//! A growing file must not be downloaded, since its parts would not match. A snapshot is taken on request if the last
//! one is too old; the last few are kept, so that partial downloads can be completed.

use super::data_folder::DataFolder;
use super::engine::Engine;
use super::{JobId, JobsError};
use crate::blobs::{BlobDigest, BlobStore};
use crate::record::partial_path;
use crate::service::shelves::snapshot_name;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Number of snapshots kept for a job.
const KEPT: usize = 3;
/// Minimum age of a snapshot before another is taken.
const LEAST_AGE: Duration = Duration::from_secs(1);
/// A snapshot copies the recording so far; the copies take at most one part in this many of the time.
const TIMES_COST: u32 = 10;

/// A blob with the state of a run at one time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snapshot {
    /// Number of the snapshot, from 1.
    pub number: u32,
    /// Size and digest of the blob.
    pub digest: BlobDigest,
}

/// Selects a snapshot of a running job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Which {
    /// The one with this digest if it is still kept, otherwise the latest.
    OfDigest(String),
    /// The one with this number.
    Number(u32),
    /// The snapshot taken last.
    Latest,
}

/// Snapshots of all running jobs.
pub struct Snapshots {
    engine: Arc<dyn Engine>,
    blobs: Arc<dyn BlobStore>,
    albums: Mutex<BTreeMap<JobId, Arc<Mutex<Album>>>>,
}

/// Snapshots of one job.
#[derive(Debug, Default)]
struct Album {
    kept: VecDeque<Snapshot>,
    last_number: u32,
    /// When the last one was taken, how long that took, and how long the partial file was.
    last: Option<(Instant, Duration, u64)>,
    /// The run is over: no further snapshots are taken.
    closed: bool,
}

impl Snapshots {
    /// An empty collection of snapshots.
    pub fn new(engine: Arc<dyn Engine>, blobs: Arc<dyn BlobStore>) -> Self {
        Self { engine, blobs, albums: Mutex::default() }
    }

    /// A snapshot of a running job; `None` if it does not exist, or there is nothing to see yet. Copies files: not for
    /// threads of the runtime.
    ///
    /// # Errors
    /// If the files fail.
    pub fn look(&self, folder: &DataFolder, id: JobId, which: &Which) -> Result<Option<Snapshot>, JobsError> {
        let album =
            Arc::clone(self.albums.lock().unwrap_or_else(PoisonError::into_inner).entry(id).or_default());
        // One at a time for each job; the second request finds the snapshot of the first.
        let mut album = album.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = |album: &Album| match which {
            Which::OfDigest(sha256) => album.kept.iter().find(|s| s.digest.sha256 == *sha256).cloned(),
            Which::Number(number) => album.kept.iter().find(|s| s.number == *number).cloned(),
            Which::Latest => None,
        };
        if let Some(snapshot) = kept(&album) {
            return Ok(Some(snapshot));
        }
        if matches!(which, Which::Number(_)) {
            return Ok(None);
        }
        self.renew(&mut album, folder, id)?;
        Ok(album.kept.back().cloned())
    }

    /// Removes the snapshots of a job that has ended.
    pub fn close(&self, id: JobId) {
        let album = self.albums.lock().unwrap_or_else(PoisonError::into_inner).remove(&id);
        let Some(album) = album else { return };
        let mut album = album.lock().unwrap_or_else(PoisonError::into_inner);
        album.closed = true;
        album.kept.drain(..).for_each(|old| self.forget(id, &old));
    }

    /// Deletes a snapshot; downloads in progress can finish.
    fn forget(&self, id: JobId, old: &Snapshot) {
        if let Err(error) = self.blobs.delete(&snapshot_name(id, old.number)) {
            tracing::warn!(job = %id, %error, "a snapshot stays");
        }
    }

    /// Takes another snapshot if the last one is too old and the recording has grown.
    fn renew(&self, album: &mut Album, folder: &DataFolder, id: JobId) -> Result<(), JobsError> {
        let recording = folder.recording(id);
        let Ok(partial) = std::fs::metadata(partial_path(&recording)) else { return Ok(()) };
        let is_fresh = album.last.is_some_and(|(taken, cost, length)| {
            taken.elapsed() < LEAST_AGE.max(cost * TIMES_COST) || length == partial.len()
        });
        if album.closed || is_fresh {
            return Ok(());
        }
        let started = Instant::now();
        let number = album.last_number + 1;
        let path = folder.snapshot(id);
        if let Err(reason) = self.engine.snapshot(&recording, &path) {
            // The run has ended in between, or has not written anything readable.
            tracing::debug!(job = %id, reason, "no snapshot");
            return Ok(());
        }
        let digest = self.blobs.adopt(&path, &snapshot_name(id, number))?;
        album.last_number = number;
        album.last = Some((Instant::now(), started.elapsed(), partial.len()));
        album.kept.push_back(Snapshot { number, digest });
        if album.kept.len() > KEPT
            && let Some(old) = album.kept.pop_front()
        {
            self.forget(id, &old);
        }
        Ok(())
    }
}
