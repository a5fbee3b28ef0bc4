//! The job store: its contents, and its interface to the queue, the workers and the routes.
//!
//! Every store gives three guarantees. A change of a job and its event are one transaction, durable when the call
//! returns. Writes of a running job are fenced by its attempt and its process: reports of an attempt that is over have no
//! effect. A job is claimed once. A store of one process has no leases, because the data folder is locked
//! ([`super::data_folder::DataFolder`]): at its start every `running` job has lost its worker. A [`SharedStore`] has.

mod chosen;
mod database_address;
mod fault;
mod headline;
mod job;
#[cfg(feature = "cluster")]
mod postgres;
mod quotas;
mod records;
mod sqlite;
#[cfg(test)]
pub(super) mod tests;

pub use chosen::{PATIENCE, PROBE_PATIENCE, StoreAddress};
pub use headline::{Headline, HeadlineNumber};
pub use job::{Job, JobLinks, NOTICE};
#[cfg(feature = "cluster")]
pub use postgres::PostgresStore;
pub use quotas::{Kept, Quotas};
pub use records::{
    CancelAnswer, Change, ClaimedJob, DeleteAnswer, Event, EventRow, Expired, Identity, JobEnd, KnownBlobs,
    MeshDeletion, NewJob, Orphan, OwnerRequest, Page, Requeued, Submitted,
};

use super::{JobId, JobKind, JobState, JobsError, Progress};
use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use crate::service::meshes::StoredMesh;
use futures::future::BoxFuture;
use futures::stream::BoxStream;
use sqlx::SqlStr;
use sqlx::migrate::{Migration, MigrationType, Migrator};
use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

/// Future of a store's answer: boxed, so that the service is independent of the kind of store.
pub type Answer<'a, T> = BoxFuture<'a, Result<T, JobsError>>;

/// A store of jobs. Owners see only their own jobs, and no hidden ones.
pub trait JobStore: fmt::Debug + Send + Sync + 'static {
    /// The job of an earlier request with this key; `None` if there was none.
    fn replay<'a>(
        &'a self,
        owner: &'a str,
        key: &'a str,
        body_sha256: &'a str,
    ) -> Answer<'a, Option<Submitted>>;

    /// Stores a new job, whose meshes stay from now on; `QueueFull`, `OwnerWaits` or `OwnerKeeps` beyond the quotas.
    fn submit<'a>(&'a self, new: &'a NewJob, quotas: Quotas) -> Answer<'a, Submitted>;

    /// Claims the next job, if its run is expected to take at most `free_bytes` of memory and it need not run alone; any if `None`, when
    /// no other runs. The next job is of the owner with the fewest running jobs, then of the one whose last turn is longest ago; of that
    /// owner the first one of the highest priority. It waits for its memory, and none is taken in its place. One that cannot be read is set aside
    /// as failed.
    fn claim(&self, free_bytes: Option<u64>) -> Answer<'_, Option<ClaimedJob>>;

    /// Records the progress of an attempt.
    fn record_progress<'a>(&'a self, seq: i64, attempt: u32, progress: &'a Progress) -> Answer<'a, ()>;

    /// Stores a part of the result of an attempt as an event.
    fn record_event<'a>(&'a self, seq: i64, attempt: u32, event: &'a Event<'a>) -> Answer<'a, ()>;

    /// Ends an attempt. False if the attempt was over already.
    fn finish<'a>(&'a self, seq: i64, attempt: u32, end: &'a JobEnd) -> Answer<'a, bool>;

    /// Returns a job to the queue after an incomplete attempt. False if the attempt was over already.
    fn requeue(&self, seq: i64, attempt: u32, why: Requeued) -> Answer<'_, bool>;

    /// Cancels a waiting job, or records that a running one has to stop.
    fn cancel<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, CancelAnswer>;

    /// Hides a job permanently: it becomes inaccessible, and its idempotency key is free.
    fn hide<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, DeleteAnswer>;

    /// Erases a hidden job with its events: nothing of them is left in the files of the store.
    fn erase(&self, seq: i64) -> Answer<'_, ()>;

    /// Notes that a job uses a result by content.
    fn add_result<'a>(&'a self, seq: i64, key: &'a str) -> Answer<'a, ()>;

    /// Keys of the results by content that only this job uses.
    fn own_results(&self, seq: i64) -> Answer<'_, Vec<String>>;

    /// Of the jobs after number `after`, the first `limit` that ended more than some days ago, or any days if 0; and the number of the
    /// last one, if there is one.
    fn expired_jobs(
        &self,
        older_than_days: u32,
        after: i64,
        limit: u32,
    ) -> Answer<'_, (Expired<JobId>, Option<i64>)>;

    /// Meshes uploaded more than some days ago, or any days if 0.
    fn expired_meshes(&self, older_than_days: u32) -> Answer<'_, Expired<String>>;

    /// Latest request of the owner of a job.
    fn request(&self, seq: i64) -> Answer<'_, OwnerRequest>;

    /// Takes the jobs whose process was lost, and those hidden but not erased, in the order of arrival: they are those of this process.
    /// If the store is not shared, these are all, at the start, before any worker has begun. Those that cannot be read are set aside as
    /// failed.
    fn orphans(&self) -> Answer<'_, Vec<Orphan>>;

    /// One job of an owner.
    fn job<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<Job>>;

    /// A page of the jobs of an owner, newest first.
    fn jobs<'a>(&'a self, owner: &'a str, page: &'a Page) -> Answer<'a, Vec<Job>>;

    /// The summary of a job of an owner, as JSON text.
    fn summary<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<String>>;

    /// The accepted document of a job of an owner, and its kind.
    fn document<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<(JobKind, Vec<u8>)>>;

    /// Events of a job after event number `after`, and whether no more will follow (the job is final or deleted).
    fn events_after(&self, seq: i64, after: i64, limit: u32) -> Answer<'_, (Vec<EventRow>, bool)>;

    /// Number of jobs in each state.
    fn counts(&self) -> Answer<'_, Vec<(JobState, u64)>>;

    /// For how long the oldest waiting job has waited [s]; 0 if none does.
    fn queue_age_s(&self) -> Answer<'_, f64>;

    /// Number of its faults so far.
    fn fault_count(&self) -> u64;

    /// What an owner keeps.
    fn kept<'a>(&'a self, owner: &'a str) -> Answer<'a, Kept>;

    /// Registers an uploaded mesh; false if the owner had it already, `OwnerKeeps` beyond the quotas.
    fn add_mesh<'a>(
        &'a self,
        owner: &'a str,
        id: &'a str,
        format: MeshFormat,
        bytes: u64,
        report: &'a MeshReport,
        quotas: Quotas,
    ) -> Answer<'a, bool>;

    /// An uploaded mesh of an owner.
    fn mesh<'a>(&'a self, owner: &'a str, id: &'a str) -> Answer<'a, Option<StoredMesh>>;

    /// Meshes of an owner, by id, after the mesh with id `after`.
    fn meshes<'a>(&'a self, owner: &'a str, after: &'a str, limit: u32) -> Answer<'a, Vec<StoredMesh>>;

    /// Deletes a mesh of an owner, unless a job of that owner waits for it or runs on it.
    fn delete_mesh<'a>(&'a self, owner: &'a str, id: &'a str) -> Answer<'a, MeshDeletion>;

    /// Whether anyone has a mesh.
    fn has_owner<'a>(&'a self, id: &'a str, format: MeshFormat) -> Answer<'a, bool>;

    /// Blobs that its jobs and meshes have or may have.
    fn blobs(&self) -> Answer<'_, KnownBlobs>;

    /// Faults of the store itself, in words, and sequence numbers of jobs that cannot be read.
    fn faults(&self) -> Answer<'_, (Vec<String>, Vec<i64>)>;

    /// Checks that the store accepts writes.
    fn try_write(&self) -> Answer<'_, ()>;

    /// Closes the store after its pending writes.
    fn close(&self) -> BoxFuture<'_, ()>;

    /// What processes that share the store have to do; `None` if it is the store of one process.
    fn shared(&self) -> Option<&dyn SharedStore>;
}

/// A lock, until it is dropped.
pub type MeshLock = Box<dyn Send>;

/// A store of several processes.
pub trait SharedStore: Send + Sync {
    /// What distinguishes its blobs from those of other databases.
    fn identity(&self) -> Answer<'_, Identity>;

    /// Notes that a store of blobs has its identity.
    fn note_blobs(&self) -> Answer<'_, ()>;

    /// How long a process has a job without renewing that.
    fn lease(&self) -> Duration;

    /// Renews the leases of jobs that this process runs: the attempt at each that it still has, and what its owner requests.
    fn renew<'a>(&'a self, seqs: &'a [i64]) -> Answer<'a, BTreeMap<i64, (u32, OwnerRequest)>>;

    /// Locks a mesh for all processes until the lock is dropped: to remove its file, or, beside others, to keep and register it.
    fn lock_mesh<'a>(&'a self, id: &'a str, to_remove: bool) -> Answer<'a, MeshLock>;

    /// Changes by all processes, from now on.
    fn changes(&self) -> Answer<'_, BoxStream<'static, Change>>;
}

/// Migrations by name, in order.
fn migrator(files: &[(&'static str, &'static str)]) -> Migrator {
    let migration = |(version, (name, sql)): (i64, &(&'static str, &'static str))| {
        Migration::new(version, (*name).into(), MigrationType::Simple, SqlStr::from_static(sql), false)
    };
    Migrator::with_migrations((1..).zip(files).map(migration).collect())
}
