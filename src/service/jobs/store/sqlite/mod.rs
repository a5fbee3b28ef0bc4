//! Job store in a single SQLite file, of one process.

#[macro_use]
mod dialect;
// The statements are one text for both databases.
#[allow(clippy::duplicate_mod)]
#[path = "../sql/mod.rs"]
mod sql;
#[cfg(test)]
mod tests;
mod writer;

pub use sql::SqlStore as SqliteStore;

use super::SharedStore;
use crate::service::jobs::JobsError;
use sqlx::Sqlite;
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;
use writer::Writer;

type Db = Sqlite;
type Row = sqlx::sqlite::SqliteRow;
type Turn = Writer;
type Write<'a> = writer::Write;

/// End of the name of the file with the last transactions.
const LOG: &str = "-wal";
/// End of the name of an empty file, which is there from the first write of a process to its orderly end: so long there is a log, too.
const OPEN: &str = "-open";

/// A file whose name is that of the store with an ending.
fn beside(file: &Path, ending: &str) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

impl SqliteStore {
    /// Whether the last transactions in a file are lost: the process that wrote them did not end in order, and their log is missing.
    pub fn has_lost_log(file: &Path) -> bool {
        beside(file, OPEN).exists() && !beside(file, LOG).exists()
    }

    /// Notes that there is a log, or that it is lost.
    ///
    /// # Errors
    /// If the file for that cannot be created.
    pub fn mark(file: &Path) -> Result<(), JobsError> {
        let open = beside(file, OPEN);
        File::create(&open).map(drop).map_err(|error| JobsError::file(open, error))
    }

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
            .connect_with(options)
            .await?;
        // The data folder is that of one process, which has its jobs until it ends.
        let writer = Writer::beside(&pool).await?;
        let store = Self::migrated(pool, writer, &migrations(), Duration::MAX).await?;
        store.try_write().await?;
        Self::mark(file)?;
        Ok(store)
    }

    async fn try_write(&self) -> Result<(), JobsError> {
        let mut transaction = self.begin().await?;
        // A field of the file header that is otherwise unused.
        sqlx::query("PRAGMA user_version = 0").execute(&mut *transaction).await?;
        transaction.commit().await
    }

    async fn begin(&self) -> Result<Write<'_>, JobsError> {
        self.turn.begin().await
    }

    /// Faults of the file.
    async fn own_faults(&self) -> Result<Vec<String>, JobsError> {
        let found: Vec<(String,)> =
            sqlx::query_as("PRAGMA integrity_check(20)").fetch_all(&self.pool).await?;
        Ok(found.into_iter().map(|(text,)| text).filter(|text| text != "ok").collect())
    }

    /// Erased rows would still be found in the write-ahead log.
    async fn forget_erased(&self) -> Result<(), JobsError> {
        self.turn.checkpoint().await
    }

    async fn shut(&self) {
        let file = self.pool.connect_options().get_filename().to_owned();
        match self.turn.checkpoint().await.and_then(|()| forget(&beside(&file, OPEN))) {
            Ok(()) => {}
            Err(error) => tracing::warn!(%error, "the log of the job store is emptied at the next start"),
        }
        self.pool.close().await;
    }

    #[allow(clippy::unused_self)] // that of PostgreSQL is shared
    fn as_shared(&self) -> Option<&dyn SharedStore> {
        None
    }
}

/// Removes a file, if it exists.
fn forget(file: &Path) -> Result<(), JobsError> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(JobsError::file(file, error)),
        _ => Ok(()),
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
        ("owners", include_str!("migrations/0008_owners.sql")),
    ])
}
