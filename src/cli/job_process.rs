//! `contuse job-process`: the process of a run, which a service starts.

use super::{CliError, Exit};
use crate::service::jobs::process::serve_one;
use std::io;
use std::sync::Arc;

/// Does the task on standard input, and writes messages to standard output.
///
/// # Errors
/// If the pipes of the service fail.
pub fn job_process() -> Result<Exit, CliError> {
    // A file that grows beyond a limit of the process is an error of its write, not the end of the process.
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
    serve_one(io::stdin(), messages()?)?;
    Ok(Exit::Success)
}

/// Standard output without its lock, which the results of other commands hold.
#[cfg(unix)]
fn messages() -> io::Result<std::fs::File> {
    use std::os::fd::AsFd as _;
    Ok(io::stdout().as_fd().try_clone_to_owned()?.into())
}

#[cfg(not(unix))]
fn messages() -> io::Result<io::Sink> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "a service starts processes on Unix only"))
}
