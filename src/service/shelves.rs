//! What the blobs of the service are called.

use super::jobs::JobId;
use crate::mesh::read::MeshFormat;

/// Recordings of jobs that have ended.
pub const RECORDINGS: &str = "recordings";
/// Uploaded meshes.
pub const MESHES: &str = "meshes";
/// Looks at recordings of jobs that run; none outlives the process that took it.
pub const SNAPSHOTS: &str = "snapshots";
/// What runs of what-if questions said, by content.
pub const RESULTS: &str = "results";

/// The name of the recording of a job that has ended.
pub fn recording_name(id: JobId) -> String {
    format!("{RECORDINGS}/{id}.mcap")
}

/// Whether a blob is called like a recording.
pub fn is_recording(name: &str) -> bool {
    let id = name.strip_prefix(RECORDINGS).and_then(|name| name.strip_prefix('/')?.strip_suffix(".mcap"));
    id.is_some_and(|id| JobId::try_parse(id).is_ok())
}

/// The name of an uploaded mesh.
pub fn mesh_name(id: &str, format: MeshFormat) -> String {
    format!("{MESHES}/{id}.{}", format.extension())
}

/// The name of a snapshot of the recording of a job that runs.
pub fn snapshot_name(id: JobId, number: u32) -> String {
    format!("{SNAPSHOTS}/{id}-{number}.mcap")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_are_told_by_their_names() {
        let id = JobId::now_v7();
        assert!(is_recording(&recording_name(id)));
        for name in
            [snapshot_name(id, 1), format!("recordings/{id}.mcap.partial"), "recordings/a.mcap".into()]
        {
            assert!(!is_recording(&name), "{name}");
        }
    }
}
