//! The command line of Contuse: `contuse help` says what there is.

use clap::Parser as _;
use contuse::cli::{Cli, Exit, dispatch};
use std::io::{self, IsTerminal as _, Write as _};
use std::process::ExitCode;
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let cli = Cli::parse();
    // Results go to standard output, all else to standard error; RUST_LOG chooses how much of it.
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(cli.default_log()));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .init();

    let mut out = io::BufWriter::new(io::stdout().lock());
    let outcome = dispatch(cli, &mut out).and_then(|exit| Ok(out.flush().map(|()| exit)?));
    match outcome {
        Ok(exit) => exit.into(),
        // A reader that has seen enough (`contuse … | head`) is no failure.
        Err(error) if error.is_broken_pipe() => Exit::Success.into(),
        Err(error) => {
            let exit = error.exit();
            let _ = writeln!(io::stderr(), "contuse: {}", error.in_full());
            exit.into()
        }
    }
}
