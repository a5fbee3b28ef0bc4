//! Names of the blobs of the service.

use super::jobs::JobId;
use crate::mesh::read::MeshFormat;

/// Recordings of jobs that have ended.
pub const RECORDINGS: &str = "recordings";
/// Uploaded meshes, named by digest.
pub const MESHES: &str = "meshes";
/// Snapshots of the recordings of running jobs; none outlives the process that took it.
pub const SNAPSHOTS: &str = "snapshots";
/// Results of what-if runs, by content.
pub const RESULTS: &str = "results";

/// Name of the recording of a job that has ended.
pub fn recording_name(id: JobId) -> String {
    format!("{RECORDINGS}/{id}.mcap")
}

/// Whether a name is that of a recording.
pub fn is_recording(name: &str) -> bool {
    let id = name.strip_prefix(RECORDINGS).and_then(|name| name.strip_prefix('/')?.strip_suffix(".mcap"));
    id.is_some_and(|id| JobId::try_parse(id).is_ok())
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
        assert!(is_recording(&recording_name(id)));
        for name in
            [snapshot_name(id, 1), format!("recordings/{id}.mcap.partial"), "recordings/a.mcap".into()]
        {
            assert!(!is_recording(&name), "{name}");
        }
    }
}
