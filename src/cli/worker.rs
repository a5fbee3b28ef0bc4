//! `contuse worker`: runs the jobs of a database that other processes share.

use super::serve::{count_signals, prepare, signalled};
use super::work_args::WorkArgs;
use super::{CliError, Exit};
use crate::service::config::{Role, ServiceConfig};
use crate::service::jobs::JobState;
use crate::service::jobs::worker::Outcome;
use crate::service::work::{work, work_once};
use clap::Args;
use std::io::Write;

/// Flags of `contuse worker`.
#[derive(Args, Clone, Debug)]
pub struct WorkerArgs {
    /// Where the service stores its data, and how jobs are run.
    #[command(flatten)]
    pub(super) work: WorkArgs,
    /// Run the job that has waited longest, and end. Exit codes: 0 the job succeeded, 3 it failed, 4 it was cancelled or deleted, 6 it
    /// returned to the queue or another process has it, 7 no job waits.
    #[arg(long)]
    once: bool,
}

/// Runs jobs until SIGTERM, SIGINT or SIGHUP, or one job; a second signal shortens the shutdown.
///
/// # Errors
/// If the stores cannot be used, or the flags are invalid.
pub fn worker(args: WorkerArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    if !args.work.store.is_shared() {
        return Err(CliError::Usage(
            "a worker needs a --database: the jobs of a data folder are run by `contuse serve`".into(),
        ));
    }
    if args.work.workers == Some(0) {
        return Err(CliError::Usage("--workers must be at least 1".into()));
    }
    let config = ServiceConfig { role: Role::Worker, ..args.work.config()? };
    let (engine, runtime) = prepare(&config)?;
    let worked = runtime.block_on(async {
        let signals = count_signals()?;
        let stop = signalled(signals.clone(), 1);
        if !args.once {
            let worked = work(config, engine, stop, signalled(signals, 2)).await;
            return worked.map(|()| Exit::Success).map_err(|error| CliError::Other(Box::new(error)));
        }
        let worked = work_once(config, engine, stop).await;
        let Some((id, outcome)) = worked.map_err(|error| CliError::Other(Box::new(error)))? else {
            writeln!(out, "no job waits")?;
            return Ok(Exit::NoJob);
        };
        let (word, exit) = match outcome {
            Outcome::Ended(JobState::Succeeded) => ("succeeded", Exit::Success),
            Outcome::Ended(JobState::Cancelled) => ("cancelled", Exit::Cancelled),
            Outcome::Ended(_) => ("failed", Exit::RunFailed),
            Outcome::Deleted => ("deleted", Exit::Cancelled),
            Outcome::NotOver => ("not over", Exit::NotOver),
        };
        writeln!(out, "{id} {word}")?;
        Ok(exit)
    });
    // Threads still running end with the process.
    runtime.shutdown_background();
    worked
}
