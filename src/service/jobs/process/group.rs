//! A group of processes (cgroup) for each run, where the operator gives the service a folder of them. It counts what the limits of a
//! process do not: pages of files, memory that is mapped or shared, and processes that a run might start.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Name of a group, before the number of its process.
const NAME: &str = "contuse-run-";
/// Attempts to remove a group whose processes are ending, and the pause between them.
const REMOVALS: u32 = 50;
const PAUSE: Duration = Duration::from_millis(10);

/// What is done about a folder in which there can be no groups.
const REMEDY: &str = "give a folder of version 2 that is delegated to this user and has no processes of its own (systemd: Delegate=yes, \
    DelegateSubgroup=service), or one of the memory controller of version 1; or omit --cgroup";

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
        if !is_of_groups(&folder)? {
            return Err(io::Error::other(format!("it is not a folder of cgroups; {REMEDY}")));
        }
        let groups = if folder.join("memory.limit_in_bytes").exists() {
            Self { folder, limit: "memory.limit_in_bytes", events: "memory.oom_control" }
        } else {
            let unusable =
                |error| io::Error::other(format!("memory cannot be limited in it ({error}); {REMEDY}"));
            set(&folder.join("cgroup.subtree_control"), "+memory").map_err(unusable)?;
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
        set(&group.folder.join(self.limit), &memory_bytes.to_string())?;
        // Only where the kernel counts swap.
        for (file, most) in [("memory.swap.max", 0), ("memory.memsw.limit_in_bytes", memory_bytes)] {
            let path = group.folder.join(file);
            if path.exists() {
                set(&path, &most.to_string())?;
            }
        }
        set(&group.folder.join("cgroup.procs"), &process.to_string())?;
        Ok(group)
    }
}

/// Writes to a file of the kernel, which is there already.
fn set(file: &Path, text: &str) -> io::Result<()> {
    OpenOptions::new().write(true).open(file)?.write_all(text.as_bytes())
}

/// Whether a folder is of the file system of cgroups, version 1 or 2 (`linux/magic.h`).
#[cfg(target_os = "linux")]
#[allow(clippy::useless_conversion)] // some machines have fewer bits here
fn is_of_groups(folder: &Path) -> io::Result<bool> {
    const VERSION_1: i64 = 0x0027_e0eb;
    const VERSION_2: i64 = 0x6367_7270;
    let kind = rustix::fs::statfs(folder)?.f_type;
    Ok([VERSION_1, VERSION_2].contains(&i64::from(kind)))
}

/// Only Linux has such folders.
#[cfg(not(target_os = "linux"))]
fn is_of_groups(_: &Path) -> io::Result<bool> {
    Ok(false)
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
