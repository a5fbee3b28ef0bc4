//! The job store: what is kept of jobs, and what the queue, the workers and the routes ask of it.
//!
//! Every store keeps three promises. A change of a job and the event that tells of it are one transaction, durable when the call
//! returns. Writes of a running job are fenced by its attempt: what a worker says of an attempt that is over changes nothing.
//! A job is claimed once. There are no leases, because the data folder is locked by one process
//! ([`super::data_folder::DataFolder`]): at its start whatever is `running` has lost its worker.

mod records;
mod sqlite;
#[cfg(test)]
mod tests;

pub use records::{
    CancelAnswer, ClaimedJob, DeleteAnswer, Event, EventRow, JobEnd, JobRow, NewJob, Orphan, OwnerWish, Page,
    Requeued, Submitted,
};
pub use sqlite::SqliteStore;

use super::{JobId, JobKind, JobState, JobsError, Progress};
use crate::mesh::read::MeshFormat;
use crate::service::meshes::{MeshReport, StoredMesh};
use futures::future::BoxFuture;
use std::collections::BTreeSet;
use std::fmt;

/// What a store answers when it has: boxed, so that the service need not know which store it has.
pub type Answer<'a, T> = BoxFuture<'a, Result<T, JobsError>>;

/// What keeps jobs. Owners see their own only, and never one that was hidden.
pub trait JobStore: fmt::Debug + Send + Sync + 'static {
    /// The job of an earlier request with this key; `None` when there was none.
    fn replay<'a>(
        &'a self,
        owner: &'a str,
        key: &'a str,
        body_sha256: &'a str,
    ) -> Answer<'a, Option<Submitted>>;

    /// Keeps a new job; `QueueFull` when `max_queued` jobs wait already.
    fn submit<'a>(&'a self, new: &'a NewJob, max_queued: u64) -> Answer<'a, Submitted>;

    /// Takes the job that has waited longest.
    fn claim(&self) -> Answer<'_, Option<ClaimedJob>>;

    /// Says how far an attempt has come.
    fn record_progress<'a>(&'a self, seq: i64, attempt: u32, progress: &'a Progress) -> Answer<'a, ()>;

    /// Keeps a part of the result of an attempt as an event.
    fn record_event<'a>(&'a self, seq: i64, attempt: u32, event: &'a Event<'a>) -> Answer<'a, ()>;

    /// Ends an attempt. False when the attempt was over already.
    fn finish<'a>(&'a self, seq: i64, attempt: u32, end: &'a JobEnd) -> Answer<'a, bool>;

    /// Lets a job wait again whose attempt did not come to its end.
    fn requeue(&self, seq: i64, attempt: u32, why: Requeued) -> Answer<'_, ()>;

    /// Cancels a job that waits, or notes that one that runs has to stop.
    fn cancel<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, CancelAnswer>;

    /// Hides a job for good: nobody can ask for it any more, and its idempotency key is free.
    fn hide<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, DeleteAnswer>;

    /// Erases a hidden job with its events.
    fn erase(&self, seq: i64) -> Answer<'_, ()>;

    /// What the owner of a job wants of it by now.
    fn wish(&self, seq: i64) -> Answer<'_, OwnerWish>;

    /// The jobs whose worker was lost, and those that were hidden but not erased, in the order of their coming. Only right at the
    /// start, while no worker of this process has begun.
    fn orphans(&self) -> Answer<'_, Vec<Orphan>>;

    /// One job of an owner.
    fn job<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<JobRow>>;

    /// A page of the jobs of an owner, newest first.
    fn jobs<'a>(&'a self, owner: &'a str, page: &'a Page) -> Answer<'a, Vec<JobRow>>;

    /// The summary of a job of an owner, as JSON text.
    fn summary<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<String>>;

    /// The document of a job of an owner as it was accepted, and what kind of job it asks for.
    fn document<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<(JobKind, Vec<u8>)>>;

    /// Events of a job after event number `after`, and whether nothing will come any more (the job is final or gone).
    fn events_after(&self, seq: i64, after: i64, limit: u32) -> Answer<'_, (Vec<EventRow>, bool)>;

    /// How many jobs are in each state.
    fn counts(&self) -> Answer<'_, Vec<(JobState, u64)>>;

    /// Notes an uploaded mesh; false when the owner had it already.
    fn add_mesh<'a>(
        &'a self,
        owner: &'a str,
        id: &'a str,
        format: MeshFormat,
        bytes: u64,
        report: &'a MeshReport,
    ) -> Answer<'a, bool>;

    /// A mesh of an owner.
    fn mesh<'a>(&'a self, owner: &'a str, id: &'a str) -> Answer<'a, Option<StoredMesh>>;

    /// The names of the blobs that its jobs and meshes have or may have.
    fn blobs(&self) -> Answer<'_, BTreeSet<String>>;

    /// Fails unless the store takes what is written.
    fn try_write(&self) -> Answer<'_, ()>;

    /// Closes the store.
    fn close(&self) -> BoxFuture<'_, ()>;
}
