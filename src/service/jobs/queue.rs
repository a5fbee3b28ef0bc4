//! What can be asked of jobs, and what is done with them at the start.

use super::control::{RunControl, StopReason};
use super::data_folder::DataFolder;
use super::engine::Engine;
use super::failures::worker_lost;
use super::snapshots::{Snapshot, Snapshots, Which};
use super::store::{
    CancelAnswer, ClaimedJob, DeleteAnswer, JobEnd, JobStore, NewJob, Orphan, OwnerWish, Requeued, Submitted,
};
use super::{FinalRecording, JobId, JobsError};
use crate::blobs::{BlobDigest, BlobError, BlobStore, Draft};
use crate::record::partial_path;
use crate::service::config::ServiceConfig;
use crate::service::meshes::MeshShelf;
use crate::service::metrics::Metrics;
use crate::service::shelves::{MESHES, RECORDINGS, SNAPSHOTS, is_recording, recording_name};
use crate::step::Ending;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::{Notify, broadcast, watch};

/// Where the service keeps what it has.
#[derive(Debug)]
pub struct Storage {
    /// The jobs.
    pub jobs: Arc<dyn JobStore>,
    /// Recordings, snapshots, meshes, results.
    pub blobs: Arc<dyn BlobStore>,
    /// The files that still grow.
    pub folder: DataFolder,
}

/// The queue: the store, the workers' brakes, and the bell that rings when something happened to a job.
pub struct Queue {
    /// The job store.
    pub store: Arc<dyn JobStore>,
    /// Recordings, snapshots, meshes, results.
    pub blobs: Arc<dyn BlobStore>,
    /// The simulator.
    pub engine: Arc<dyn Engine>,
    /// The files that still grow.
    pub folder: DataFolder,
    /// Limits.
    pub config: Arc<ServiceConfig>,
    /// Counters.
    pub metrics: Arc<Metrics>,
    running: Mutex<BTreeMap<JobId, Arc<RunControl>>>,
    snapshots: Snapshots,
    arrivals: Notify,
    bell: broadcast::Sender<i64>,
    closing: watch::Sender<bool>,
}

impl Queue {
    /// A queue that takes over what the process before it left: jobs that ran wait again, or end if they lost their
    /// worker too often.
    ///
    /// # Errors
    /// When the store or the files fail.
    pub async fn open(
        storage: Storage,
        config: Arc<ServiceConfig>,
        engine: Arc<dyn Engine>,
        metrics: Arc<Metrics>,
    ) -> Result<Arc<Self>, JobsError> {
        let Storage { jobs: store, blobs, folder } = storage;
        let snapshots = Snapshots::new(Arc::clone(&engine), Arc::clone(&blobs));
        let queue = Arc::new(Self {
            store,
            blobs,
            engine,
            folder,
            config,
            metrics,
            running: Mutex::default(),
            snapshots,
            arrivals: Notify::new(),
            bell: broadcast::channel(256).0,
            closing: watch::channel(false).0,
        });
        queue.recover().await?;
        queue.sweep().await?;
        Ok(queue)
    }

    /// Settles what the process before this one left.
    async fn recover(self: &Arc<Self>) -> Result<(), JobsError> {
        for Orphan { seq, id, attempt, wish } in self.store.orphans().await? {
            let fate = Fate::of(wish, attempt, self.config.max_attempts);
            tracing::warn!(job = %id, attempt, ?fate, "found a job without its worker");
            let ending = match fate {
                Fate::Requeue => {
                    self.with_files(move |queue| queue.remove_files(id)).await?;
                    self.store.requeue(seq, attempt, Requeued::WorkerLost).await?;
                    continue;
                }
                Fate::Erase => {
                    self.with_files(move |queue| queue.remove_files(id)).await?;
                    self.store.erase(seq).await?;
                    continue;
                }
                Fate::Cancel => Ending::Cancelled,
                Fate::GiveUp => worker_lost(attempt).into(),
            };
            let recording = self.with_files(move |queue| queue.keep_recording(id, false)).await?;
            let end = JobEnd { ending, summary: None, recording, progress: None };
            self.store.finish(seq, attempt, &end).await?;
        }
        Ok(())
    }

    /// Removes what the process before this one left and nothing refers to: files of runs, snapshots, uploads that were not noted.
    async fn sweep(self: &Arc<Self>) -> Result<(), JobsError> {
        let known = self.store.blobs().await?;
        self.with_files(move |queue| {
            queue.folder.sweep()?;
            for shelf in [SNAPSHOTS, MESHES, RECORDINGS] {
                let unknown =
                    queue.blobs.list(shelf)?.into_iter().filter(|entry| !known.contains(&entry.name));
                let (recordings, rest): (Vec<_>, Vec<_>) =
                    unknown.partition(|entry| is_recording(&entry.name));
                // Nothing here leaves a recording without its job: who put an older job store in place decides what becomes of it.
                for entry in &recordings {
                    tracing::warn!(blob = entry.name, "no job has this recording");
                }
                rest.iter().try_for_each(|entry| queue.blobs.delete(&entry.name))?;
            }
            Ok(())
        })
        .await
    }

    /// Fails unless the store of blobs takes what is written.
    ///
    /// # Errors
    /// Why it does not.
    pub fn try_write(&self) -> Result<(), JobsError> {
        let mut draft = Draft::new(self.blobs.unnamed()?, u64::MAX);
        Ok(draft.append(&vec![0; 64 << 10])?)
    }

    /// Work that waits for files, away from the threads of the runtime.
    ///
    /// # Errors
    /// Those of the work; and when it panics.
    pub async fn with_files<T: Send + 'static>(
        self: &Arc<Self>,
        work: impl FnOnce(&Self) -> Result<T, JobsError> + Send + 'static,
    ) -> Result<T, JobsError> {
        let queue = Arc::clone(self);
        let working = tokio::task::spawn_blocking(move || work(&queue));
        working
            .await
            .unwrap_or_else(|error| Err(JobsError::file("the data folder", std::io::Error::other(error))))
    }

    /// The recording that an ended run left, a blob from now on, with its digest. One that its writer did not close is mended
    /// first; nothing when nothing of it can be read.
    pub(super) fn keep_recording(
        &self,
        id: JobId,
        complete: bool,
    ) -> Result<Option<FinalRecording>, JobsError> {
        let (file, name) = (self.folder.recording(id), recording_name(id));
        if !file.exists()
            && partial_path(&file).exists()
            && let Err(reason) = self.engine.mend_recording(&file)
        {
            tracing::warn!(job = %id, reason, "nothing of the recording can be read");
            self.remove_files(id)?;
        }
        let BlobDigest { bytes, sha256 } = if file.exists() {
            self.blobs.adopt(&file, &name)?
        } else {
            // The process before this one may have come so far.
            let Some(blob) = self.blobs.open(&name)? else { return Ok(None) };
            BlobDigest::of(blob).map_err(BlobError::of(name))?
        };
        Ok(Some(FinalRecording { bytes, sha256, complete }))
    }

    /// Removes whatever a job left.
    pub(super) fn remove_files(&self, id: JobId) -> Result<(), JobsError> {
        self.folder.remove(id)?;
        Ok(self.blobs.delete(&recording_name(id))?)
    }

    /// Keeps a new job; it is durable when this returns.
    ///
    /// # Errors
    /// `QueueFull`, or when the store fails.
    pub async fn submit(&self, new: &NewJob) -> Result<Submitted, JobsError> {
        let submitted = self.store.submit(new, self.config.max_queued).await?;
        if let Submitted::Created(job) = &submitted {
            tracing::info!(job = %job.id, name = new.name, "accepted");
            self.arrivals.notify_one();
            self.ring(job.seq);
        }
        Ok(submitted)
    }

    /// Cancels a job that waits; stops one that runs.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn cancel(&self, owner: &str, id: JobId) -> Result<CancelAnswer, JobsError> {
        let answer = self.store.cancel(owner, id).await?;
        match answer {
            CancelAnswer::Cancelled { seq } => self.ring(seq),
            CancelAnswer::Stopping => self.stop(id, StopReason::Cancel),
            _ => {}
        }
        Ok(answer)
    }

    /// Deletes a job: nobody can ask for it from now on. The files of a job that runs go when its worker has let go of
    /// them, a step or two later. False when there is no such job.
    ///
    /// # Errors
    /// When the store or the files fail.
    pub async fn delete(self: &Arc<Self>, owner: &str, id: JobId) -> Result<bool, JobsError> {
        let hidden = match self.store.hide(owner, id).await {
            // What fills the disk is what shall go: the note of it finds room after that.
            Err(error) if error.is_storage_full() => {
                let job = self.store.job(owner, id).await?;
                if job.is_none_or(|job| !job.state.is_final()) {
                    return Err(error);
                }
                self.with_files(move |queue| queue.remove_files(id)).await?;
                self.store.hide(owner, id).await?
            }
            other => other?,
        };
        match hidden {
            DeleteAnswer::Unknown => return Ok(false),
            DeleteAnswer::Running { seq } => {
                self.stop(id, StopReason::Cancel);
                self.ring(seq);
            }
            DeleteAnswer::Idle { seq } => {
                self.with_files(move |queue| queue.remove_files(id)).await?;
                self.store.erase(seq).await?;
                self.ring(seq);
            }
        }
        Ok(true)
    }

    /// The next job to run; waits for one. `None` when the service shuts down.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn next(&self) -> Result<Option<(ClaimedJob, Arc<RunControl>)>, JobsError> {
        let mut closing = self.closing.subscribe();
        loop {
            // Registered before the look into the store, so that no arrival falls between the two.
            let arrival = self.arrivals.notified();
            if *closing.borrow_and_update() {
                return Ok(None);
            }
            if let Some(job) = self.store.claim().await? {
                // One arrival wakes one worker; there may be work for another.
                self.arrivals.notify_one();
                let control = self.take_control(&job).await;
                self.ring(job.seq);
                return Ok(Some((job, control)));
            }
            tokio::select! {
                () = arrival => {}
                _ = closing.changed() => {}
            }
        }
    }

    /// The brake of a job that begins, pulled already if its owner cancelled or deleted it in between.
    async fn take_control(&self, job: &ClaimedJob) -> Arc<RunControl> {
        let control = Arc::new(RunControl::new(self.config.deadline));
        self.controls().insert(job.id, Arc::clone(&control));
        match self.store.wish(job.seq).await {
            Ok(OwnerWish::Stop | OwnerWish::Deletion) => control.stop(StopReason::Cancel),
            Ok(OwnerWish::Result) => {}
            // The job is claimed and has to run: a cancel that was missed here is only late.
            Err(error) => tracing::warn!(job = %job.id, %error, "could not see whether it is still wanted"),
        }
        control
    }

    /// Lets go of the brake of a job that has ended.
    pub(super) fn release(&self, job: &ClaimedJob) {
        self.controls().remove(&job.id);
        self.snapshots.close(job.id);
        self.ring(job.seq);
    }

    /// What can be seen of the recording of a job that runs. Copies files: not for threads of the runtime.
    ///
    /// # Errors
    /// When the files fail.
    pub fn snapshot(&self, id: JobId, which: &Which) -> Result<Option<Snapshot>, JobsError> {
        if !self.controls().contains_key(&id) {
            return Ok(None);
        }
        self.snapshots.look(&self.folder, id, which)
    }

    /// The meshes that an owner's scenes may name. To be used outside the threads of the runtime only.
    pub fn shelf(&self, owner: &str) -> MeshShelf {
        let runtime = tokio::runtime::Handle::current();
        MeshShelf::new(Arc::clone(&self.blobs), Arc::clone(&self.store), owner.to_owned(), runtime)
    }

    /// A bell that names the job that something happened to.
    pub fn listen(&self) -> broadcast::Receiver<i64> {
        self.bell.subscribe()
    }

    /// True from the moment on that the service shuts down.
    pub fn closing(&self) -> watch::Receiver<bool> {
        self.closing.subscribe()
    }

    /// Whether the service shuts down.
    pub fn is_closing(&self) -> bool {
        *self.closing.borrow()
    }

    /// No job is taken up from now on.
    pub fn close(&self) {
        self.closing.send_replace(true);
    }

    /// Stops what runs; it goes back to the queue.
    pub fn interrupt_all(&self) {
        for control in self.controls().values() {
            control.stop(StopReason::Shutdown);
        }
    }

    /// Rings the bell for a job. Nobody may be listening, and that is fine.
    pub(super) fn ring(&self, seq: i64) {
        let _ = self.bell.send(seq);
    }

    fn stop(&self, id: JobId, reason: StopReason) {
        if let Some(control) = self.controls().get(&id) {
            control.stop(reason);
        }
    }

    fn controls(&self) -> std::sync::MutexGuard<'_, BTreeMap<JobId, Arc<RunControl>>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What becomes of a job whose worker was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// It waits again.
    Requeue,
    /// Its owner had cancelled it.
    Cancel,
    /// It lost its worker too often.
    GiveUp,
    /// Its owner had deleted it.
    Erase,
}

impl Fate {
    fn of(wish: OwnerWish, attempt: u32, max_attempts: u32) -> Self {
        match wish {
            OwnerWish::Deletion => Self::Erase,
            OwnerWish::Stop => Self::Cancel,
            OwnerWish::Result if attempt >= max_attempts => Self::GiveUp,
            OwnerWish::Result => Self::Requeue,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orphans_have_the_fate_that_they_deserve() {
        let fates = |max_attempts| {
            let wishes = [OwnerWish::Result, OwnerWish::Stop, OwnerWish::Deletion];
            wishes.map(|wish| Fate::of(wish, 1, max_attempts))
        };
        assert_eq!(fates(2), [Fate::Requeue, Fate::Cancel, Fate::Erase]);
        assert_eq!(fates(1), [Fate::GiveUp, Fate::Cancel, Fate::Erase]);
    }
}
