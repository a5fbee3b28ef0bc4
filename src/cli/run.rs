//! `contuse run`: run a scene and record it.

use super::{CliError, Exit};
use crate::scene::{Budget, load_file};
use clap::Args;
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `contuse run`.
#[derive(Args, Debug)]
pub struct RunArgs {
    /// The scene document; its mesh files lie beside it.
    pub scene: PathBuf,
    /// Recording to write [default: the scene's name with .mcap, in the current folder].
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Print the summary as JSON.
    #[arg(long)]
    pub json: bool,
    /// Threads to use; by default all cores.
    #[arg(long)]
    pub threads: Option<usize>,
    /// No progress bar and no table.
    #[arg(short, long)]
    pub quiet: bool,
    /// Stop after so many seconds of wall time.
    #[arg(long)]
    pub deadline_s: Option<f64>,
}

/// Runs a scene.
///
/// # Errors
/// What is wrong with the scene.
pub fn run(args: &RunArgs, _out: &mut dyn Write) -> Result<Exit, CliError> {
    load_file(&args.scene, &Budget::COMMAND_LINE)?;
    Err(CliError::Usage("this build has no stepper".into()))
}
