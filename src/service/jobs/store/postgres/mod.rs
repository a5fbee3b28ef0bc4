//! Job store in PostgreSQL, of any number of processes.
//!
//! A process has its jobs for a lease, which it renews; when it does not, another process takes them. Every write of a run is fenced by
//! attempt and process. Commits are announced by `NOTIFY`; who missed it finds out when it looks.

mod connect;
#[macro_use]
mod dialect;
// The statements are one text for both databases.
#[allow(clippy::duplicate_mod)]
#[path = "../sql/mod.rs"]
mod sql;

pub use sql::SqlStore as PostgresStore;

use super::{Answer, Change, Identity, MeshLock, OwnerRequest, SharedStore};
use crate::service::jobs::JobsError;
use futures::stream::{self, BoxStream, StreamExt as _};
use sqlx::migrate::Migrator;
use sqlx::postgres::{PgConnectOptions, PgListener, PgPoolOptions};
use sqlx::{Connection as _, Postgres, Transaction};
use std::collections::BTreeMap;
use std::time::Duration;

type Db = Postgres;
type Row = sqlx::postgres::PgRow;
/// Writers lock rows, not each other.
type Turn = ();
type Write<'a> = Transaction<'a, Postgres>;

/// Pause before a lost connection is opened again.
const PAUSE: Duration = Duration::from_secs(1);

impl PostgresStore {
    /// Opens the store in a database, and migrates its tables to this version. Without a sign of life for `lease`, this process loses its
    /// jobs to the others.
    ///
    /// # Errors
    /// If the address is not one, or the database cannot be opened or migrated.
    pub async fn open(url: &str, lease: Duration) -> Result<Self, JobsError> {
        let options = url.parse::<PgConnectOptions>()?.application_name("contuse");
        let mut first = connect::connect(&options).await?;
        migrations().run(&mut first).await?;
        first.close().await?;
        let pool = PgPoolOptions::new()
            .max_connections(8)
            .acquire_timeout(connect::STATEMENT_PATIENCE)
            .after_connect(|connection, _| Box::pin(connect::prepare(connection)))
            .connect_with(options)
            .await?;
        Ok(Self::of(pool, (), lease))
    }

    /// A change of a row to what it is has to be written as any other.
    async fn try_write(&self) -> Result<(), JobsError> {
        sqlx::query("UPDATE identity SET has_blobs = has_blobs").execute(&self.pool).await?;
        Ok(())
    }

    async fn begin(&self) -> Result<Write<'_>, JobsError> {
        let () = self.turn;
        Ok(self.pool.begin().await?)
    }

    /// Faults of its files are those that PostgreSQL itself reports.
    #[allow(clippy::unused_self, clippy::unused_async)] // as of SQLite
    async fn own_faults(&self) -> Result<Vec<String>, JobsError> {
        Ok(Vec::new())
    }

    /// What was erased is overwritten when PostgreSQL next vacuums the tables, by itself.
    #[allow(clippy::unused_self, clippy::unused_async)] // as of SQLite
    async fn forget_erased(&self) -> Result<(), JobsError> {
        Ok(())
    }

    async fn shut(&self) {
        self.pool.close().await;
    }

    #[allow(clippy::unnecessary_wraps)] // that of SQLite is not shared
    fn as_shared(&self) -> Option<&dyn SharedStore> {
        Some(self)
    }

    async fn renew(&self, seqs: &[i64]) -> Result<BTreeMap<i64, (u32, OwnerRequest)>, JobsError> {
        let rows: Vec<(i64, i64, bool, bool)> = sqlx::query_as(concat!(
            "UPDATE jobs SET ",
            taken!(),
            " WHERE worker = $1 AND state = 'running' AND seq = ANY($3)
             RETURNING seq, attempts, deleted <> 0, cancel_requested <> 0"
        ))
        .bind(&self.worker)
        .bind(self.lease.as_secs_f64())
        .bind(seqs)
        .fetch_all(&self.pool)
        .await?;
        // An attempt that cannot be read is over.
        let renewed = rows.into_iter().filter_map(|(seq, attempts, deleted, stop)| {
            let reported = |error: &JobsError| tracing::error!(seq, %error, "a running job cannot be read");
            let attempt = sql::attempts_of(attempts).inspect_err(reported).ok()?;
            Some((seq, (attempt, OwnerRequest::of(deleted, stop))))
        });
        Ok(renewed.collect())
    }
}

impl SharedStore for PostgresStore {
    fn identity(&self) -> Answer<'_, Identity> {
        Box::pin(async {
            let (id, has_blobs) =
                sqlx::query_as("SELECT id, has_blobs FROM identity").fetch_one(&self.pool).await?;
            Ok(Identity { id, has_blobs })
        })
    }

    fn note_blobs(&self) -> Answer<'_, ()> {
        Box::pin(async {
            sqlx::query("UPDATE identity SET has_blobs = TRUE").execute(&self.pool).await?;
            Ok(())
        })
    }

    fn lease(&self) -> Duration {
        self.lease
    }

    fn renew<'a>(&'a self, seqs: &'a [i64]) -> Answer<'a, BTreeMap<i64, (u32, OwnerRequest)>> {
        Box::pin(self.renew(seqs))
    }

    fn lock_mesh<'a>(&'a self, id: &'a str, to_remove: bool) -> Answer<'a, MeshLock> {
        Box::pin(async move {
            // A connection of its own, which ends with the lock: those of the pool would all wait for others that hold locks.
            let mut connection = connect::connect_again(&self.pool.connect_options()).await?;
            let statement = if to_remove {
                "SELECT pg_advisory_lock(hashtextextended(current_schema() || $1, 0))"
            } else {
                "SELECT pg_advisory_lock_shared(hashtextextended(current_schema() || $1, 0))"
            };
            sqlx::query(statement).bind(id).execute(&mut connection).await?;
            let lock: MeshLock = Box::new(connection);
            Ok(lock)
        })
    }

    fn changes(&self) -> Answer<'_, BoxStream<'static, Change>> {
        Box::pin(async {
            // As in the migrations.
            let (channel,): (String,) =
                sqlx::query_as("SELECT 'contuse_' || current_schema()").fetch_one(&self.pool).await?;
            let mut listener = PgListener::connect_with(&self.pool).await?;
            listener.listen(&channel).await?;
            Ok(stream::unfold(listener, |mut listener| async {
                let change = next_change(&mut listener).await;
                Some((change, listener))
            })
            .boxed())
        })
    }
}

/// Waits for the next announcement. The listener opens a lost connection again.
async fn next_change(listener: &mut PgListener) -> Change {
    match listener.try_recv().await {
        Ok(Some(announcement)) => Change::of(announcement.payload()).unwrap_or(Change::Missed),
        Ok(None) => Change::Missed,
        Err(error) => {
            tracing::warn!(%error, "the job store does not announce changes");
            tokio::time::sleep(PAUSE).await;
            Change::Missed
        }
    }
}

impl Change {
    /// The change that a trigger announces as number and kind.
    fn of(payload: &str) -> Option<Self> {
        let (seq, kind) = payload.split_once(' ')?;
        let seq = seq.parse().ok()?;
        Some(match kind {
            "queued" | "requeued" => Self::Arrival(seq),
            "request" => Self::Request(seq),
            _ => Self::Event(seq),
        })
    }
}

/// The files of `migrations/` in order.
fn migrations() -> Migrator {
    super::migrator(&[
        ("jobs", include_str!("migrations/0001_jobs.sql")),
        ("identity", include_str!("migrations/0002_identity.sql")),
        ("owners", include_str!("migrations/0003_owners.sql")),
        ("withheld", include_str!("migrations/0004_withheld.sql")),
        ("headline", include_str!("migrations/0005_headline.sql")),
    ])
}
