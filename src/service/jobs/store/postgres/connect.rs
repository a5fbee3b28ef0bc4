//! The first connection to a database, which says why there is none: a pool would only say that it waited.

use crate::service::jobs::JobsError;
use sqlx::error::DatabaseError;
use sqlx::postgres::PgConnectOptions;
use sqlx::{AssertSqlSafe, Connection as _, Error, PgConnection};
use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};

/// How long a server is waited for that refuses connections, as it does while it starts.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time between two attempts.
const PAUSE: Duration = Duration::from_millis(500);

/// SQLSTATE of a server that starts or stops.
const CANNOT_CONNECT_NOW: &str = "57P03";
/// Class of SQLSTATE of refused credentials.
const NOT_AUTHORISED: &str = "28";
/// SQLSTATE of a database that does not exist.
const NO_DATABASE: &str = "3D000";

/// Longest time that a statement takes or waits for a lock, as a request waits for a connection.
pub(super) const STATEMENT_PATIENCE: Duration = Duration::from_secs(10);

/// Encodings in which names can be stored in any script.
const ENCODINGS: [&str; 2] = ["UTF8", "SQL_ASCII"];

/// Connects to a database, and says what keeps it from being used. Statements may take long, as those of migrations do.
///
/// # Errors
/// `Database`: why it cannot be opened, without the password.
pub(super) async fn connect(options: &PgConnectOptions) -> Result<PgConnection, JobsError> {
    let mut connection = try_connect(options).await?;
    sqlx::query(ISOLATION).execute(&mut connection).await?;
    let encoding: String = sqlx::query_scalar("SHOW server_encoding").fetch_one(&mut connection).await?;
    if !ENCODINGS.contains(&encoding.as_str()) {
        let words = format!("its encoding is {encoding}, which lacks most characters of names");
        return Err(refused(
            options,
            words.into(),
            "create one with `createdb --encoding=UTF8 --template=template0`",
        ));
    }
    Ok(connection)
}

/// The isolation that the statements are written for, whatever the default of the database.
const ISOLATION: &str = "SET default_transaction_isolation = 'read committed'";

/// Prepares a connection for the statements of requests.
pub(super) async fn prepare(connection: &mut PgConnection) -> Result<(), Error> {
    let patience = STATEMENT_PATIENCE.as_secs();
    let settings =
        format!("{ISOLATION}; SET lock_timeout = '{patience}s'; SET statement_timeout = '{patience}s'");
    sqlx::raw_sql(AssertSqlSafe(settings)).execute(connection).await.map(drop)
}

/// Connects once more to a database that has been used.
pub(super) async fn connect_again(options: &PgConnectOptions) -> Result<PgConnection, Error> {
    let connecting = async {
        let mut connection = PgConnection::connect_with(options).await?;
        prepare(&mut connection).await?;
        Ok(connection)
    };
    tokio::time::timeout(STATEMENT_PATIENCE, connecting).await.unwrap_or(Err(Error::PoolTimedOut))
}

async fn try_connect(options: &PgConnectOptions) -> Result<PgConnection, JobsError> {
    let begun = Instant::now();
    loop {
        let left = PATIENCE.saturating_sub(begun.elapsed());
        let error = match tokio::time::timeout(left, PgConnection::connect_with(options)).await {
            Ok(Ok(connection)) => return Ok(connection),
            Ok(Err(error)) => error,
            Err(_) => {
                let words = format!("no answer within {} s", PATIENCE.as_secs());
                Error::Io(io::Error::new(ErrorKind::TimedOut, words))
            }
        };
        if !may_start(&error) || begun.elapsed() + PAUSE >= PATIENCE {
            return Err(closed(options, error));
        }
        tokio::time::sleep(PAUSE).await;
    }
}

/// Whether a server answers so while it starts.
fn may_start(error: &Error) -> bool {
    match error {
        Error::Io(error) => error.kind() == ErrorKind::ConnectionRefused,
        error => code(error) == CANNOT_CONNECT_NOW,
    }
}

fn code(error: &Error) -> String {
    error.as_database_error().and_then(DatabaseError::code).unwrap_or_default().into_owned()
}

/// Why a database cannot be opened, and what helps.
fn closed(options: &PgConnectOptions, error: Error) -> JobsError {
    let code = code(&error);
    let remedy = if code == NO_DATABASE {
        "create it (`createdb`), or name another one"
    } else if code.starts_with(NOT_AUTHORISED) {
        "correct user and password, or let the server accept them (pg_hba.conf)"
    } else {
        "start the server, or correct host and port"
    };
    refused(options, error.into(), remedy)
}

fn refused(
    options: &PgConnectOptions,
    source: Box<dyn std::error::Error + Send + Sync>,
    remedy: &'static str,
) -> JobsError {
    let user = options.get_username();
    let database = options.get_database().unwrap_or(user);
    let server = match options.get_socket() {
        Some(socket) => socket.display().to_string(),
        None => format!("{}:{}", options.get_host(), options.get_port()),
    };
    let database = format!("{database:?} at {server} as {user:?}");
    JobsError::Database { database, source, remedy }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_server_that_hangs_up_is_named_without_the_password() {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        tokio::spawn(async move { while listener.accept().await.is_ok() {} });
        let options = format!("postgres://anna:secret@127.0.0.1:{port}/jobs").parse().unwrap();
        let error = try_connect(&options).await.unwrap_err().to_string();
        assert!(error.contains(&format!("\"jobs\" at 127.0.0.1:{port} as \"anna\"")), "{error}");
        assert!(error.contains("correct host and port") && !error.contains("secret"), "{error}");
    }
}
