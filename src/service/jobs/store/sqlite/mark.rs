//! What the store last knew of itself: the number of its changes, in a small file beside it. A store that has fewer at its next start has
//! lost the log with its last transactions, or a part of it.

use crate::service::jobs::JobsError;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// End of the name of the file, which is there from the first change of a process to its orderly end.
const OPEN: &str = "-open";

/// The file with the number.
#[derive(Clone, Debug)]
pub(super) struct Mark(PathBuf);

impl Mark {
    /// That of the store in a file.
    pub fn beside(store: &Path) -> Self {
        let mut name = store.as_os_str().to_owned();
        name.push(OPEN);
        Self(name.into())
    }

    /// Notes how many changes are durable. The note itself need not be: an older one finds fewer losses, and none that is not there.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn note(&self, changes: i32) -> Result<(), JobsError> {
        // Always as long: it replaces the one before in a single call.
        let written = OpenOptions::new().create(true).write(true).truncate(false).open(&self.0);
        let written = written.and_then(|mut file| file.write_all(format!("{changes:>11}\n").as_bytes()));
        written.map_err(|error| JobsError::file(&self.0, error))
    }

    /// The number of changes that were durable; `None` if the last process ended in order.
    pub fn noted(&self) -> Option<i32> {
        std::fs::read_to_string(&self.0).ok()?.trim().parse().ok()
    }

    /// Removes the file, at the orderly end.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub fn forget(&self) -> Result<(), JobsError> {
        match std::fs::remove_file(&self.0) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(JobsError::file(&self.0, error)),
            _ => Ok(()),
        }
    }
}
