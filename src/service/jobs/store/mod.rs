//! The job store: SQLite in a file, durable at every commit.
//!
//! A change of a job and the event that tells of it are one transaction. Writes of a running job are fenced by its
//! attempt: what a worker says of an attempt that is over changes nothing. There are no leases, because the data folder
//! is locked by one process ([`super::recordings::DataFolder`]): at its start whatever is `running` has lost its worker.

mod lifecycle;
mod meshes;
mod read;
mod recovery;
mod submit;

pub use lifecycle::{CancelAnswer, ClaimedJob, DeleteAnswer, JobEnd};
pub use meshes::StoredMesh;
pub use read::{EventRow, JobRow, Page};
pub use recovery::Recovered;
pub use submit::{NewJob, Submitted};

use super::JobsError;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection as _, Sqlite, SqlitePool, Transaction};
use std::future::ready;
use std::path::Path;
use std::time::Duration;

/// Events that a job can have, as they are called on the stream.
pub mod event {
    /// It waits.
    pub const QUEUED: &str = "queued";
    /// A worker took it.
    pub const RUNNING: &str = "running";
    /// How far it has come.
    pub const PROGRESS: &str = "progress";
    /// It lost its worker and waits again.
    pub const REQUEUED: &str = "requeued";
}

/// The job store.
#[derive(Clone, Debug)]
pub struct Store {
    pool: SqlitePool,
}

impl Store {
    /// Opens the store in a file, which is made if need be, and brings its tables to this version.
    ///
    /// # Errors
    /// When the file cannot be opened or migrated.
    pub async fn open(file: &Path) -> Result<Self, JobsError> {
        let options = SqliteConnectOptions::new()
            .filename(file)
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            // FULL: a commit is on the disk when it returns, so that `202` can be believed after a power cut.
            .synchronous(SqliteSynchronous::Full)
            .foreign_keys(true)
            .busy_timeout(Duration::from_secs(10));
        let pool = SqlitePoolOptions::new()
            .max_connections(8)
            .acquire_timeout(Duration::from_secs(10))
            // SQLite itself ends a transaction that a full disk breaks, and the pool would count it as open for ever.
            .before_acquire(|connection, _| Box::pin(ready(Ok(!connection.is_in_transaction()))))
            .connect_with(options)
            .await?;
        sqlx::migrate!("src/service/jobs/migrations").run(&pool).await?;
        Ok(Self { pool })
    }

    /// Closes the store: what was written ahead goes into the file.
    pub async fn close(&self) {
        self.pool.close().await;
    }

    /// Whether the store takes what is written: something that it holds is written again.
    ///
    /// # Errors
    /// When it does not.
    pub async fn try_write(&self) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        // A number in the head of the file that nothing else uses.
        sqlx::query("PRAGMA user_version = 0").execute(&mut *transaction).await?;
        Ok(transaction.commit().await?)
    }

    /// A transaction that holds the right to write from its start: one that reads first and writes later could be
    /// refused in the middle.
    async fn begin(&self) -> Result<Transaction<'_, Sqlite>, JobsError> {
        Ok(self.pool.begin_with("BEGIN IMMEDIATE").await?)
    }
}

/// Adds an event to a job, with the next number of that job.
async fn add_event(
    transaction: &mut Transaction<'_, Sqlite>,
    job: i64,
    kind: &str,
    data: &serde_json::Value,
) -> Result<(), JobsError> {
    sqlx::query(
        "INSERT INTO events (job, n, kind, data)
         VALUES (?1, (SELECT COALESCE(MAX(n), 0) + 1 FROM events WHERE job = ?1), ?2, ?3)",
    )
    .bind(job)
    .bind(kind)
    .bind(data.to_string())
    .execute(&mut **transaction)
    .await?;
    Ok(())
}

#[cfg(test)]
mod tests;
