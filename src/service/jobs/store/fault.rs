//! How databases fail, in terms of any store.

use crate::service::jobs::{JobsError, StoreFault};
use sqlx::error::DatabaseError;
use sqlx::migrate::MigrateError;
use sqlx::sqlite::SqliteError;

/// SQLite's code for a full disk (SQLITE_FULL), in the lower byte of an extended code.
const SQLITE_FULL: u32 = 13;
/// SQLite's codes for a file or a table that another process or statement has locked (SQLITE_BUSY, SQLITE_LOCKED).
const SQLITE_BUSY: u32 = 5;
const SQLITE_LOCKED: u32 = 6;
/// SQLite's code for a disk error (SQLITE_IOERR).
const SQLITE_IOERR: u32 = 10;
/// SQLite's code for a disk that accepts no writes (SQLITE_READONLY).
const SQLITE_READONLY: u32 = 8;
/// SQLite's code for a file that cannot be opened, such as when no descriptor is left (SQLITE_CANTOPEN).
const SQLITE_CANTOPEN: u32 = 14;

/// SQLSTATE of a full disk.
const DISK_FULL: &str = "53100";
/// SQLSTATE of a server that accepts no writes.
const READ_ONLY: &str = "25006";
/// SQLSTATE of a lock that was waited for too long.
const LOCK_NOT_AVAILABLE: &str = "55P03";
/// Classes of SQLSTATE: connection, serialisation and deadlock, resources, cancelled statements, shutdown and start.
const PASSING: [&str; 4] = ["08", "40", "53", "57"];

impl From<sqlx::Error> for JobsError {
    fn from(error: sqlx::Error) -> Self {
        Self::Store { fault: StoreFault::of(&error), source: error.into() }
    }
}

impl From<MigrateError> for JobsError {
    fn from(error: MigrateError) -> Self {
        Self::Migration(error.into())
    }
}

impl StoreFault {
    /// How a database failed.
    pub(super) fn of(error: &sqlx::Error) -> Self {
        match error {
            sqlx::Error::PoolTimedOut | sqlx::Error::Io(_) => Self::Passing,
            sqlx::Error::Database(error) => fault_of(error.as_ref()),
            _ => Self::Other,
        }
    }
}

fn fault_of(error: &dyn DatabaseError) -> StoreFault {
    let code = error.code().unwrap_or_default();
    if error.try_downcast_ref::<SqliteError>().is_some() {
        return match code.parse::<u32>().map(|code| code & 0xff) {
            Ok(SQLITE_FULL) => StoreFault::Full,
            Ok(SQLITE_BUSY | SQLITE_LOCKED | SQLITE_IOERR | SQLITE_READONLY | SQLITE_CANTOPEN) => {
                StoreFault::Passing
            }
            _ => StoreFault::Other,
        };
    }
    match code.as_ref() {
        DISK_FULL => StoreFault::Full,
        READ_ONLY | LOCK_NOT_AVAILABLE => StoreFault::Passing,
        _ if PASSING.iter().any(|class| code.starts_with(class)) => StoreFault::Passing,
        _ => StoreFault::Other,
    }
}
