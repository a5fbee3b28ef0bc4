//! A job store in SQL. The statements are one text, which the module of each database includes as its child: that module has the
//! types of the database, how it begins to write, and in its `dialect` what it says in its own way.

mod claim;
mod lifecycle;
mod meshes;
mod purge;
mod read;
mod submit;

use super::{Db, Row, Turn, Write};
use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use crate::service::jobs::failures::unreadable;
use crate::service::jobs::store::{
    Answer, CancelAnswer, ClaimedJob, DeleteAnswer, Event, EventRow, Expired, Job, JobEnd, JobStore, Kept,
    KnownBlobs, MeshDeletion, NewJob, Orphan, OwnerRequest, Page, Quotas, Requeued, SharedStore, Submitted,
};
use crate::service::jobs::{JobId, JobKind, JobState, JobsError, Progress};
use crate::service::meshes::StoredMesh;
use futures::future::BoxFuture;
use sqlx::{Pool, Row as _};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// More attempts than a job has.
const MANY_ATTEMPTS: u32 = 1000;

/// A job store in a database, durable at every commit.
#[derive(Debug)]
pub struct SqlStore {
    pub(super) pool: Pool<Db>,
    pub(super) turn: Turn,
    /// Name of this process in the rows of its jobs.
    pub(super) worker: String,
    /// How long it has a job without a sign of life.
    pub(super) lease: Duration,
    fault_count: AtomicU64,
}

impl SqlStore {
    /// The store in a database, whose tables are those of this version.
    pub(super) fn of(pool: Pool<Db>, turn: Turn, lease: Duration) -> Self {
        let worker = JobId::new_v4().to_string();
        Self { pool, turn, worker, lease, fault_count: AtomicU64::new(0) }
    }

    /// The answer of the store, whose faults are counted.
    fn counted<'a, T>(
        &'a self,
        work: impl Future<Output = Result<T, JobsError>> + Send + 'a,
    ) -> Answer<'a, T> {
        Box::pin(async {
            work.await.inspect_err(|error| {
                if matches!(error, JobsError::Store { .. }) {
                    self.fault_count.fetch_add(1, Ordering::Relaxed);
                }
            })
        })
    }
}

impl JobStore for SqlStore {
    fn replay<'a>(
        &'a self,
        owner: &'a str,
        key: &'a str,
        body_sha256: &'a str,
    ) -> Answer<'a, Option<Submitted>> {
        self.counted(self.replay(owner, key, body_sha256))
    }
    fn submit<'a>(&'a self, new: &'a NewJob, quotas: Quotas) -> Answer<'a, Submitted> {
        self.counted(self.submit(new, quotas))
    }
    fn claim(&self, free_bytes: Option<u64>) -> Answer<'_, Option<ClaimedJob>> {
        self.counted(self.claim(free_bytes))
    }
    fn record_progress<'a>(&'a self, seq: i64, attempt: u32, progress: &'a Progress) -> Answer<'a, ()> {
        self.counted(self.record_progress(seq, attempt, progress))
    }
    fn record_event<'a>(&'a self, seq: i64, attempt: u32, event: &'a Event<'a>) -> Answer<'a, ()> {
        self.counted(self.record_event(seq, attempt, event))
    }
    fn finish<'a>(&'a self, seq: i64, attempt: u32, end: &'a JobEnd) -> Answer<'a, bool> {
        self.counted(self.finish(seq, attempt, end))
    }
    fn requeue(&self, seq: i64, attempt: u32, why: Requeued) -> Answer<'_, bool> {
        self.counted(self.requeue(seq, attempt, why))
    }
    fn cancel<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, CancelAnswer> {
        self.counted(self.cancel(owner, id))
    }
    fn hide<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, DeleteAnswer> {
        self.counted(self.hide(owner, id))
    }
    fn erase(&self, seq: i64) -> Answer<'_, ()> {
        self.counted(self.erase(seq))
    }
    fn add_result<'a>(&'a self, seq: i64, key: &'a str) -> Answer<'a, ()> {
        self.counted(self.add_result(seq, key))
    }
    fn own_results(&self, seq: i64) -> Answer<'_, Vec<String>> {
        self.counted(self.own_results(seq))
    }
    fn expired_jobs(
        &self,
        older_than_days: u32,
        after: i64,
        limit: u32,
    ) -> Answer<'_, (Expired<JobId>, Option<i64>)> {
        self.counted(self.expired_jobs(older_than_days, after, limit))
    }
    fn expired_meshes(&self, older_than_days: u32) -> Answer<'_, Expired<String>> {
        self.counted(self.expired_meshes(older_than_days))
    }
    fn request(&self, seq: i64) -> Answer<'_, OwnerRequest> {
        self.counted(self.request(seq))
    }
    fn orphans(&self) -> Answer<'_, Vec<Orphan>> {
        self.counted(self.orphans())
    }
    fn job<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<Job>> {
        self.counted(self.job(owner, id))
    }
    fn jobs<'a>(&'a self, owner: &'a str, page: &'a Page) -> Answer<'a, Vec<Job>> {
        self.counted(self.jobs(owner, page))
    }
    fn summary<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<String>> {
        self.counted(self.summary(owner, id))
    }
    fn document<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<(JobKind, Vec<u8>)>> {
        self.counted(self.document(owner, id))
    }
    fn events_after(&self, seq: i64, after: i64, limit: u32) -> Answer<'_, (Vec<EventRow>, bool)> {
        self.counted(self.events_after(seq, after, limit))
    }
    fn counts(&self) -> Answer<'_, Vec<(JobState, u64)>> {
        self.counted(self.counts())
    }
    fn queue_age_s(&self) -> Answer<'_, f64> {
        self.counted(self.queue_age_s())
    }
    fn fault_count(&self) -> u64 {
        self.fault_count.load(Ordering::Relaxed)
    }
    fn kept<'a>(&'a self, owner: &'a str) -> Answer<'a, Kept> {
        self.counted(self.kept(owner))
    }
    fn add_mesh<'a>(
        &'a self,
        owner: &'a str,
        id: &'a str,
        format: MeshFormat,
        bytes: u64,
        report: &'a MeshReport,
        quotas: Quotas,
    ) -> Answer<'a, bool> {
        self.counted(self.add_mesh(owner, id, format, bytes, report, quotas))
    }
    fn mesh<'a>(&'a self, owner: &'a str, id: &'a str) -> Answer<'a, Option<StoredMesh>> {
        self.counted(self.mesh(owner, id))
    }
    fn meshes<'a>(&'a self, owner: &'a str, after: &'a str, limit: u32) -> Answer<'a, Vec<StoredMesh>> {
        self.counted(self.meshes(owner, after, limit))
    }
    fn delete_mesh<'a>(&'a self, owner: &'a str, id: &'a str) -> Answer<'a, MeshDeletion> {
        self.counted(self.delete_mesh(owner, id))
    }
    fn has_owner<'a>(&'a self, id: &'a str, format: MeshFormat) -> Answer<'a, bool> {
        self.counted(self.has_owner(id, format))
    }
    fn blobs(&self) -> Answer<'_, KnownBlobs> {
        self.counted(self.blobs())
    }
    fn faults(&self) -> Answer<'_, (Vec<String>, Vec<i64>)> {
        self.counted(self.faults())
    }
    fn try_write(&self) -> Answer<'_, ()> {
        self.counted(self.try_write())
    }
    fn close(&self) -> BoxFuture<'_, ()> {
        Box::pin(self.shut())
    }
    fn shared(&self) -> Option<&dyn SharedStore> {
        self.as_shared()
    }
}

/// Adds an event to a job, with the next number of that job, whose row the transaction has changed or locked.
async fn add_event(transaction: &mut Write<'_>, job: i64, event: &Event<'_>) -> Result<(), JobsError> {
    sqlx::query(
        "INSERT INTO events (job, n, kind, data)
         VALUES ($1, (SELECT COALESCE(MAX(n), 0) + 1 FROM events WHERE job = $1), $2, $3)",
    )
    .bind(job)
    .bind(event.kind)
    .bind(event.data.to_string())
    .execute(&mut **transaction)
    .await?;
    Ok(())
}

/// Ends a job that waits or runs and cannot be read, so that the others go on: it has failed.
async fn set_aside(transaction: &mut Write<'_>, seq: i64, error: &JobsError) -> Result<(), JobsError> {
    let failure = unreadable();
    let result = sqlx::query(concat!(
        "UPDATE jobs SET state = 'failed', phase = 'done', failure = $2, finished_at = ",
        now!(),
        " WHERE seq = $1 AND state IN ('queued', 'running')"
    ))
    .bind(seq)
    .bind(serde_json::to_string(&failure)?)
    .execute(&mut **transaction)
    .await?;
    tracing::error!(seq, %error, "a job cannot be read: it is set aside as failed");
    if result.rows_affected() > 0 {
        add_event(transaction, seq, &Event::ended(&failure.into())).await?;
    }
    Ok(())
}

/// A number of attempts, or of one, from its column.
pub(super) fn attempts_of(number: i64) -> Result<u32, JobsError> {
    number
        .try_into()
        .map_err(|_| JobsError::Corrupt { what: "number of attempts", value: number.to_string() })
}

/// The number of attempts whose recordings may be there: many if it cannot be read.
fn possible_attempts(row: &Row) -> u32 {
    row.try_get("attempts")
        .map_err(JobsError::from)
        .and_then(attempts_of)
        .unwrap_or(MANY_ATTEMPTS)
        .min(MANY_ATTEMPTS)
}
