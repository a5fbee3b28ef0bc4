//! The command line of Contuse: `contuse help` lists the commands.

use clap::Parser as _;
use contuse::cli::{Cli, Exit, dispatch};
use std::io::{self, IsTerminal as _, Write as _};
use std::process::ExitCode;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

fn main() -> ExitCode {
    let cli = Cli::parse();
    // Results go to standard output, everything else to standard error; RUST_LOG sets its level.
    let chosen = std::env::var("RUST_LOG").ok().and_then(|words| words.parse().ok());
    let filter: Targets = chosen.or_else(|| cli.default_log().parse().ok()).unwrap_or_default();
    let lines =
        tracing_subscriber::fmt::layer().with_writer(io::stderr).with_ansi(io::stderr().is_terminal());
    let lines = match (cli.logs_json(), cli.is_read_by_service()) {
        (true, _) => lines.json().flatten_event(true).boxed(),
        (false, true) => lines.without_time().with_target(false).boxed(),
        (false, false) => lines.boxed(),
    };
    let subscriber = tracing_subscriber::registry().with(lines.with_filter(filter));
    #[cfg(feature = "otel")]
    let traces = match exporter_of(&cli) {
        Ok(traces) => traces,
        Err(error) => {
            let _ = writeln!(io::stderr(), "contuse: {error}");
            return contuse::cli::CliError::Usage(error.to_string()).exit().into();
        }
    };
    #[cfg(feature = "otel")]
    let subscriber = subscriber.with(traces.as_ref().map(contuse::service::traces::Exporter::layer));
    subscriber.init();

    let mut out = io::BufWriter::new(io::stdout().lock());
    let outcome = dispatch(cli, &mut out).and_then(|exit| Ok(out.flush().map(|()| exit)?));
    match outcome {
        Ok(exit) => exit.into(),
        // A reader that closes the pipe early (`contuse … | head`) is no failure.
        Err(error) if error.is_broken_pipe() => Exit::Success.into(),
        Err(error) => {
            let exit = error.exit();
            let _ = writeln!(io::stderr(), "contuse: {}", error.in_full());
            exit.into()
        }
    }
}

/// Sends traces to a collector, except of the processes of runs, of which the service does.
#[cfg(feature = "otel")]
fn exporter_of(
    cli: &Cli,
) -> Result<Option<contuse::service::traces::Exporter>, impl std::fmt::Display + use<>> {
    let exporter = || contuse::service::traces::Exporter::from_environment();
    if cli.is_read_by_service() { Ok(None) } else { exporter() }
}
