//! Job store in a single SQLite file, of one process.

#[macro_use]
mod dialect;
// The statements are one text for both databases.
#[allow(clippy::duplicate_mod)]
#[path = "../sql/mod.rs"]
mod sql;
#[cfg(test)]
mod tests;

pub use sql::SqlStore as SqliteStore;

use super::SharedStore;
use crate::service::jobs::JobsError;
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection as _, Sqlite, SqliteConnection, Transaction};
use std::future::ready;
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::time::Duration;
use tokio::sync::{Mutex, MutexGuard};

type Db = Sqlite;
type Row = sqlx::sqlite::SqliteRow;
/// Whose turn it is to write. SQLite has one writer at a time, and lets the others sleep for longer and longer.
type Turn = Mutex<()>;

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
        // The data folder is that of one process, which has its jobs until it ends.
        Self::migrated(pool, &migrations(), Duration::MAX).await
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

    /// Faults of the file.
    async fn own_faults(&self) -> Result<Vec<String>, JobsError> {
        let found: Vec<(String,)> =
            sqlx::query_as("PRAGMA integrity_check(20)").fetch_all(&self.pool).await?;
        Ok(found.into_iter().map(|(text,)| text).filter(|text| text != "ok").collect())
    }

    /// Empties the write-ahead log, in which erased rows would still be found. While a statement reads the store, a part of it
    /// stays until the next time.
    async fn forget_erased(&self) -> Result<(), JobsError> {
        sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").fetch_optional(&self.pool).await?;
        Ok(())
    }

    #[allow(clippy::unused_self)] // that of PostgreSQL is shared
    fn as_shared(&self) -> Option<&dyn SharedStore> {
        None
    }
}

/// The files of `migrations/` in order.
fn migrations() -> Migrator {
    super::migrator(&[
        ("jobs", include_str!("migrations/0001_jobs.sql")),
        ("kinds", include_str!("migrations/0002_kinds.sql")),
        ("phases", include_str!("migrations/0003_phases.sql")),
        ("results", include_str!("migrations/0004_results.sql")),
        ("scale", include_str!("migrations/0005_scale.sql")),
        ("alone", include_str!("migrations/0006_alone.sql")),
        ("workers", include_str!("migrations/0007_workers.sql")),
    ])
}
