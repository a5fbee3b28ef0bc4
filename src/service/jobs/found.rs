//! Store and blobs compared: what one has and the other lacks.

use super::JobId;
use super::store::KnownBlobs;
use crate::blobs::{BlobError, BlobStore};
use crate::service::meshes::is_id;
use crate::service::shelves::{MESHES, PROBES, RECORDINGS, RESULTS, SNAPSHOTS, is_recording};
use std::collections::BTreeSet;
use std::time::Duration;

/// Number of ids in a line of the log.
const SHOWN: usize = 5;

/// What store and blobs do not have in common.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Recordings of jobs that the store does not have.
    pub without_job: Vec<String>,
    /// Jobs whose recording is missing.
    pub without_recording: Vec<JobId>,
    /// Meshes that the store has, and whose files are missing.
    pub without_file: Vec<String>,
    /// Other blobs that the store does not refer to.
    pub unknown: Vec<String>,
}

impl Found {
    /// Compares what is known to a store with a store of blobs; blobs younger than `least_age` are not unknown.
    ///
    /// # Errors
    /// If the blobs cannot be listed.
    pub fn among(blobs: &dyn BlobStore, known: &KnownBlobs, least_age: Duration) -> Result<Self, BlobError> {
        let mut found = Self::default();
        let mut present = BTreeSet::new();
        for shelf in [SNAPSHOTS, PROBES, MESHES, RECORDINGS, RESULTS] {
            for entry in blobs.list(shelf)? {
                match (known.names.contains(&entry.name), is_recording(&entry.name)) {
                    (true, _) => {
                        present.insert(entry.name);
                    }
                    (false, _) if entry.age() < least_age => {}
                    (false, true) => found.without_job.push(entry.name),
                    (false, false) => found.unknown.push(entry.name),
                }
            }
        }
        let missing = known.recorded.iter().filter(|(_, name)| !present.contains(*name));
        found.without_recording = missing.map(|(id, _)| *id).collect();
        let meshes = known.names.iter().filter(|name| name.starts_with(MESHES) && !present.contains(*name));
        found.without_file = meshes.cloned().collect();
        Ok(found)
    }

    /// Logs what is missing.
    pub fn report(&self) {
        let report = |what: &str, count: usize, first: Vec<String>| {
            if count > 0 {
                let first = first.join(", ");
                tracing::error!(count, first, "{what}: `contuse doctor` says what can be recovered");
            }
        };
        let first = |names: &[String]| names.iter().take(SHOWN).cloned().collect();
        report("recordings have no job in the store", self.without_job.len(), first(&self.without_job));
        let ids = self.without_recording.iter().take(SHOWN).map(ToString::to_string).collect();
        report("jobs have lost their recordings", self.without_recording.len(), ids);
        report("meshes have lost their files", self.without_file.len(), first(&self.without_file));
    }

    /// Blobs that nothing refers to and no one can miss. With recordings without jobs or unreadable rows, meshes may belong to rows that
    /// are lost, and stay.
    pub fn removable<'a>(&'a self, known: &KnownBlobs) -> impl Iterator<Item = &'a String> {
        let is_doubtful = !self.without_job.is_empty() || known.unreadable > 0 || known.names.is_empty();
        self.unknown.iter().filter(move |name| {
            let id = name.strip_prefix(MESHES).and_then(|name| name.strip_prefix('/')?.split('.').next());
            !(is_doubtful && id.is_some_and(is_id))
        })
    }
}
