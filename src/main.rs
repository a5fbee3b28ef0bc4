//! The command line of Contuse: `contuse help` lists the commands.

use clap::Parser as _;
use contuse::cli::log::Log;
use contuse::cli::{Cli, CliError, Exit, dispatch};
use std::io::{self, IsTerminal as _, Write as _};
use std::process::ExitCode;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

fn main() -> ExitCode {
    let cli = Cli::parse();
    // A service goes on without a reader of its log; a command is read by someone.
    let log = if cli.is_service() { Log::queued().unwrap_or_else(|_| Log::direct()) } else { Log::direct() };
    let outcome = run(cli, log.clone());
    let exit = match outcome {
        Ok(exit) => exit,
        // A reader that closes the pipe early (`contuse … | head`) is no failure.
        Err(error) if error.is_broken_pipe() => Exit::Success,
        Err(error) => {
            let _ = write_last(log.clone(), &error);
            error.exit()
        }
    };
    log.finish();
    exit.into()
}

/// Writes why the command could not be executed, in one piece.
fn write_last(mut log: Log, error: &CliError) -> io::Result<()> {
    log.write_all(format!("contuse: {}\n", error.in_full()).as_bytes())
}

/// Executes the command with its log.
fn run(cli: Cli, log: Log) -> Result<Exit, CliError> {
    // Results go to standard output, everything else to standard error; RUST_LOG sets its level.
    let chosen = std::env::var("RUST_LOG").ok().and_then(|words| words.parse().ok());
    let filter: Targets = chosen.or_else(|| cli.default_log().parse().ok()).unwrap_or_default();
    let lines = tracing_subscriber::fmt::layer().with_writer(log).with_ansi(io::stderr().is_terminal());
    let lines = match (cli.logs_json(), cli.is_read_by_service()) {
        (true, _) => lines.json().flatten_event(true).boxed(),
        (false, true) => lines.without_time().with_target(false).boxed(),
        (false, false) => lines.boxed(),
    };
    let subscriber = tracing_subscriber::registry().with(lines.with_filter(filter));
    #[cfg(feature = "otel")]
    let traces = exporter_of(&cli).map_err(|error| CliError::Usage(error.to_string()))?;
    #[cfg(feature = "otel")]
    let subscriber = subscriber.with(traces.as_ref().map(contuse::service::traces::Exporter::layer));
    subscriber.init();

    let mut out = io::BufWriter::new(io::stdout().lock());
    let exit = dispatch(cli, &mut out)?;
    out.flush()?;
    Ok(exit)
}

/// Sends traces to a collector, except of the processes of runs, of which the service does.
#[cfg(feature = "otel")]
fn exporter_of(
    cli: &Cli,
) -> Result<Option<contuse::service::traces::Exporter>, impl std::fmt::Display + use<>> {
    let exporter = || contuse::service::traces::Exporter::from_environment();
    if cli.is_read_by_service() { Ok(None) } else { exporter() }
}
