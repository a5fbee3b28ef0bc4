//! The audit log: who did what, and when, as a line of JSON for each request that changes jobs or meshes or reads results.
//!
//! It names owners, addresses, ids and statuses, never scenes. It stays when jobs are deleted; of its files the oldest is removed when all
//! are too large, which the log says.
//! Where lines cannot be written, the next one that can says how many are lost.
//! Refused requests, of which anyone can send any number, are counted, and their counts written every minute.

use super::audit_file::AuditFile;
use super::jobs::JobsError;
use super::refusals::{Kind, Refusals};
use crate::report::date::now;
use serde::Serialize;
use std::io;
use std::net::IpAddr;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

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

/// A file of the log that was removed.
#[derive(Serialize)]
struct Removed<'a> {
    removed: &'a str,
}

/// Lines that could not be written before this one.
#[derive(Serialize)]
struct Lost {
    lost: u64,
}

/// The files, and how many lines they lack at the end.
#[derive(Debug)]
struct Lines {
    file: AuditFile,
    lost: u64,
}

/// An audit log in files.
#[derive(Debug)]
pub struct Audit {
    lines: Mutex<Lines>,
    failures: AtomicU64,
    refusals: Refusals,
}

#[derive(Serialize)]
struct Line<'a, T> {
    at: &'a str,
    #[serde(flatten)]
    entry: &'a T,
}

impl Audit {
    /// Opens the log in a folder, and continues it. All its files have at most `most_bytes`, beyond which the oldest are removed.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub fn open(folder: &Path, most_bytes: u64) -> Result<Self, JobsError> {
        let mut file = AuditFile::open(folder, most_bytes)?;
        remove_oldest(&mut file).map_err(|error| JobsError::file(folder, error))?;
        let lines = Mutex::new(Lines { file, lost: 0 });
        Ok(Self { lines, failures: AtomicU64::new(0), refusals: Refusals::default() })
    }

    /// Appends an entry.
    pub fn record(&self, entry: &Entry<'_>) {
        self.append(entry);
    }

    /// Number of lines that could not be written so far.
    pub fn failures(&self) -> u64 {
        self.failures.load(Ordering::Relaxed)
    }

    /// Whether lines can be written, which is tried if the last one could not be.
    pub fn accepts_lines(&self) -> bool {
        self.lines().make_up().is_ok()
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

    /// Appends a line. A failure is counted, the first of several logged: the request has been answered.
    fn append(&self, entry: &impl Serialize) {
        let mut lines = self.lines();
        if let Err(error) = lines.append(entry) {
            if lines.lost == 0 {
                tracing::error!(%error, "the audit log cannot be written");
            }
            lines.lost += 1;
            self.failures.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn lines(&self) -> MutexGuard<'_, Lines> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Lines {
    fn append(&mut self, entry: &impl Serialize) -> io::Result<()> {
        self.make_up()?;
        if self.file.append(&line(entry)?)?
            && let Err(error) = remove_oldest(&mut self.file)
        {
            // The line itself is there.
            tracing::error!(%error, "the oldest file of the audit log cannot be removed");
        }
        Ok(())
    }

    /// Says in the log how many lines it lacks, if any.
    fn make_up(&mut self) -> io::Result<()> {
        if self.lost > 0 {
            self.file.append(&line(&Lost { lost: self.lost })?)?;
            tracing::warn!(lost = self.lost, "the audit log is written again, and lacks some lines");
            self.lost = 0;
        }
        Ok(())
    }
}

/// Removes the oldest files while all are too large, and says so.
fn remove_oldest(file: &mut AuditFile) -> io::Result<()> {
    for removed in file.remove_oldest()? {
        tracing::warn!(
            removed,
            "the audit log is as large as it may be (--max-audit): its oldest file is removed"
        );
        file.append(&line(&Removed { removed: &removed })?)?;
    }
    Ok(())
}

/// An entry as a line of the log.
fn line(entry: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let mut line = serde_json::to_vec(&Line { at: &now(), entry })?;
    line.push(b'\n');
    Ok(line)
}

impl Drop for Audit {
    fn drop(&mut self) {
        self.append_counts();
    }
}

#[cfg(test)]
mod tests {
    use super::super::audit_file::FULL_BYTES;
    use super::*;
    use std::fs::File;

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
            Audit::open(folder.path(), u64::MAX).unwrap().record(&Entry { status, ..ENTRY });
        }
        std::fs::write(folder.path().join("audit.jsonl"), text(folder.path(), "audit.jsonl") + "{\"at\"")
            .unwrap();
        Audit::open(folder.path(), u64::MAX).unwrap().record(&ENTRY);
        let text = text(folder.path(), "audit.jsonl");
        let lines: Vec<&str> = text.lines().collect();
        let read = |line: &str| serde_json::from_str::<serde_json::Value>(line);
        assert_eq!((lines.len(), &read(lines[1]).unwrap()["status"]), (4, &404.into()));
        assert!(read(lines[2]).is_err() && read(lines[3]).is_ok(), "{text}");
        assert!(read(lines[0]).unwrap()["at"].as_str().unwrap().ends_with('Z'));
    }

    /// A log whose file is full, with a limit on the size of all.
    fn full(folder: &Path, most_bytes: u64) -> Audit {
        let file = File::create(folder.join("audit.jsonl")).unwrap();
        file.set_len(FULL_BYTES - 1).unwrap();
        Audit::open(folder, most_bytes).unwrap()
    }

    /// The full files, in the order of their names.
    fn full_files(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap().flatten();
        let mut names: Vec<String> = entries.map(|entry| entry.file_name().into_string().unwrap()).collect();
        names.sort();
        assert_eq!(names.remove(0), "audit.jsonl");
        names
    }

    #[test]
    fn full_files_are_kept_in_the_order_of_time() {
        let folder = tempfile::tempdir().unwrap();
        let mut kept: Vec<String> = Vec::new();
        for _ in 0..4 {
            full(folder.path(), u64::MAX).record(&ENTRY);
            assert_eq!(text(folder.path(), "audit.jsonl").lines().count(), 1);
            let names = full_files(folder.path());
            assert_eq!((&names[..kept.len()], names.len()), (&kept[..], kept.len() + 1), "a later one");
            kept = names;
            // Whoever removes an older one changes no other name, nor which one is next.
            if kept.len() == 2 {
                std::fs::remove_file(folder.path().join(kept.remove(0))).unwrap();
            }
        }
        assert!(
            kept[0].starts_with("audit.jsonl.20") && kept[0].len() >= "audit.jsonl.20261231T235959Z".len()
        );
    }

    #[test]
    fn a_clock_that_was_set_back_does_not_change_their_order() {
        let folder = tempfile::tempdir().unwrap();
        File::create(folder.path().join("audit.jsonl.29991231T235959Z")).unwrap();
        for count in 2..4 {
            full(folder.path(), u64::MAX).record(&ENTRY);
            let names = full_files(folder.path());
            assert_eq!((names.len(), names[0].as_str()), (count, "audit.jsonl.29991231T235959Z"));
        }
    }

    #[test]
    fn the_oldest_file_is_removed_when_all_are_too_large_and_the_log_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let most = 3 * FULL_BYTES;
        full(folder.path(), most).record(&ENTRY);
        let oldest = full_files(folder.path()).remove(0);
        for _ in 0..2 {
            full(folder.path(), most).record(&ENTRY);
        }
        let kept = full_files(folder.path());
        assert!(kept.len() == 2 && !kept.contains(&oldest), "{kept:?}");
        let log = text(folder.path(), "audit.jsonl");
        let last: serde_json::Value = serde_json::from_str(log.lines().last().unwrap()).unwrap();
        assert_eq!((log.lines().count(), &last["removed"]), (2, &oldest.as_str().into()));
        // A lower limit holds from the next start on.
        drop(Audit::open(folder.path(), 1).unwrap());
        assert!(full_files(folder.path()).is_empty());
        assert_eq!(text(folder.path(), "audit.jsonl").lines().count(), 4);
    }

    /// A disk without room for any line.
    #[cfg(target_os = "linux")]
    #[test]
    fn lines_that_cannot_be_written_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/dev/full", folder.path().join("audit.jsonl")).unwrap();
        let audit = Audit::open(folder.path(), u64::MAX).unwrap();
        assert!(audit.accepts_lines());
        for _ in 0..3 {
            audit.record(&ENTRY);
        }
        assert_eq!((audit.failures(), audit.accepts_lines()), (3, false));
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_moved_away_is_begun_anew() {
        let folder = tempfile::tempdir().unwrap();
        let audit = Audit::open(folder.path(), u64::MAX).unwrap();
        audit.record(&ENTRY);
        std::fs::rename(folder.path().join("audit.jsonl"), folder.path().join("moved")).unwrap();
        audit.record(&ENTRY);
        std::fs::remove_file(folder.path().join("audit.jsonl")).unwrap();
        audit.record(&ENTRY);
        for name in ["moved", "audit.jsonl"] {
            assert_eq!(text(folder.path(), name).lines().count(), 1);
        }
    }

    #[test]
    fn a_flood_of_refused_requests_is_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let audit = Audit::open(folder.path(), u64::MAX).unwrap();
        for _ in 0..100_000 {
            audit.refused(None, Some([127, 0, 0, 1].into()), 401);
        }
        drop(audit);
        let line: serde_json::Value = serde_json::from_str(&text(folder.path(), "audit.jsonl")).unwrap();
        assert_eq!((&line["refused"], &line["network"]), (&100_000.into(), &"127.0.0.0/24".into()));
    }
}
