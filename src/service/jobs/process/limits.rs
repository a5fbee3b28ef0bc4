//! Limits that the process of a run sets for itself before it begins.

use serde::{Deserialize, Serialize};

/// Limits of a process.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Limits {
    /// Memory that it may take [bytes].
    pub memory_bytes: u64,
    /// Processor time of all its threads [s].
    pub cpu_s: u64,
}

/// Sets the limits. Memory beyond them is refused by the system, whereupon the process aborts; and a process that fails writes no
/// image of its memory, which holds what it computed.
///
/// # Errors
/// If the system refuses them.
#[cfg(unix)]
pub(super) fn apply(limits: Limits) -> std::io::Result<()> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let set = |resource, most: u64| {
        // A limit of the service itself that is lower stays.
        let inherited = getrlimit(resource);
        let most = inherited.maximum.map_or(most, |inherited| inherited.min(most));
        setrlimit(resource, Rlimit { current: Some(most), maximum: inherited.maximum })
    };
    set(Resource::Core, 0)?;
    set(Resource::Cpu, limits.cpu_s)?;
    if LIMITS_MEMORY {
        set(Resource::Data, limits.memory_bytes)?;
    }
    Ok(())
}

/// The system has no such limits.
#[cfg(not(unix))]
pub(super) fn apply(_: Limits) -> std::io::Result<()> {
    Ok(())
}

/// Lets the system end this process first where memory is short, before the service.
pub(super) fn prefer_for_killing() {
    // Only Linux has the file; without it the system chooses by itself.
    let _ = std::fs::write("/proc/self/oom_score_adj", "1000");
}

/// Lets the system prefer the service, which answers requests, to this process on its processors.
///
/// # Errors
/// If the system refuses that.
#[cfg(unix)]
pub(super) fn yield_to_requests() -> std::io::Result<()> {
    rustix::process::nice(NICE)?;
    Ok(())
}

#[cfg(not(unix))]
pub(super) fn yield_to_requests() -> std::io::Result<()> {
    Ok(())
}

/// What a run adds to the niceness of the service.
#[cfg(unix)]
const NICE: i32 = 10;

/// Whether the memory of a process can be limited on this system: elsewhere it does not count what is mapped.
pub(super) const LIMITS_MEMORY: bool = cfg!(target_os = "linux");
