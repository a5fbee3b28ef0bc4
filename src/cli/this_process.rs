//! The process of the service: its program, and how it gets its memory and gives it back.

use std::io;
use std::path::{Path, PathBuf};

/// The file of this program. Linux finds it even if another one has taken its place.
pub(super) fn this_program() -> io::Result<PathBuf> {
    let of_process = Path::new("/proc/self/exe");
    if of_process.exists() { Ok(of_process.to_owned()) } else { std::env::current_exe() }
}

/// Begins this process again, once, such that memory of documents goes back to the system when it is free. glibc by itself raises the
/// threshold to the largest document that was freed, and keeps several of that size for each of its arenas (`mallopt(3)`,
/// `M_MMAP_THRESHOLD`); it reads the variable only at the start of a process.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(super) fn give_memory_back() {
    use crate::service::jobs::process::MMAP_THRESHOLD;
    use std::os::unix::process::CommandExt as _;
    /// Size from which an allocation is a mapping of its own [bytes]: that with which glibc begins.
    const LARGE: &str = "131072";
    if std::env::var_os(MMAP_THRESHOLD).is_some() {
        return;
    }
    let mut arguments = std::env::args_os();
    // By its name, which operators look for.
    let (Some(name), Ok(program)) = (arguments.next(), std::env::current_exe()) else { return };
    let mut again = std::process::Command::new(program);
    let error = again.arg0(name).args(arguments).env(MMAP_THRESHOLD, LARGE).exec();
    tracing::warn!(%error, "the service keeps memory that it no longer needs");
}

/// Other allocators are left as they are.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(super) fn give_memory_back() {}
