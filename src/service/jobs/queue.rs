//! Operations on jobs, and recovery at the start.

use super::allowance::{allowed, expected_within};
use super::control::{RunControl, StopReason};
use super::data_folder::DataFolder;
use super::engine::Engine;
use super::pulse::Pulse;
use super::removals::Removals;
use super::room::Room;
use super::snapshots::{Snapshot, Snapshots, Which};
use super::store::{CancelAnswer, ClaimedJob, JobStore, NewJob, OwnerRequest, Requeued, Submitted};
use super::{FinalRecording, JobId, JobsError};
use crate::blobs::{BlobDigest, BlobError, BlobStore};
use crate::record::partial_path;
use crate::service::config::ServiceConfig;
use crate::service::meshes::MeshShelf;
use crate::service::metrics::{Metrics, Reading};
use crate::service::shelves::{recording_name, recording_names};
use crate::study::process::resident_memory_bytes;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::{Notify, broadcast, watch};
use tokio::task::JoinSet;
use tracing::Instrument as _;

/// Time between two looks at a storage that lets no job begin.
const ROOM_INTERVAL: Duration = Duration::from_secs(2);
/// Time between two looks at an attempt that is stopping.
const STOPPING_INTERVAL: Duration = Duration::from_millis(50);

/// Storage of the service.
#[derive(Debug)]
pub struct Storage {
    /// Store of the jobs.
    pub jobs: Arc<dyn JobStore>,
    /// Recordings, snapshots, meshes, results.
    pub blobs: Arc<dyn BlobStore>,
    /// Whether the store of blobs answers, if it is on other machines.
    pub pulse: Option<Arc<Pulse>>,
    /// Local folder of files still being written.
    pub folder: DataFolder,
}

/// An attempt that runs here.
#[derive(Clone, Debug)]
pub struct Held {
    /// Number of the job.
    pub seq: i64,
    /// Number of the attempt.
    pub attempt: u32,
    /// What stops it.
    pub control: Arc<RunControl>,
}

/// The queue: the store, the controls of running jobs, and a channel that announces events of jobs.
pub struct Queue {
    /// Store of the jobs.
    pub store: Arc<dyn JobStore>,
    /// Recordings, snapshots, meshes, results.
    pub blobs: Arc<dyn BlobStore>,
    /// Engine that runs the jobs.
    pub engine: Arc<dyn Engine>,
    /// Local folder of files still being written.
    pub folder: DataFolder,
    /// Limits of the service.
    pub config: Arc<ServiceConfig>,
    /// Counters served to Prometheus.
    pub metrics: Arc<Metrics>,
    /// What is deleted and not yet removed.
    pub removals: Arc<Removals>,
    /// Room for uploads that are under way.
    pub(super) room: Arc<Room>,
    /// Read while a mesh is kept and registered, written while one that no one has is removed: the same one may come meanwhile. Stores
    /// that are shared have locks of their own.
    pub(super) mesh_files: Arc<tokio::sync::RwLock<()>>,
    pulse: Option<Arc<Pulse>>,
    /// Attempts that run here: one of a job.
    running: Mutex<BTreeMap<JobId, Held>>,
    /// When the disk last accepted a file.
    pub(super) written: Mutex<Option<Instant>>,
    /// Runs that have ended and wait for the storage.
    pub(super) ends: Arc<AtomicUsize>,
    /// Memory that each of them may take, and each that waits for an earlier one to stop, by number of job and attempt [bytes].
    memory: tokio::sync::Mutex<BTreeMap<(i64, u32), u64>>,
    snapshots: Snapshots,
    /// What is done for a store that is shared.
    tasks: Mutex<JoinSet<()>>,
    arrivals: Notify,
    /// Jobs with new events; `None` for any.
    notifications: broadcast::Sender<Option<i64>>,
    closing: watch::Sender<bool>,
}

impl Queue {
    /// A queue of the jobs in a storage.
    pub fn new(
        storage: Storage,
        config: Arc<ServiceConfig>,
        engine: Arc<dyn Engine>,
        metrics: Arc<Metrics>,
    ) -> Arc<Self> {
        let Storage { jobs: store, blobs, pulse, folder } = storage;
        let snapshots = Snapshots::new(Arc::clone(&engine), Arc::clone(&blobs));
        Arc::new(Self {
            store,
            blobs,
            engine,
            folder,
            config,
            metrics,
            removals: Arc::default(),
            room: Arc::default(),
            mesh_files: Arc::default(),
            pulse,
            running: Mutex::default(),
            written: Mutex::default(),
            ends: Arc::default(),
            memory: tokio::sync::Mutex::default(),
            snapshots,
            tasks: Mutex::default(),
            arrivals: Notify::new(),
            notifications: broadcast::channel(256).0,
            closing: watch::channel(false).0,
        })
    }

    /// Checks that the disk has room for a job, and accepts writes, that no run waits for the storage, and that the object store answered
    /// when it was last asked.
    ///
    /// # Errors
    /// `DiskShort`, `EndsWait`, `BlobStoreSilent`, or why the disk accepts no writes.
    pub fn check_storage(&self) -> Result<(), JobsError> {
        self.check_pulse()?;
        self.check_ends()?;
        self.check_disk()
    }

    /// Checks that the object store answered when it was last asked.
    pub(super) fn check_pulse(&self) -> Result<(), JobsError> {
        if self.pulse.as_ref().is_none_or(|pulse| pulse.is_felt()) {
            Ok(())
        } else {
            Err(JobsError::BlobStoreSilent)
        }
    }

    /// Waits for work on blobs, unless the object store does not answer: the work is given up with its client, or goes on unheard.
    ///
    /// # Errors
    /// `BlobStoreSilent`
    pub async fn unless_silent<T>(&self, work: impl Future<Output = T>) -> Result<T, JobsError> {
        let Some(pulse) = &self.pulse else { return Ok(work.await) };
        tokio::select! {
            biased;
            () = pulse.lost() => Err(JobsError::BlobStoreSilent),
            done = work => Ok(done),
        }
    }

    /// Waits until the object store answers.
    pub async fn blobs_answer(&self) {
        if let Some(pulse) = &self.pulse {
            pulse.felt().await;
        }
    }

    /// Whether the blobs are on other machines, which do not answer now. Blocks on them.
    pub(super) fn is_cut_off(&self) -> bool {
        self.pulse.as_ref().is_some_and(|pulse| !pulse.ask())
    }

    /// Whether the blobs are on other machines.
    pub(super) fn has_distant_blobs(&self) -> bool {
        self.pulse.is_some()
    }

    /// Waits until a job can begin (a disk that accepts no writes lets no job be claimed); false if the service shuts down before.
    async fn wait_for_room(self: &Arc<Self>) -> bool {
        let mut closing = self.closing.subscribe();
        let mut is_reported = false;
        while let Err(error) = self.with_files(Self::check_storage).await {
            if !std::mem::replace(&mut is_reported, true) {
                tracing::error!(%error, "jobs wait for the storage");
            }
            tokio::select! {
                () = tokio::time::sleep(ROOM_INTERVAL) => {}
                _ = closing.wait_for(|closing| *closing) => return false,
            }
        }
        if is_reported {
            tracing::info!("the storage has room again");
        }
        true
    }

    /// Runs work that waits for files outside the runtime's threads.
    ///
    /// # Errors
    /// Errors of the work, or its panic.
    pub async fn with_files<T: Send + 'static>(
        self: &Arc<Self>,
        work: impl FnOnce(&Self) -> Result<T, JobsError> + Send + 'static,
    ) -> Result<T, JobsError> {
        let queue = Arc::clone(self);
        let working = tokio::task::spawn_blocking(move || work(&queue));
        let done = working
            .await
            .unwrap_or_else(|error| Err(JobsError::file("the data folder", std::io::Error::other(error))));
        done.inspect_err(|error| self.metrics.failed(error))
    }

    /// The state of the service at this moment.
    ///
    /// # Errors
    /// If the store fails.
    pub async fn reading(self: &Arc<Self>) -> Result<Reading, JobsError> {
        let taken = self.memory.lock().await.values().fold(0, |sum: u64, bytes| sum.saturating_add(*bytes));
        Ok(Reading {
            jobs: self.store.counts().await?,
            queue_age_s: self.store.queue_age_s().await?,
            removals: self.removals.count(),
            processes: self.engine.processes(),
            running_memory: taken.min(self.config.max_running_memory),
            resident_memory: resident_memory_bytes().unwrap_or(0),
            free_disk: self.with_files(|queue| queue.folder.free_space()).await?,
            job_store_faults: self.store.fault_count(),
            // The log is not of the queue.
            audit_faults: 0,
            blobs_answer: self.check_pulse().is_ok(),
        })
    }

    /// Stores the recording of an ended run as a blob, with its digest. A recording that its writer did not close is
    /// repaired first; `None` if nothing of it can be read.
    pub(super) fn keep_recording(
        &self,
        id: JobId,
        attempt: u32,
        complete: bool,
    ) -> Result<Option<FinalRecording>, JobsError> {
        let (file, name) = (self.folder.recording(id), recording_name(id, attempt));
        if !file.exists() && partial_path(&file).exists() {
            match self.engine.mend_recording(&file) {
                Err(error @ JobsError::Unreadable(_)) => {
                    tracing::warn!(job = %id, %error);
                    self.folder.remove(id)?;
                }
                mended => mended?,
            }
        }
        let BlobDigest { bytes, sha256 } = if file.exists() {
            self.blobs.adopt(&file, &name)?
        } else {
            // The previous process may have completed this step.
            let Some(blob) = self.blobs.open(&name)? else { return Ok(None) };
            BlobDigest::of(blob).map_err(BlobError::of(name))?
        };
        Ok(Some(FinalRecording { bytes, sha256, complete, attempt }))
    }

    /// Removes the files that the attempts at a job have left.
    pub(super) fn remove_files(&self, id: JobId, attempts: u32) -> Result<(), JobsError> {
        self.folder.remove(id)?;
        Ok(recording_names(id, attempts).try_for_each(|name| self.blobs.delete(&name))?)
    }

    /// Removes the recordings that earlier attempts at a job may have left; those that stay are deleted with the job.
    pub(super) fn forget_earlier_recordings(&self, job: &ClaimedJob) {
        for attempt in 1..job.attempt {
            if let Err(error) = self.blobs.delete(&recording_name(job.id, attempt)) {
                tracing::warn!(job = %job.id, attempt, %error, "the recording of an earlier attempt stays");
            }
        }
    }

    /// Stores a new job, which is durable on return.
    ///
    /// # Errors
    /// `QueueFull`, `DiskShort`, or if the store fails, or the disk accepts no recordings.
    pub async fn submit(self: &Arc<Self>, new: &NewJob) -> Result<Submitted, JobsError> {
        self.with_files(Self::check_disk).await?;
        let storing = self.store.submit(new, self.config.quotas());
        let submitted = storing.instrument(tracing::debug_span!("store")).await?;
        if let Submitted::Created(job) = &submitted {
            tracing::info!(job = %job.id, "accepted");
            self.arrivals.notify_one();
            self.ring(Some(job.seq));
        }
        Ok(submitted)
    }

    /// What an owner keeps [bytes]; 0 if owners may keep as much as wanted.
    pub(super) async fn kept_bytes(&self, owner: &str) -> Result<u64, JobsError> {
        if self.config.quotas().let_owners_keep_all() {
            Ok(0)
        } else {
            Ok(self.store.kept(owner).await?.bytes)
        }
    }

    /// Cancels a waiting job, or stops a running one.
    ///
    /// # Errors
    /// If the store fails.
    pub async fn cancel(&self, owner: &str, id: JobId) -> Result<CancelAnswer, JobsError> {
        let answer = self.store.cancel(owner, id).await?;
        match answer {
            CancelAnswer::Cancelled { seq } => self.ring(Some(seq)),
            CancelAnswer::Stopping => self.stop(id, StopReason::Cancel),
            _ => {}
        }
        Ok(answer)
    }

    /// The next job to run; waits for one. `None` if the service shuts down.
    ///
    /// # Errors
    /// If the store fails.
    pub async fn next(self: &Arc<Self>) -> Result<Option<(ClaimedJob, Arc<RunControl>)>, JobsError> {
        let mut closing = self.closing.subscribe();
        loop {
            // Registered before the store is read, so that no arrival is missed in between.
            let arrival = self.arrivals.notified();
            if *closing.borrow_and_update() {
                return Ok(None);
            }
            if !self.wait_for_room().await {
                return Ok(None);
            }
            if let Some(taken) = self.take().await? {
                // One arrival wakes one worker; there may be work for another.
                self.wake();
                return Ok(Some(taken));
            }
            tokio::select! {
                () = arrival => {}
                _ = closing.changed() => {}
            }
        }
    }

    /// The next job to run, if there is one for which the storage and the memory have room.
    ///
    /// # Errors
    /// If the store fails, or the storage lets no job begin.
    pub(super) async fn take(self: &Arc<Self>) -> Result<Option<(ClaimedJob, Arc<RunControl>)>, JobsError> {
        self.with_files(Self::check_storage).await?;
        let Some(job) = self.claim().await? else { return Ok(None) };
        let control = self.take_control(&job).await;
        self.ring(Some(job.seq));
        Ok(Some((job, control)))
    }

    /// Claims the next job whose memory is free; one that would take more than there is runs alone.
    async fn claim(&self) -> Result<Option<ClaimedJob>, JobsError> {
        // Held until the memory of the job is counted.
        let mut taken = self.memory.lock().await;
        let expected = if taken.is_empty() {
            None
        } else {
            let sum = taken.values().fold(0, |sum: u64, bytes| sum.saturating_add(*bytes));
            let free = self.config.max_running_memory.saturating_sub(sum);
            let Some(expected) = expected_within(free) else { return Ok(None) };
            Some(expected)
        };
        let job = self.store.claim(expected).await?;
        if let Some(job) = &job {
            taken
                .insert((job.seq, job.attempt), if job.alone { u64::MAX } else { allowed(job.memory_bytes) });
        }
        Ok(job)
    }

    /// Memory that the run of a job may take [bytes].
    pub(super) fn most_memory(&self, job: &ClaimedJob) -> u64 {
        let all = self.config.max_running_memory;
        if job.alone { all } else { allowed(job.memory_bytes).min(all) }
    }

    /// Control of a job that begins, already stopped if its owner cancelled or deleted it in between.
    async fn take_control(&self, job: &ClaimedJob) -> Arc<RunControl> {
        // An attempt that was taken for lost may still be stopping here.
        while self.has(job.id) {
            tokio::time::sleep(STOPPING_INTERVAL).await;
        }
        let control = Arc::new(RunControl::new(self.config.runs.deadline));
        let held = Held { seq: job.seq, attempt: job.attempt, control: Arc::clone(&control) };
        self.held().insert(job.id, held);
        match self.store.request(job.seq).await {
            Ok(OwnerRequest::Stop | OwnerRequest::Deletion) => control.stop(StopReason::Cancel),
            Ok(OwnerRequest::Result) => {}
            // The job is claimed and must run: a cancellation missed here is only delayed.
            Err(error) => tracing::warn!(job = %job.id, %error, "could not see whether it is still wanted"),
        }
        control
    }

    /// Releases the control of a job that has ended.
    pub(super) async fn release(&self, job: &ClaimedJob) {
        self.memory.lock().await.remove(&(job.seq, job.attempt));
        // The next one may have waited for its memory.
        self.arrivals.notify_one();
        self.held().remove(&job.id);
        self.snapshots.close(job.id);
        self.ring(Some(job.seq));
    }

    /// Snapshot of the recording of a running job. Copies files: not for threads of the runtime.
    ///
    /// # Errors
    /// If the files fail.
    pub fn snapshot(&self, id: JobId, which: &Which) -> Result<Option<Snapshot>, JobsError> {
        if !self.has(id) {
            return Ok(None);
        }
        self.snapshots.look(&self.folder, id, which)
    }

    /// Meshes available to an owner's scenes. Only for use outside the runtime's threads.
    pub fn shelf(&self, owner: &str) -> MeshShelf {
        let runtime = tokio::runtime::Handle::current();
        MeshShelf::new(Arc::clone(&self.blobs), Arc::clone(&self.store), owner.to_owned(), runtime)
    }

    /// Channel that announces the jobs with new events; `None`: any job may have some.
    pub fn listen(&self) -> broadcast::Receiver<Option<i64>> {
        self.notifications.subscribe()
    }

    /// Becomes true when the service shuts down.
    pub fn closing(&self) -> watch::Receiver<bool> {
        self.closing.subscribe()
    }

    /// Whether the service is shutting down.
    pub fn is_closing(&self) -> bool {
        *self.closing.borrow()
    }

    /// Closes the queue: no further job is started.
    pub fn close(&self) {
        self.closing.send_replace(true);
    }

    /// Closes the store after its pending writes. Only when no worker runs, or its jobs are left behind.
    pub async fn end(&self) {
        let mut tasks = std::mem::take(&mut *self.tasks());
        tasks.shutdown().await;
        self.store.close().await;
    }

    /// Stops running jobs, which return to the queue.
    pub fn interrupt_all(&self) {
        for held in self.running() {
            held.control.stop(StopReason::Shutdown);
        }
    }

    /// Returns to the queue what still runs here, without waiting for it: what it writes from now on has no effect. Gives the ids.
    pub async fn hand_back(&self) -> Vec<JobId> {
        let left: Vec<_> = self.held().iter().map(|(id, held)| (*id, held.clone())).collect();
        let mut ids = Vec::new();
        for (id, held) in left {
            match self.store.requeue(held.seq, held.attempt, Requeued::Shutdown).await {
                Ok(true) => {
                    tracing::info!(job = %id, "returned to the queue, while it still stops");
                    ids.push(id);
                }
                // It has ended after all, or another process has it.
                Ok(false) => {}
                // Its row says "running": the next start requeues it, or another process when its lease is over.
                Err(error) => tracing::warn!(job = %id, %error, "a run is left behind"),
            }
        }
        ids
    }

    /// Announces an event of a job, or of any, whether or not anyone is listening.
    pub(super) fn ring(&self, seq: Option<i64>) {
        let _ = self.notifications.send(seq);
    }

    /// Wakes a worker that waits for a job.
    pub(super) fn wake(&self) {
        self.arrivals.notify_one();
    }

    /// Does something until the queue ends.
    pub fn spawn(&self, task: impl Future<Output = ()> + Send + 'static) {
        self.tasks().spawn(task);
    }

    /// Whether a job runs here.
    pub(super) fn has(&self, id: JobId) -> bool {
        self.held().contains_key(&id)
    }

    /// The attempts that run here.
    pub(super) fn running(&self) -> Vec<Held> {
        self.held().values().cloned().collect()
    }

    fn tasks(&self) -> std::sync::MutexGuard<'_, JoinSet<()>> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn stop(&self, id: JobId, reason: StopReason) {
        if let Some(held) = self.held().get(&id) {
            held.control.stop(reason);
        }
    }

    fn held(&self) -> std::sync::MutexGuard<'_, BTreeMap<JobId, Held>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
