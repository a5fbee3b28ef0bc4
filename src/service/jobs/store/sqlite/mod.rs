//! Job store in a single SQLite file, of one process.

#[macro_use]
mod dialect;
mod mark;
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
use mark::Mark;
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection as _, Sqlite, SqliteConnection};
use std::path::Path;
use std::time::Duration;
use writer::Writer;

type Db = Sqlite;
type Row = sqlx::sqlite::SqliteRow;
type Turn = Writer;
type Write<'a> = writer::Write;

impl SqliteStore {
    /// Number of changes that were durable in a file and no longer are: the process that made them did not end in order, and their log was
    /// removed, emptied or cut. Only while no process has the store; 0 if it cannot be read.
    pub async fn lost_changes(file: &Path) -> u32 {
        let Some(noted) = Mark::beside(file).noted() else { return 0 };
        changes_in(file).await.map_or(0, |there| noted.wrapping_sub(there).max(0).cast_unsigned())
    }

    /// Keeps in mind that so many changes are lost, after the store was opened and closed.
    ///
    /// # Errors
    /// If the store cannot be read, or the note not be written.
    pub async fn note_lost_changes(file: &Path, lost: u32) -> Result<(), JobsError> {
        Mark::beside(file).note(changes_in(file).await?.wrapping_add_unsigned(lost))
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
        migrations().run(&pool).await?;
        let store = Self::of(pool, writer, Duration::MAX);
        store.try_write().await?;
        Ok(store)
    }

    /// A change of nothing is counted in the file.
    async fn try_write(&self) -> Result<(), JobsError> {
        self.begin().await?.commit().await
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
        let mark = Mark::beside(self.pool.connect_options().get_filename());
        match self.turn.checkpoint().await.and_then(|()| mark.forget()) {
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

/// Number of changes in a file, with those in its log.
async fn changes_in(file: &Path) -> Result<i32, JobsError> {
    let options = SqliteConnectOptions::new().filename(file);
    let mut connection = SqliteConnection::connect_with(&options).await?;
    let changes = writer::changes_of(&mut connection).await;
    connection.close().await?;
    Ok(changes?)
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
        ("withheld", include_str!("migrations/0009_withheld.sql")),
        ("headline", include_str!("migrations/0010_headline.sql")),
    ])
}
