//! Job store in a single SQLite file.

mod lifecycle;
mod meshes;
mod purge;
mod read;
mod submit;

use super::{
    Answer, CancelAnswer, ClaimedJob, DeleteAnswer, Event, EventRow, Job, JobEnd, JobStore, KnownBlobs,
    MeshDeletion, NewJob, Orphan, OwnerRequest, Page, Requeued, Submitted,
};
use crate::mesh::read::MeshFormat;
use crate::mesh::report::MeshReport;
use crate::service::jobs::{JobId, JobKind, JobState, JobsError, Progress, StoreFault};
use crate::service::meshes::StoredMesh;
use futures::future::BoxFuture;
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection as _, SqlStr, Sqlite, SqliteConnection, SqlitePool, Transaction};
use std::future::ready;
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::time::Duration;
use tokio::sync::{Mutex, MutexGuard};

/// The job store in a file, durable at every commit.
#[derive(Debug)]
pub struct SqliteStore {
    pool: SqlitePool,
    /// Whose turn it is to write. SQLite has one writer at a time, and lets the others sleep for longer and longer.
    turn: Mutex<()>,
}

/// A transaction that writes, when it has its turn.
struct Write<'a> {
    // Before the turn: it ends first.
    transaction: Transaction<'a, Sqlite>,
    _turn: MutexGuard<'a, ()>,
}

impl Write<'_> {
    /// Makes the changes durable.
    async fn commit(self) -> Result<(), sqlx::Error> {
        self.transaction.commit().await
    }
}

impl Deref for Write<'_> {
    type Target = SqliteConnection;

    fn deref(&self) -> &SqliteConnection {
        &self.transaction
    }
}

impl DerefMut for Write<'_> {
    fn deref_mut(&mut self) -> &mut SqliteConnection {
        &mut self.transaction
    }
}

impl SqliteStore {
    /// Opens the store in a file, which is created if necessary, and migrates its tables to this version.
    ///
    /// # Errors
    /// If the file cannot be opened or migrated.
    pub async fn open(file: &Path) -> Result<Self, JobsError> {
        let options = SqliteConnectOptions::new()
            .filename(file)
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            // FULL: a commit is on the disk when it returns, so that `202` holds even after a power failure.
            .synchronous(SqliteSynchronous::Full)
            .foreign_keys(true)
            // Erased rows are overwritten.
            .pragma("secure_delete", "ON")
            .busy_timeout(Duration::from_secs(10));
        let pool = SqlitePoolOptions::new()
            .max_connections(8)
            .acquire_timeout(Duration::from_secs(10))
            // SQLite itself ends a transaction that fails on a full disk, while the pool would count it as open for
            // ever.
            .before_acquire(|connection, _| Box::pin(ready(Ok(!connection.is_in_transaction()))))
            .connect_with(options)
            .await?;
        migrations().run(&pool).await.map_err(|error| JobsError::Migration(error.into()))?;
        Ok(Self { pool, turn: Mutex::default() })
    }

    async fn try_write(&self) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        // A field of the file header that is otherwise unused.
        sqlx::query("PRAGMA user_version = 0").execute(&mut *transaction).await?;
        Ok(transaction.commit().await?)
    }

    /// A transaction with the write lock from its start: one that reads first and writes later could be refused midway.
    async fn begin(&self) -> Result<Write<'_>, JobsError> {
        let turn = self.turn.lock().await;
        Ok(Write { transaction: self.pool.begin_with("BEGIN IMMEDIATE").await?, _turn: turn })
    }
}

impl JobStore for SqliteStore {
    fn replay<'a>(
        &'a self,
        owner: &'a str,
        key: &'a str,
        body_sha256: &'a str,
    ) -> Answer<'a, Option<Submitted>> {
        Box::pin(self.replay(owner, key, body_sha256))
    }
    fn submit<'a>(&'a self, new: &'a NewJob, max_queued: u64) -> Answer<'a, Submitted> {
        Box::pin(self.submit(new, max_queued))
    }
    fn claim(&self, free_bytes: Option<u64>) -> Answer<'_, Option<ClaimedJob>> {
        Box::pin(self.claim(free_bytes))
    }
    fn record_progress<'a>(&'a self, seq: i64, attempt: u32, progress: &'a Progress) -> Answer<'a, ()> {
        Box::pin(self.record_progress(seq, attempt, progress))
    }
    fn record_event<'a>(&'a self, seq: i64, attempt: u32, event: &'a Event<'a>) -> Answer<'a, ()> {
        Box::pin(self.record_event(seq, attempt, event))
    }
    fn finish<'a>(&'a self, seq: i64, attempt: u32, end: &'a JobEnd) -> Answer<'a, bool> {
        Box::pin(self.finish(seq, attempt, end))
    }
    fn requeue(&self, seq: i64, attempt: u32, why: Requeued) -> Answer<'_, ()> {
        Box::pin(self.requeue(seq, attempt, why))
    }
    fn cancel<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, CancelAnswer> {
        Box::pin(self.cancel(owner, id))
    }
    fn hide<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, DeleteAnswer> {
        Box::pin(self.hide(owner, id))
    }
    fn erase(&self, seq: i64) -> Answer<'_, ()> {
        Box::pin(self.erase(seq))
    }
    fn add_result<'a>(&'a self, seq: i64, key: &'a str) -> Answer<'a, ()> {
        Box::pin(self.add_result(seq, key))
    }
    fn own_results(&self, seq: i64) -> Answer<'_, Vec<String>> {
        Box::pin(self.own_results(seq))
    }
    fn expired_jobs(&self, older_than_days: u32, limit: u32) -> Answer<'_, Vec<(String, JobId)>> {
        Box::pin(self.expired_jobs(older_than_days, limit))
    }
    fn expired_meshes(&self, older_than_days: u32) -> Answer<'_, Vec<(String, String)>> {
        Box::pin(self.expired_meshes(older_than_days))
    }
    fn request(&self, seq: i64) -> Answer<'_, OwnerRequest> {
        Box::pin(self.request(seq))
    }
    fn orphans(&self) -> Answer<'_, Vec<Orphan>> {
        Box::pin(self.orphans())
    }
    fn job<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<Job>> {
        Box::pin(self.job(owner, id))
    }
    fn jobs<'a>(&'a self, owner: &'a str, page: &'a Page) -> Answer<'a, Vec<Job>> {
        Box::pin(self.jobs(owner, page))
    }
    fn summary<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<String>> {
        Box::pin(self.summary(owner, id))
    }
    fn document<'a>(&'a self, owner: &'a str, id: JobId) -> Answer<'a, Option<(JobKind, Vec<u8>)>> {
        Box::pin(self.document(owner, id))
    }
    fn events_after(&self, seq: i64, after: i64, limit: u32) -> Answer<'_, (Vec<EventRow>, bool)> {
        Box::pin(self.events_after(seq, after, limit))
    }
    fn counts(&self) -> Answer<'_, Vec<(JobState, u64)>> {
        Box::pin(self.counts())
    }
    fn add_mesh<'a>(
        &'a self,
        owner: &'a str,
        id: &'a str,
        format: MeshFormat,
        bytes: u64,
        report: &'a MeshReport,
    ) -> Answer<'a, bool> {
        Box::pin(self.add_mesh(owner, id, format, bytes, report))
    }
    fn mesh<'a>(&'a self, owner: &'a str, id: &'a str) -> Answer<'a, Option<StoredMesh>> {
        Box::pin(self.mesh(owner, id))
    }
    fn meshes<'a>(&'a self, owner: &'a str, after: &'a str, limit: u32) -> Answer<'a, Vec<StoredMesh>> {
        Box::pin(self.meshes(owner, after, limit))
    }
    fn delete_mesh<'a>(&'a self, owner: &'a str, id: &'a str) -> Answer<'a, MeshDeletion> {
        Box::pin(self.delete_mesh(owner, id))
    }
    fn blobs(&self) -> Answer<'_, KnownBlobs> {
        Box::pin(self.blobs())
    }
    fn faults(&self) -> Answer<'_, (Vec<String>, Vec<i64>)> {
        Box::pin(self.faults())
    }
    fn try_write(&self) -> Answer<'_, ()> {
        Box::pin(self.try_write())
    }
    /// Checkpoints the write-ahead log.
    fn close(&self) -> BoxFuture<'_, ()> {
        Box::pin(self.pool.close())
    }
}

/// SQLite's code for a full disk (SQLITE_FULL), in the lower byte of an extended code.
const SQLITE_FULL: u32 = 13;
/// SQLite's code for a disk error (SQLITE_IOERR).
const SQLITE_IOERR: u32 = 10;
/// SQLite's code for a disk that accepts no writes (SQLITE_READONLY).
const SQLITE_READONLY: u32 = 8;
/// SQLite's code for a file that cannot be opened, such as when no descriptor is left (SQLITE_CANTOPEN).
const SQLITE_CANTOPEN: u32 = 14;

impl From<sqlx::Error> for JobsError {
    fn from(error: sqlx::Error) -> Self {
        let code = error.as_database_error().and_then(|e| e.code()?.parse::<u32>().ok());
        let fault = match (&error, code.map(|code| code & 0xff)) {
            (_, Some(SQLITE_FULL)) => StoreFault::Full,
            (sqlx::Error::PoolTimedOut, _) | (_, Some(SQLITE_IOERR | SQLITE_READONLY | SQLITE_CANTOPEN)) => {
                StoreFault::Passing
            }
            _ => StoreFault::Other,
        };
        Self::Store { fault, source: error.into() }
    }
}

/// The files of `migrations/` in order.
fn migrations() -> Migrator {
    let migration = |version, name: &'static str, sql: &'static str| {
        Migration::new(version, name.into(), MigrationType::Simple, SqlStr::from_static(sql), false)
    };
    Migrator::with_migrations(vec![
        migration(1, "jobs", include_str!("migrations/0001_jobs.sql")),
        migration(2, "kinds", include_str!("migrations/0002_kinds.sql")),
        migration(3, "phases", include_str!("migrations/0003_phases.sql")),
        migration(4, "results", include_str!("migrations/0004_results.sql")),
        migration(5, "scale", include_str!("migrations/0005_scale.sql")),
        migration(6, "alone", include_str!("migrations/0006_alone.sql")),
    ])
}

/// Adds an event to a job, with the next number of that job.
async fn add_event(transaction: &mut Write<'_>, job: i64, event: &Event<'_>) -> Result<(), JobsError> {
    sqlx::query(
        "INSERT INTO events (job, n, kind, data)
         VALUES (?1, (SELECT COALESCE(MAX(n), 0) + 1 FROM events WHERE job = ?1), ?2, ?3)",
    )
    .bind(job)
    .bind(event.kind)
    .bind(event.data.to_string())
    .execute(&mut **transaction)
    .await?;
    Ok(())
}

#[cfg(test)]
mod tests;
