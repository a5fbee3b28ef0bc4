//! The files of the audit log: lines are appended to one, which is continued in a new one when it is full.

use crate::record::is_what_was_found;
use crate::report::date::compact_now;
use crate::service::jobs::JobsError;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// Name of the file that is written.
const NAME: &str = "audit.jsonl";
/// Size at which it is full [bytes].
pub(super) const FULL_BYTES: u64 = 256 << 20;

/// The file that is written, and those that are full. A full one is called `audit.jsonl.20261231T235959Z`, after the time in UTC at which
/// it was full, so that names are in the order of time.
#[derive(Debug)]
pub(super) struct AuditFile {
    folder: PathBuf,
    file: File,
    /// Size of all files beyond which the oldest is removed [bytes].
    most_bytes: u64,
}

impl AuditFile {
    /// Opens the log in a folder, and continues it.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub fn open(folder: &Path, most_bytes: u64) -> Result<Self, JobsError> {
        let path = folder.join(NAME);
        let file = continued(&path).map_err(|error| JobsError::file(path, error))?;
        Ok(Self { folder: folder.to_owned(), file, most_bytes })
    }

    /// Appends a line, whole or not at all. Whether it is the first of a new file.
    pub fn append(&mut self, line: &[u8]) -> io::Result<bool> {
        let path = self.folder.join(NAME);
        if !is_what_was_found(&self.file, std::fs::metadata(&path))? {
            // Someone has moved or removed it.
            self.file = continued(&path)?;
        }
        let mut length = self.file.metadata()?.len();
        let is_full = length >= FULL_BYTES;
        if is_full {
            std::fs::rename(&path, self.unused_name()?)?;
            (self.file, length) = (continued(&path)?, 0);
        }
        // A line that was not written whole, as on a full disk, is removed again.
        self.file.write_all(line).inspect_err(|_| {
            if let Err(error) = self.file.set_len(length) {
                tracing::error!(%error, "the audit log has a line that is not whole");
            }
        })?;
        Ok(is_full)
    }

    /// Removes the oldest full files while all take more than they may, and gives their names.
    pub fn remove_oldest(&self) -> io::Result<Vec<String>> {
        let full = self.full()?;
        let mut bytes: u64 = self.file.metadata()?.len() + full.iter().map(|(_, bytes)| bytes).sum::<u64>();
        let mut removed = Vec::new();
        for (name, length) in full {
            if bytes <= self.most_bytes {
                break;
            }
            std::fs::remove_file(self.folder.join(&name))?;
            bytes -= length;
            removed.push(name);
        }
        Ok(removed)
    }

    /// Names and sizes of the full files, the oldest first.
    fn full(&self) -> io::Result<Vec<(String, u64)>> {
        let mut full = Vec::new();
        for entry in std::fs::read_dir(&self.folder)? {
            let entry = entry?;
            let Ok(name) = entry.file_name().into_string() else { continue };
            if name.strip_prefix(NAME).is_some_and(|rest| rest.starts_with('.')) {
                full.push((name, entry.metadata()?.len()));
            }
        }
        full.sort();
        Ok(full)
    }

    /// The name of the file that is full now. Where the clock was set back, it is still later than those of the others.
    fn unused_name(&self) -> io::Result<PathBuf> {
        let last = self.full()?.pop().map(|(name, _)| name).unwrap_or_default();
        let name = format!("{NAME}.{}", compact_now());
        // A longer name is later than its beginning.
        Ok(self.folder.join(if name > last { name } else { format!("{last}+") }))
    }
}

/// Opens a file to append lines to it. Where its process ended within the last line, the next one begins on its own.
fn continued(path: &Path) -> io::Result<File> {
    let mut file = OpenOptions::new().create(true).read(true).append(true).open(path)?;
    let mut last = [b'\n'];
    if file.metadata()?.len() > 0 {
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
    }
    if last != [b'\n'] {
        file.write_all(b"\n")?;
    }
    Ok(file)
}
