//! The audit log: who did what, and when, as a line of JSON for each request that changes jobs or meshes or reads results.
//!
//! It names owners, addresses, ids and statuses, never scenes. It stays when jobs are deleted, and the service removes nothing of it.
//! Refused requests, of which anyone can send any number, are counted, and their counts written every minute.

use super::jobs::JobsError;
use super::refusals::{Kind, Refusals};
use crate::report::date::now;
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError, Weak};
use std::time::Duration;

/// Size at which the log is continued in a new file [bytes].
const MOST_BYTES: u64 = 256 << 20;
/// Time for which refused requests are counted together.
const COUNTED_FOR: Duration = Duration::from_secs(60);

/// A line of the log: a request with its owner, and the status of the answer.
#[derive(Clone, Debug, Serialize)]
pub struct Entry<'a> {
    /// Owner of the token; empty without tokens, null if none was right.
    pub owner: Option<&'a str>,
    /// Address of the client, or of the proxy before it.
    pub address: Option<IpAddr>,
    /// Method of the request.
    pub method: &'a str,
    /// Path of the request, with the id that it concerns.
    pub path: &'a str,
    /// Address of the job or mesh that the request created.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub created: Option<&'a str>,
    /// Status of the answer.
    pub status: u16,
}

/// Refused requests of one kind since the last such line, at most a minute ago.
#[derive(Serialize)]
struct Count {
    #[serde(flatten)]
    kind: Kind,
    refused: u64,
}

/// An audit log in a file.
#[derive(Debug)]
pub struct Audit {
    path: PathBuf,
    file: Mutex<File>,
    refusals: Refusals,
}

#[derive(Serialize)]
struct Line<'a, T> {
    at: &'a str,
    #[serde(flatten)]
    entry: &'a T,
}

impl Audit {
    /// Opens the log in a folder, and continues it.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub fn open(folder: &Path) -> Result<Self, JobsError> {
        let path = folder.join("audit.jsonl");
        let file = Mutex::new(continued(&path).map_err(|error| JobsError::file(&path, error))?);
        Ok(Self { path, file, refusals: Refusals::default() })
    }

    /// Appends an entry.
    pub fn record(&self, entry: &Entry<'_>) {
        self.append(entry);
    }

    /// Counts a request that was refused.
    pub fn refused(&self, owner: Option<&str>, address: Option<IpAddr>, status: u16) {
        self.refusals.count(owner, address, status);
    }

    /// Writes the counts of refused requests every minute, as long as there is the log.
    pub async fn write_counts(log: Weak<Self>) {
        loop {
            tokio::time::sleep(COUNTED_FOR).await;
            let Some(log) = log.upgrade() else { return };
            log.append_counts();
        }
    }

    fn append_counts(&self) {
        for (kind, refused) in self.refusals.take() {
            self.append(&Count { kind, refused });
        }
    }

    /// Appends a line. A failure is logged: the request has been answered.
    fn append(&self, entry: &impl Serialize) {
        if let Err(error) = self.try_append(entry) {
            tracing::error!(%error, "the audit log cannot be written");
        }
    }

    fn try_append(&self, entry: &impl Serialize) -> io::Result<()> {
        let mut line = serde_json::to_vec(&Line { at: &now(), entry })?;
        line.push(b'\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let mut length = file.metadata()?.len();
        if length >= MOST_BYTES {
            std::fs::rename(&self.path, self.unused_name())?;
            (*file, length) = (continued(&self.path)?, 0);
        }
        // A line that was not written whole, as on a full disk, is removed again.
        file.write_all(&line).inspect_err(|_| {
            if let Err(error) = file.set_len(length) {
                tracing::error!(%error, "the audit log has a line that is not whole");
            }
        })
    }

    /// The first name that no file has of `audit.jsonl.1`, `audit.jsonl.2`, ….
    fn unused_name(&self) -> PathBuf {
        let name = |n: u64| self.path.with_extension(format!("jsonl.{n}"));
        (1..u64::MAX).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(0))
    }
}

impl Drop for Audit {
    fn drop(&mut self) {
        self.append_counts();
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

#[cfg(test)]
mod tests {
    use super::*;

    const ENTRY: Entry<'_> = Entry {
        owner: Some("anna"),
        address: None,
        method: "POST",
        path: "/v1/jobs",
        created: None,
        status: 202,
    };

    fn text(folder: &Path, name: &str) -> String {
        std::fs::read_to_string(folder.join(name)).unwrap()
    }

    #[test]
    fn a_log_is_continued_after_a_line_that_is_not_whole() {
        let folder = tempfile::tempdir().unwrap();
        for status in [202, 404] {
            Audit::open(folder.path()).unwrap().record(&Entry { status, ..ENTRY });
        }
        std::fs::write(folder.path().join("audit.jsonl"), text(folder.path(), "audit.jsonl") + "{\"at\"")
            .unwrap();
        Audit::open(folder.path()).unwrap().record(&ENTRY);
        let text = text(folder.path(), "audit.jsonl");
        let lines: Vec<&str> = text.lines().collect();
        let read = |line: &str| serde_json::from_str::<serde_json::Value>(line);
        assert_eq!((lines.len(), &read(lines[1]).unwrap()["status"]), (4, &404.into()));
        assert!(read(lines[2]).is_err() && read(lines[3]).is_ok(), "{text}");
        assert!(read(lines[0]).unwrap()["at"].as_str().unwrap().ends_with('Z'));
    }

    #[test]
    fn no_file_of_the_log_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        for n in 1..=3 {
            let file = File::create(folder.path().join("audit.jsonl")).unwrap();
            file.set_len(MOST_BYTES - 1).unwrap();
            let audit = Audit::open(folder.path()).unwrap();
            audit.record(&ENTRY);
            assert_eq!(text(folder.path(), "audit.jsonl").lines().count(), 1);
            assert!(folder.path().join(format!("audit.jsonl.{n}")).exists());
        }
    }

    #[test]
    fn a_flood_of_refused_requests_is_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let audit = Audit::open(folder.path()).unwrap();
        for _ in 0..100_000 {
            audit.refused(None, Some([127, 0, 0, 1].into()), 401);
        }
        drop(audit);
        let line: serde_json::Value = serde_json::from_str(&text(folder.path(), "audit.jsonl")).unwrap();
        assert_eq!((&line["refused"], &line["network"]), (&100_000.into(), &"127.0.0.0/24".into()));
    }
}
