//! Workers: threads that process one job at a time.
//!
//! A run computes for minutes without yielding, so it uses a thread of its own rather than one of the runtime; the
//! thread blocks on calls to the store.

use super::control::{RunControl, StopReason};
use super::engine::{RunOrder, RunReport};
use super::failures::{internal, lacked_room, panicked, recording_failed};
use super::queue::Queue;
use super::store::{ClaimedJob, Event, Headline, JobEnd, OwnerRequest, Requeued};
use super::{FinalRecording, JobId, JobState, JobsError, Progress, Stage};
use crate::service::traces::continue_from;
use crate::step::{Ending, Failure, FailureCause};
use crate::study::what_if::Note;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::runtime::Handle;

/// Minimum interval between two persisted progress reports of a run.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(200);
/// Approximate number of progress reports in every e-fold of a run's duration.
const PROGRESS_PER_EFOLD: u32 = 100;
/// Attempts to change the row of a job in a store that accepts others.
const WRITE_ATTEMPTS: u32 = 5;
/// Pause before the second of them; each later one is twice as long.
const WRITE_PAUSE: Duration = Duration::from_millis(400);
/// The longest of these pauses.
const LONGEST_WRITE_PAUSE: Duration = Duration::from_secs(5);
/// Pause between two attempts to keep a recording.
const KEEP_PAUSE: Duration = Duration::from_secs(1);

/// Starts the workers of a queue. They end when the queue closes.
///
/// # Errors
/// If the system provides no thread.
pub fn start(queue: &Arc<Queue>) -> std::io::Result<Vec<JoinHandle<()>>> {
    let runtime = Handle::current();
    (0..queue.config.workers)
        .map(|index| {
            let (queue, runtime) = (Arc::clone(queue), runtime.clone());
            std::thread::Builder::new()
                .name(format!("worker-{index}"))
                .spawn(move || Worker { queue, runtime }.work())
        })
        .collect()
}

/// What became of one job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It ended in this state.
    Ended(JobState),
    /// Its owner deleted it.
    Deleted,
    /// It waits again, or another process has it.
    NotOver,
}

/// A worker of one job: its id and outcome, or `None` if no job waits.
pub type OneJob = JoinHandle<Result<Option<(JobId, Outcome)>, JobsError>>;

/// Starts a worker that runs the job that has waited longest.
///
/// # Errors
/// If the system provides no thread.
pub fn start_one(queue: &Arc<Queue>) -> std::io::Result<OneJob> {
    let worker = Worker { queue: Arc::clone(queue), runtime: Handle::current() };
    std::thread::Builder::new().name("worker".into()).spawn(move || worker.work_once())
}

struct Worker {
    queue: Arc<Queue>,
    runtime: Handle,
}

impl Worker {
    fn work(&self) {
        loop {
            match self.runtime.block_on(self.queue.next()) {
                Ok(Some((job, control))) => self.run_guarded(&job, &control),
                Ok(None) => return,
                Err(error) => {
                    tracing::error!(%error, "cannot take a job");
                    std::thread::sleep(Duration::from_secs(1));
                }
            }
        }
    }

    fn work_once(&self) -> Result<Option<(JobId, Outcome)>, JobsError> {
        let Some((job, control)) = self.runtime.block_on(self.queue.take())? else { return Ok(None) };
        self.run_guarded(&job, &control);
        let row = self.runtime.block_on(self.queue.store.job(&job.owner, job.id))?;
        let outcome = row.map_or(Outcome::Deleted, |row| {
            if row.state.is_final() { Outcome::Ended(row.state) } else { Outcome::NotOver }
        });
        Ok(Some((job.id, outcome)))
    }

    /// Runs one job. If the worker itself panics, the job fails and the worker continues.
    fn run_guarded(&self, job: &ClaimedJob, control: &RunControl) {
        let span = tracing::debug_span!("run", job = %job.id, attempt = job.attempt);
        continue_from(&span, job.trace.as_deref());
        let _entered = span.enter();
        if catch_unwind(AssertUnwindSafe(|| self.run(job, control))).is_err() {
            tracing::error!(job = %job.id, "the worker panicked");
            self.queue.metrics.run_panicked();
            let ending = internal().into();
            let end = JobEnd { ending, summary: None, headline: None, recording: None, progress: None };
            if let Err(error) = self.write_end(job, &end) {
                tracing::error!(job = %job.id, %error, "could not write how the job ended");
            }
        }
        self.runtime.block_on(self.queue.release(job));
    }

    /// Runs one job and records how it ended.
    fn run(&self, job: &ClaimedJob, control: &RunControl) {
        tracing::info!(job = %job.id, attempt = job.attempt, "running");
        let result = self.simulate(job, control);
        let outcome = match control.reason() {
            // Deleted: no longer accessible.
            Some(StopReason::Cancel) if self.is_hidden(job) => {
                self.erase(job);
                Ok(())
            }
            Some(StopReason::Shutdown) if matches!(&result, Ok(r) if r.ending == Ending::Cancelled) => {
                self.requeue(job, Requeued::Shutdown)
            }
            // The job is not to blame, and waits for room, or for a disk that accepts files.
            _ if failure_of(&result).is_some_and(|failure| self.is_of_disk(job, failure)) => {
                self.requeue(job, Requeued::DiskFull)
            }
            // There is room again: others may have taken it, or the recording is too large.
            None if failure_of(&result).is_some_and(lacked_room)
                && job.attempt < self.queue.config.max_attempts =>
            {
                self.requeue(job, Requeued::NoRoom)
            }
            // Its meshes could not be read.
            None if failed_as(&result, FailureCause::InvalidScene) && self.queue.is_cut_off() => {
                self.requeue(job, Requeued::BlobStoreSilent)
            }
            None if self.is_worth_another_attempt(job, &result) => self.requeue(job, Requeued::ProcessLost),
            _ => self.finish(job, control, result),
        };
        if let Err(error) = outcome {
            // The row still says "running": the next start of the service recovers it.
            tracing::error!(job = %job.id, %error, "could not write how the job ended");
        }
        self.queue.metrics.run_ended(control.elapsed());
    }

    /// Whether a run failed since the disk, even without its own files, has too little space for any job, or accepts no files.
    fn is_of_disk(&self, job: &ClaimedJob, failure: &Failure) -> bool {
        failure.cause == FailureCause::RecordingFailed && self.queue.check_disk_without(job.id).is_err()
    }

    /// Whether a run lost its process and might keep it without others beside it, or with more memory.
    fn is_worth_another_attempt(&self, job: &ClaimedJob, result: &Result<RunReport, Failure>) -> bool {
        let is_suspect = match result.as_ref().err().map(|failure| failure.cause) {
            Some(FailureCause::Killed) => true,
            Some(FailureCause::OutOfMemory) => !job.alone,
            _ => false,
        };
        is_suspect && job.attempt < self.queue.config.max_attempts
    }

    /// Calls the engine. A panic in it is a defect of the program, and affects this job only.
    fn simulate(&self, job: &ClaimedJob, control: &RunControl) -> Result<RunReport, Failure> {
        let _runtime = self.runtime.enter();
        let recording = self.queue.folder.recording(job.id);
        // Files of an earlier attempt.
        self.queue.folder.remove(job.id).map_err(|e| recording_failed(&e))?;
        let shelf = self.queue.shelf(&job.owner);
        let mut reporter = Reporter::new(self, job);
        let mut progress = |p: Progress| reporter.report(p);
        let mut emit = |event: &Event<'_>| self.record_event(job, event);
        let order = RunOrder {
            job: job.id,
            kind: job.kind,
            document: &job.document,
            most_memory: self.queue.most_memory(job),
            meshes: &shelf,
            recording: &recording,
            threads: self.queue.config.runs.threads_per_job,
            control,
            progress: &mut progress,
            emit: &mut emit,
            blobs: &self.queue.blobs,
            note_result: self.note_result(job),
        };
        let span = tracing::debug_span!("simulation");
        let called = catch_unwind(AssertUnwindSafe(|| span.in_scope(|| self.queue.engine.run(order))));
        let result = called.unwrap_or_else(|payload| Err(panicked(payload.as_ref())));
        if let Err(failure) = &result
            && failure.cause == FailureCause::Panicked
        {
            tracing::error!(job = %job.id, "a run panicked");
            self.queue.metrics.run_panicked();
        }
        if is_lost(&result) {
            self.queue.metrics.process_lost();
        }
        result
    }

    /// Stores a part of a result as an event.
    fn record_event(&self, job: &ClaimedJob, event: &Event<'_>) {
        let written = self.queue.store.record_event(job.seq, job.attempt, event);
        match self.runtime.block_on(written) {
            Ok(()) => self.queue.ring(Some(job.seq)),
            // The complete result will contain it.
            Err(error) => tracing::warn!(job = %job.id, %error, "could not write a part of its result"),
        }
    }

    /// Stores which results by content the job uses, so that they are deleted with the last job that does.
    fn note_result(&self, job: &ClaimedJob) -> Note {
        let (store, runtime) = (Arc::clone(&self.queue.store), self.runtime.clone());
        let (seq, id) = (job.seq, job.id);
        Arc::new(move |key| {
            if let Err(error) = runtime.block_on(store.add_result(seq, key)) {
                // The next start of the service removes results that no job has.
                tracing::warn!(job = %id, %error, "could not write that it uses a result");
            }
        })
    }

    fn finish(
        &self,
        job: &ClaimedJob,
        control: &RunControl,
        result: Result<RunReport, Failure>,
    ) -> Result<(), JobsError> {
        let mut end = match result {
            Ok(RunReport { ending, summary, progress }) => {
                let headline = summary.as_ref().and_then(|summary| Headline::of(&job.document, summary));
                JobEnd { ending, summary, headline, recording: None, progress: Some(progress) }
            }
            Err(failure) => {
                let ending = failure.into();
                JobEnd { ending, summary: None, headline: None, recording: None, progress: None }
            }
        };
        match self.keep_recording(job, control, end.ending == Ending::Finished) {
            Ok(recording) => end.recording = recording,
            // What was waited for is not worth the recording.
            Err(_) if control.reason() == Some(StopReason::Shutdown) => {
                return self.requeue(job, Requeued::Shutdown);
            }
            Err(_) if control.reason() == Some(StopReason::Cancel) => {
                self.forget_files(job);
                end.ending = Ending::Cancelled;
            }
            // A run whose recording is lost has not succeeded; one that failed before keeps its own cause.
            Err(error) => {
                tracing::error!(job = %job.id, %error, "the recording could not be kept");
                // They may be what fills the disk.
                self.forget_files(job);
                if end.ending.failure().is_none() {
                    end.ending = recording_failed(&error).into();
                }
            }
        }
        self.write_end(job, &end)
    }

    /// Stores the recording of a run. A disk that accepts no files, or an object store that does not answer, is waited for until the job
    /// is not wanted here any more: the run has ended, and is not to blame. No other job begins meanwhile.
    fn keep_recording(
        &self,
        job: &ClaimedJob,
        control: &RunControl,
        complete: bool,
    ) -> Result<Option<FinalRecording>, JobsError> {
        let _span = tracing::debug_span!("recording").entered();
        let (mut refused, mut waiting) = (None, None);
        loop {
            let kept = self.queue.keep_recording(job.id, job.attempt, complete);
            let Err(error) = &kept else { return kept };
            self.queue.metrics.failed(error);
            if matches!(control.reason(), Some(StopReason::Cancel | StopReason::Shutdown)) {
                return kept;
            }
            tracing::warn!(job = %job.id, %error, "its recording waits for the storage");
            waiting.get_or_insert_with(|| self.queue.end_waits());
            // It may have come back a moment ago; a storage that answers and refuses this recording again and again does not want it.
            if !self.queue.is_storage_away(job.id, error) {
                let since = *refused.get_or_insert_with(Instant::now);
                if since.elapsed() >= self.queue.longest_refusal(error) {
                    return kept;
                }
            }
            std::thread::sleep(KEEP_PAUSE);
        }
    }

    /// Records how a job ended.
    fn write_end(&self, job: &ClaimedJob, end: &JobEnd) -> Result<(), JobsError> {
        if self.insist(job, async || self.queue.store.finish(job.seq, job.attempt, end).await)? {
            tracing::info!(job = %job.id, state = JobState::of(&end.ending).as_str(), cause = ?end.ending.failure().map(|f| f.cause), "ended");
            self.queue.metrics.job_ended(JobState::of(&end.ending));
            self.queue.forget_earlier_recordings(job);
        } else {
            tracing::warn!(job = %job.id, attempt = job.attempt, "an attempt that is over has ended");
        }
        // Deleted while ending: no one else will erase it.
        if self.is_hidden(job) {
            self.erase(job);
        }
        Ok(())
    }

    fn requeue(&self, job: &ClaimedJob, why: Requeued) -> Result<(), JobsError> {
        self.forget_files(job);
        if self.insist(job, async || self.queue.store.requeue(job.seq, job.attempt, why).await)? {
            tracing::info!(job = %job.id, ?why, "returned to the queue");
        }
        Ok(())
    }

    /// Removes the local files of a run.
    fn forget_files(&self, job: &ClaimedJob) {
        if let Err(error) = self.queue.folder.remove(job.id) {
            // The next attempt or start removes them.
            tracing::warn!(job = %job.id, %error, "files of the attempt stay");
        }
    }

    /// Changes the row of a job. A store that accepts no writes is waited for until the service shuts down: no other job could begin
    /// meanwhile. One that accepts others, but not this change again and again, does not want it.
    fn insist<T>(
        &self,
        job: &ClaimedJob,
        change: impl AsyncFn() -> Result<T, JobsError>,
    ) -> Result<T, JobsError> {
        let (mut refusals, mut pause) = (0, WRITE_PAUSE);
        loop {
            let error = match self.runtime.block_on(change()) {
                Ok(done) => return Ok(done),
                Err(error) => error,
            };
            tracing::warn!(job = %job.id, %error, "the store did not take a change of the job");
            refusals += u32::from(self.runtime.block_on(self.queue.store.try_write()).is_ok());
            if refusals == WRITE_ATTEMPTS || self.queue.is_closing() {
                return Err(error);
            }
            std::thread::sleep(pause);
            pause = (2 * pause).min(LONGEST_WRITE_PAUSE);
        }
    }

    fn erase(&self, job: &ClaimedJob) {
        tracing::info!(job = %job.id, "deleted");
        self.runtime.block_on(self.queue.erase(job.seq, job.id, job.attempt));
    }

    fn is_hidden(&self, job: &ClaimedJob) -> bool {
        match self.runtime.block_on(self.queue.store.request(job.seq)) {
            Ok(request) => request == OwnerRequest::Deletion,
            Err(error) => {
                tracing::warn!(job = %job.id, %error, "could not see whether it was deleted");
                false
            }
        }
    }
}

/// Whether a run lost its process.
fn is_lost(result: &Result<RunReport, Failure>) -> bool {
    matches!(result, Err(Failure { cause: FailureCause::Killed | FailureCause::OutOfMemory, .. }))
}

/// Whether a run failed for a cause.
fn failed_as(result: &Result<RunReport, Failure>, cause: FailureCause) -> bool {
    failure_of(result).is_some_and(|failure| failure.cause == cause)
}

fn failure_of(result: &Result<RunReport, Failure>) -> Option<&Failure> {
    match result {
        Ok(report) => report.ending.failure(),
        Err(failure) => Some(failure),
    }
}

/// Persists the progress of a run at a limited rate.
struct Reporter<'a> {
    worker: &'a Worker,
    job: &'a ClaimedJob,
    started: Instant,
    /// When the run that the progress is of began: those for its error bars come before it.
    run_began: Instant,
    last: Option<(Instant, Stage)>,
}

impl<'a> Reporter<'a> {
    fn new(worker: &'a Worker, job: &'a ClaimedJob) -> Self {
        let now = Instant::now();
        Self { worker, job, started: now, run_began: now, last: None }
    }

    fn report(&mut self, mut progress: Progress) {
        let elapsed = self.started.elapsed();
        let interval = PROGRESS_INTERVAL.max(elapsed / PROGRESS_PER_EFOLD);
        let is_due =
            self.last.is_none_or(|(at, stage)| at.elapsed() >= interval || stage != progress.stage());
        if !is_due {
            return;
        }
        self.last = Some((Instant::now(), progress.stage()));
        if progress.progress <= 0.0 {
            self.run_began = Instant::now();
        }
        progress.eta_s = eta_s(self.run_began.elapsed(), progress.progress);
        let queue = &self.worker.queue;
        let written = self.worker.runtime.block_on(queue.store.record_progress(
            self.job.seq,
            self.job.attempt,
            &progress,
        ));
        match written {
            Ok(()) => queue.ring(Some(self.job.seq)),
            // The run is more important than its progress report.
            Err(error) => tracing::warn!(job = %self.job.id, %error, "could not write its progress"),
        }
    }
}

/// Expected remaining time [s] of a run that has completed a fraction in `elapsed`.
fn eta_s(elapsed: Duration, fraction: f64) -> Option<f64> {
    (fraction > 0.0).then(|| elapsed.as_secs_f64() * (1.0 - fraction) / fraction)
}
