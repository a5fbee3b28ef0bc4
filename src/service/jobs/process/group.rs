//! A group of processes (cgroup) for each run, where the operator gives the service a folder of them. It counts what the limits of a
//! process do not: pages of files, memory that is mapped or shared, and processes that a run might start.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Name of a group, before the number of its process.
const NAME: &str = "contuse-run-";
/// Attempts to remove a group whose processes are ending, and the pause between them.
const REMOVALS: u32 = 50;
const PAUSE: Duration = Duration::from_millis(10);

/// A folder for groups: of version 2 of the interface, or of the memory controller of version 1.
#[derive(Clone, Debug)]
pub struct Groups {
    folder: PathBuf,
    /// File with the limit of memory [bytes].
    limit: &'static str,
    /// File that counts processes killed for want of memory, in a line `oom_kill`.
    events: &'static str,
}

impl Groups {
    /// Prepares a folder, and removes groups that an earlier service has left there.
    ///
    /// # Errors
    /// If it is not a folder of groups in which memory can be limited.
    pub fn open(folder: &Path) -> io::Result<Self> {
        let folder = folder.to_owned();
        let groups = if folder.join("memory.limit_in_bytes").exists() {
            Self { folder, limit: "memory.limit_in_bytes", events: "memory.oom_control" }
        } else {
            fs::write(folder.join("cgroup.subtree_control"), "+memory")?;
            Self { folder, limit: "memory.max", events: "memory.events" }
        };
        for entry in fs::read_dir(&groups.folder)?.flatten() {
            if entry.file_name().to_str().is_some_and(|name| name.starts_with(NAME)) {
                // One whose process is ending is empty at the next start.
                let _ = fs::remove_dir(entry.path());
            }
        }
        Ok(groups)
    }

    /// A group with a process in it, which may take so much memory [bytes].
    pub(super) fn group(&self, process: u32, memory_bytes: u64) -> io::Result<Group> {
        let memory_bytes = memory_bytes.min(i64::MAX as u64);
        let folder = self.folder.join(format!("{NAME}{process}"));
        fs::create_dir(&folder)?;
        let group = Group { folder, events: self.events };
        fs::write(group.folder.join(self.limit), memory_bytes.to_string())?;
        // Only where the kernel counts swap.
        for (file, most) in [("memory.swap.max", 0), ("memory.memsw.limit_in_bytes", memory_bytes)] {
            let path = group.folder.join(file);
            if path.exists() {
                fs::write(path, most.to_string())?;
            }
        }
        fs::write(group.folder.join("cgroup.procs"), process.to_string())?;
        Ok(group)
    }
}

/// The group of a run. Dropped, it is removed, which waits for its process to end.
#[derive(Debug)]
pub(super) struct Group {
    folder: PathBuf,
    events: &'static str,
}

impl Group {
    /// Whether a process of it was killed because the group had no more memory.
    pub fn was_refused_memory(&self) -> bool {
        let events = fs::read_to_string(self.folder.join(self.events)).unwrap_or_default();
        events.lines().filter_map(|line| line.strip_prefix("oom_kill ")).any(|count| count != "0")
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        for _ in 0..REMOVALS {
            match fs::remove_dir(&self.folder) {
                Err(error) if error.kind() == io::ErrorKind::ResourceBusy => std::thread::sleep(PAUSE),
                Err(error) => {
                    tracing::warn!(%error, "a group of processes cannot be removed");
                    return;
                }
                Ok(()) => return,
            }
        }
    }
}
