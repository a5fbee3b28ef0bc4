//! The one writer of SQLite. Changes that wait for their turn at the same time share a transaction, and with it the wait for the
//! disk; each is a savepoint, which is kept or undone by itself. Transactions with changes are counted, in the file and in its [`Mark`].

use super::mark::Mark;
use crate::service::jobs::{JobsError, StoreFault};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AssertSqlSafe, Connection as _, SqliteConnection, SqlitePool};
use std::io;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use tokio::sync::{Mutex, OwnedMutexGuard, oneshot};

/// The connection that writes, and whose turn it is: in the order of their coming.
#[derive(Clone, Debug)]
pub(super) struct Writer(Arc<Mutex<Turn>>);

/// A change, which is undone unless it is committed.
#[derive(Debug)]
pub(super) struct Write(OwnedMutexGuard<Turn>);

#[derive(Debug)]
struct Turn {
    connection: SqliteConnection,
    options: Arc<SqliteConnectOptions>,
    /// The readers, with which the writer is closed.
    pool: SqlitePool,
    stage: Stage,
    /// Number of the transaction that is open, or is opened next.
    number: u64,
    /// Those whose changes are in the open transaction.
    waiting: Vec<oneshot::Sender<Committed>>,
    /// Number of changes that are durable, from the first one to the file; after the largest number comes the smallest.
    changes: i32,
    mark: Mark,
}

/// Outcome of a transaction, for each of its changes.
type Committed = Result<(), Arc<sqlx::Error>>;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// No transaction is open.
    Idle,
    /// One is open, without a savepoint.
    Open,
    /// One is open with the savepoint of a change, which is being made or was given up.
    Changing,
    /// The state of the connection is unknown.
    Lost,
}

impl Writer {
    /// A writer beside the readers of a pool.
    pub async fn beside(pool: &SqlitePool) -> Result<Self, sqlx::Error> {
        let options = pool.connect_options();
        let mut connection = SqliteConnection::connect_with(&options).await?;
        let (changes, mark) = (changes_of(&mut connection).await?, Mark::beside(options.get_filename()));
        let (pool, stage, number, waiting) = (pool.clone(), Stage::Idle, 0, Vec::new());
        let turn = Turn { connection, options, pool, stage, number, waiting, changes, mark };
        Ok(Self(Arc::new(Mutex::new(turn))))
    }

    /// Begins a change when it is its turn, with the write lock from the start: one that reads first and writes later could be refused
    /// midway.
    pub async fn begin(&self) -> Result<Write, JobsError> {
        let writer = self.clone();
        to_its_end(async move {
            let mut turn = Arc::clone(&writer.0).lock_owned().await;
            let begun = turn.begin().await;
            let number = turn.number;
            // Behind those that wait now, which share the transaction, and behind this one, whether it is committed or given up.
            tokio::spawn(async move { writer.0.lock().await.commit(number).await });
            begun.map(|()| Write(turn)).map_err(failed)
        })
        .await
    }

    /// Does something with the connection when it is its turn.
    #[cfg(test)]
    pub async fn set(&self, pragma: &'static str) -> Result<(), sqlx::Error> {
        self.0.lock().await.say(pragma).await
    }

    /// Number of transactions that have ended.
    #[cfg(test)]
    pub async fn ended(&self) -> u64 {
        self.0.lock().await.number
    }

    /// Empties the write-ahead log. While a statement reads the store, a part of it stays until the next time.
    pub async fn checkpoint(&self) -> Result<(), JobsError> {
        let writer = self.clone();
        to_its_end(async move {
            let mut turn = writer.0.lock().await;
            let number = turn.number;
            turn.commit(number).await;
            turn.say("PRAGMA wal_checkpoint(TRUNCATE)").await.map_err(JobsError::from)
        })
        .await
    }
}

impl Write {
    /// Makes the change durable, with those that share its transaction.
    pub async fn commit(mut self) -> Result<(), JobsError> {
        let (sender, outcome) = oneshot::channel();
        tokio::spawn(async move { self.0.keep(sender).await });
        outcome.await.map_err(not_to_its_end)?.map_err(failed)
    }
}

impl Turn {
    async fn say(&mut self, statement: &'static str) -> Result<(), sqlx::Error> {
        sqlx::query(statement).fetch_optional(&mut self.connection).await.map(drop)
    }

    /// Opens a transaction, if none is open, and the savepoint of a change.
    async fn begin(&mut self) -> Result<(), Arc<sqlx::Error>> {
        self.undo().await;
        let begun = self.open().await;
        begun.map_err(|error| self.lose(error))
    }

    async fn open(&mut self) -> Result<(), sqlx::Error> {
        if self.pool.is_closed() {
            return Err(sqlx::Error::PoolClosed);
        }
        if self.stage == Stage::Lost {
            // The transaction of the old connection ends with it.
            self.connection = SqliteConnection::connect_with(&self.options).await?;
            self.changes = changes_of(&mut self.connection).await?;
            self.stage = Stage::Idle;
        }
        if self.stage == Stage::Idle {
            self.say("BEGIN IMMEDIATE").await?;
            self.stage = Stage::Open;
        }
        self.say("SAVEPOINT change").await?;
        self.stage = Stage::Changing;
        Ok(())
    }

    /// Undoes a change that was given up.
    async fn undo(&mut self) {
        if self.stage == Stage::Changing {
            match self.say("ROLLBACK TO change").await {
                Ok(()) => self.stage = Stage::Open,
                // As on a full disk. The others may try again.
                Err(error) => {
                    self.lose(sqlx::Error::Io(io::Error::other(format!(
                        "SQLite ended the transaction: {error}"
                    ))));
                }
            }
        }
    }

    /// Keeps a change until the commit.
    async fn keep(&mut self, sender: oneshot::Sender<Committed>) {
        self.waiting.push(sender);
        match self.say("RELEASE change").await {
            Ok(()) => self.stage = Stage::Open,
            Err(error) => drop(self.lose(error)),
        }
    }

    /// Commits the transaction with this number, unless it has ended.
    async fn commit(&mut self, number: u64) {
        if self.number == number {
            self.undo().await;
        }
        if self.number == number && self.stage == Stage::Open {
            match self.count_and_commit().await {
                Ok(()) => self.end(Stage::Idle, &Ok(())),
                Err(error) => drop(self.lose(error)),
            }
        }
    }

    /// Makes the transaction durable. One with changes has a number, which is noted when it is durable, before anyone hears of it.
    async fn count_and_commit(&mut self) -> Result<(), sqlx::Error> {
        if self.waiting.is_empty() {
            return self.say("COMMIT").await;
        }
        let changes = self.changes.wrapping_add(1);
        // A field of the header of the file that is otherwise unused.
        let count = sqlx::query(AssertSqlSafe(format!("PRAGMA user_version = {changes}"))).persistent(false);
        count.execute(&mut self.connection).await?;
        self.say("COMMIT").await?;
        self.changes = changes;
        let mark = self.mark.clone();
        let noted = tokio::task::spawn_blocking(move || mark.note(changes)).await;
        if let Err(error) = noted.unwrap_or_else(|error| Err(not_to_its_end(error))) {
            tracing::warn!(%error, "a loss of the log of the job store would not be noticed");
        }
        Ok(())
    }

    /// Ends the transaction without its changes.
    fn lose(&mut self, error: sqlx::Error) -> Arc<sqlx::Error> {
        let error = Arc::new(error);
        self.end(Stage::Lost, &Err(Arc::clone(&error)));
        error
    }

    fn end(&mut self, stage: Stage, outcome: &Committed) {
        (self.stage, self.number) = (stage, self.number + 1);
        for sender in self.waiting.drain(..) {
            // No one hears it whose request was given up.
            let _ = sender.send(outcome.clone());
        }
    }
}

impl Deref for Write {
    type Target = SqliteConnection;

    fn deref(&self) -> &SqliteConnection {
        &self.0.connection
    }
}

impl DerefMut for Write {
    fn deref_mut(&mut self) -> &mut SqliteConnection {
        &mut self.0.connection
    }
}

/// Number of changes in the file of a connection.
pub(super) async fn changes_of(connection: &mut SqliteConnection) -> Result<i32, sqlx::Error> {
    sqlx::query_scalar("PRAGMA user_version").fetch_one(connection).await
}

/// Does what must not be given up midway with the request that asks for it.
async fn to_its_end<T: Send + 'static>(
    work: impl Future<Output = Result<T, JobsError>> + Send + 'static,
) -> Result<T, JobsError> {
    tokio::spawn(work).await.unwrap_or_else(|error| Err(not_to_its_end(error)))
}

/// The runtime ends.
fn not_to_its_end(error: impl std::error::Error + Send + Sync + 'static) -> JobsError {
    JobsError::Store { fault: StoreFault::Passing, source: error.into() }
}

/// The error of a transaction, which is that of all its changes.
fn failed(error: Arc<sqlx::Error>) -> JobsError {
    JobsError::Store { fault: StoreFault::of(&error), source: error.into() }
}
