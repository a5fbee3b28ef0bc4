//! `contuse doctor`: what is damaged or lost in a data folder, and what can be recovered.

use super::serve::keep_files_private;
use super::{CliError, Exit};
use crate::service::doctor::{Diagnosis, examine};
use crate::service::jobs::store::StoreAddress;
use clap::Args;
use std::io::{self, Write};
use std::path::PathBuf;

/// Flags of `contuse doctor`.
#[derive(Args, Clone, Debug)]
pub struct DoctorArgs {
    /// Where the service, which is not running, stores its data.
    #[command(flatten)]
    store: StoreAddress,
}

/// Examines a data folder. Exit code 0 if nothing is damaged or lost, 3 otherwise.
///
/// # Errors
/// If the folder does not exist, is in use or cannot be read.
pub fn doctor(args: &DoctorArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    if !args.store.is_shared() && !args.store.data.is_dir() {
        return Err(CliError::Usage(format!(
            "{} is not a folder: name that of the service with --data",
            args.store.data.display()
        )));
    }
    keep_files_private();
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    let diagnosis = runtime.block_on(examine(&args.store));
    let diagnosis = diagnosis.map_err(|error| CliError::Other(Box::new(error)))?;
    write(&diagnosis, &args.store, out)?;
    Ok(if diagnosis.is_sound() { Exit::Success } else { Exit::RunFailed })
}

fn write(diagnosis: &Diagnosis, address: &StoreAddress, out: &mut dyn Write) -> io::Result<()> {
    for fault in &diagnosis.store {
        writeln!(out, "job store: {fault}")?;
    }
    if !diagnosis.store.is_empty() {
        writeln!(
            out,
            "  restore {} from a backup of {}; the recordings below do not need it",
            address.to_restore(),
            address.data.display()
        )?;
    }
    if let Some(fault) = &diagnosis.blobs {
        writeln!(out, "object store: {fault}")?;
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
        let place = &lost.place;
        match &lost.readable {
            Ok(()) => writeln!(
                out,
                "recording {place}: its job is lost; `contuse report` and `contuse export` read it"
            )?,
            Err(reason) => writeln!(
                out,
                "recording {place}: its job is lost, and no report of it can be made: {reason}"
            )?,
        }
    }
    for name in &diagnosis.without_file {
        writeln!(out, "mesh {name}: its file is lost; upload the same file again")?;
    }
    write_open(&diagnosis.open_to_others, address, out)?;
    if diagnosis.is_sound() {
        writeln!(out, "nothing is damaged or lost")?;
    }
    Ok(())
}

/// Files that are named one by one; more are counted.
const MOST_NAMED: usize = 20;

/// Says what other users of the machine could read, and how to close it.
fn write_open(open: &[(PathBuf, u32)], address: &StoreAddress, out: &mut dyn Write) -> io::Result<()> {
    for (path, mode) in open.iter().take(MOST_NAMED) {
        writeln!(
            out,
            "{}: other users of this machine could read or enter it (mode {mode:04o})",
            path.display()
        )?;
    }
    if open.len() > MOST_NAMED {
        writeln!(out, "and {} more", open.len() - MOST_NAMED)?;
    }
    if !open.is_empty() {
        let data = address.data.display();
        writeln!(
            out,
            "  {data} is closed now (mode 0700); close what is in it with `chmod -R go= {data}`, too"
        )?;
    }
    Ok(())
}
