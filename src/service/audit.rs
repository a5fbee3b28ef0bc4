//! The audit log: who did what, and when, as a line of JSON for each request that changes jobs or meshes or reads results.
//!
//! It names owners, addresses, ids and statuses, never scenes. It stays when jobs are deleted.

use super::jobs::JobsError;
use crate::report::date::now;
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Size at which the log is continued in a new file [bytes]; the one before it is kept, and no older one.
const MOST_BYTES: u64 = 256 << 20;

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

/// An audit log in a file.
#[derive(Debug)]
pub struct Audit {
    path: PathBuf,
    file: Mutex<File>,
}

#[derive(Serialize)]
struct Line<'a> {
    at: &'a str,
    #[serde(flatten)]
    entry: &'a Entry<'a>,
}

impl Audit {
    /// Opens the log in a folder, and continues it.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub fn open(folder: &Path) -> Result<Self, JobsError> {
        let path = folder.join("audit.jsonl");
        let file = Mutex::new(appended(&path).map_err(|error| JobsError::file(&path, error))?);
        Ok(Self { path, file })
    }

    /// Appends an entry. A failure is logged: the request has been answered.
    pub fn record(&self, entry: &Entry<'_>) {
        if let Err(error) = self.append(entry) {
            tracing::error!(%error, "the audit log cannot be written");
        }
    }

    fn append(&self, entry: &Entry<'_>) -> io::Result<()> {
        let mut line = serde_json::to_vec(&Line { at: &now(), entry })?;
        line.push(b'\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        if file.metadata()?.len() >= MOST_BYTES {
            std::fs::rename(&self.path, self.path.with_extension("jsonl.1"))?;
            *file = appended(&self.path)?;
        }
        // One call: a line is written whole or not at all.
        file.write_all(&line)
    }
}

fn appended(path: &Path) -> io::Result<File> {
    OpenOptions::new().create(true).append(true).open(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_is_continued() {
        let folder = tempfile::tempdir().unwrap();
        for status in [202, 404] {
            let audit = Audit::open(folder.path()).unwrap();
            let entry = Entry {
                owner: Some("anna"),
                address: Some([127, 0, 0, 1].into()),
                method: "POST",
                path: "/v1/jobs",
                created: None,
                status,
            };
            audit.record(&entry);
        }
        let text = std::fs::read_to_string(folder.path().join("audit.jsonl")).unwrap();
        let lines: Vec<serde_json::Value> =
            text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!((lines.len(), &lines[1]["status"]), (2, &404.into()));
        assert!(lines[0]["at"].as_str().unwrap().ends_with('Z') && lines[0]["owner"] == "anna");
    }
}
