//! `contuse doctor`: what is damaged or lost in a data folder, and what can be recovered.

use super::{CliError, Exit};
use crate::service::doctor::{Diagnosis, examine};
use crate::service::jobs::store::StoreAddress;
use clap::Args;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Flags of `contuse doctor`.
#[derive(Args, Clone, Debug)]
pub struct DoctorArgs {
    /// Data folder of a service that is not running.
    #[arg(long, env = "CONTUSE_DATA", default_value = "data")]
    data: PathBuf,
}

/// Examines a data folder. Exit code 0 if nothing is damaged or lost, 3 otherwise.
///
/// # Errors
/// If the folder does not exist, is in use or cannot be read.
pub fn doctor(args: &DoctorArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    if !args.data.is_dir() {
        return Err(CliError::Usage(format!(
            "{} is not a folder: name that of the service with --data",
            args.data.display()
        )));
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let diagnosis = runtime.block_on(examine(&args.data));
    let diagnosis = diagnosis.map_err(|error| CliError::Other(Box::new(error)))?;
    write(&diagnosis, &args.data, out)?;
    Ok(if diagnosis.is_sound() { Exit::Success } else { Exit::RunFailed })
}

fn write(diagnosis: &Diagnosis, data: &Path, out: &mut dyn Write) -> io::Result<()> {
    for fault in &diagnosis.store {
        writeln!(out, "job store: {fault}")?;
    }
    if !diagnosis.store.is_empty() {
        writeln!(
            out,
            "  restore {} from a backup of {}; the recordings below do not need it",
            StoreAddress::of_service(data).to_restore(),
            data.display()
        )?;
    }
    for seq in &diagnosis.unreadable {
        writeln!(out, "job number {seq}: its row cannot be read; the service goes on without it")?;
    }
    for id in &diagnosis.without_recording {
        writeln!(
            out,
            "job {id}: its recording is lost; scene and summary are kept, submit the scene again for a new one"
        )?;
    }
    for lost in &diagnosis.without_job {
        let file = lost.file.display();
        match &lost.readable {
            Ok(()) => writeln!(
                out,
                "recording {file}: its job is lost; `contuse report` and `contuse export` read the file"
            )?,
            Err(reason) => writeln!(
                out,
                "recording {file}: its job is lost, and of the file no report can be made: {reason}"
            )?,
        }
    }
    for name in &diagnosis.without_file {
        writeln!(out, "mesh {name}: its file is lost; upload the same file again")?;
    }
    if diagnosis.is_sound() {
        writeln!(out, "nothing is damaged or lost")?;
    }
    Ok(())
}
