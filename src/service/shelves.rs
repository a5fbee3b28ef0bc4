//! Names of the blobs of the service.

use super::jobs::JobId;
use crate::mesh::read::MeshFormat;

/// Recordings of jobs that have ended.
pub const RECORDINGS: &str = "recordings";
/// Uploaded meshes, named by digest.
pub const MESHES: &str = "meshes";
/// Snapshots of the recordings of running jobs; none outlives the process that took it.
pub const SNAPSHOTS: &str = "snapshots";
/// Small blobs that are written and deleted again, to see whether the store answers: beside the recordings, since access may be given by
/// prefix.
pub const PROBES: &str = "recordings/probes";
/// The identity of the database whose blobs these are, where several machines share them.
pub const DATABASE: &str = "database";
/// Results of what-if runs, by content.
pub const RESULTS: &str = "results";

/// Name of the recording that an attempt at a job has left. Each has its own: one that was taken for lost and ends late replaces nothing.
pub fn recording_name(id: JobId, attempt: u32) -> String {
    if attempt <= 1 { format!("{RECORDINGS}/{id}.mcap") } else { format!("{RECORDINGS}/{id}.{attempt}.mcap") }
}

/// Names of the recordings that the attempts at a job may have left.
pub fn recording_names(id: JobId, attempts: u32) -> impl Iterator<Item = String> {
    (1..=attempts.max(1)).map(move |attempt| recording_name(id, attempt))
}

/// Whether a name is that of a recording.
pub fn is_recording(name: &str) -> bool {
    let stem = name.strip_prefix(RECORDINGS).and_then(|name| name.strip_prefix('/')?.strip_suffix(".mcap"));
    let parts = stem.map(|stem| stem.split_once('.').unwrap_or((stem, "1")));
    parts.is_some_and(|(id, attempt)| JobId::try_parse(id).is_ok() && attempt.parse::<u32>().is_ok())
}

/// Name of an uploaded mesh.
pub fn mesh_name(id: &str, format: MeshFormat) -> String {
    format!("{MESHES}/{id}.{}", format.extension())
}

/// Name of a result of a what-if run.
pub fn result_name(key: &str) -> String {
    format!("{RESULTS}/{key}.json")
}

/// Key of the result with a name.
pub fn result_key(name: &str) -> Option<&str> {
    name.strip_prefix(RESULTS)?.strip_prefix('/')?.strip_suffix(".json")
}

/// Name of a snapshot of the recording of a running job.
pub fn snapshot_name(id: JobId, number: u32) -> String {
    format!("{SNAPSHOTS}/{id}-{number}.mcap")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_are_known_by_their_names() {
        let id = JobId::now_v7();
        assert!(recording_names(id, 2).all(|name| is_recording(&name)));
        for name in
            [snapshot_name(id, 1), format!("recordings/{id}.mcap.partial"), "recordings/a.mcap".into()]
        {
            assert!(!is_recording(&name), "{name}");
        }
    }
}
