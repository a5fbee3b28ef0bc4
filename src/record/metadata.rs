//! What a recording says of its run: where it comes from, how it was computed, how it ended.

use super::RecordError;
use super::writer::TimeScale;
use crate::blobs::hexadecimal;
use crate::measure::summary::NOTICE;
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::scene::Scene;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// Name of the metadata record about the run.
pub const RUN_METADATA: &str = "contuse.run";
/// Name of the metadata record about its end.
pub const ENDING_METADATA: &str = "contuse.ending";

/// What a recording says of its origin.
#[derive(Clone, Debug, Default)]
pub struct RecordingInfo {
    /// The scene document as it came, for the attachment.
    pub document_json: Vec<u8>,
    /// SHA-256 of the scene and its meshes.
    pub scene_hash: String,
    /// SHA-256 of the mesh of each body, by name.
    pub mesh_hashes: Vec<(String, String)>,
}

impl RecordingInfo {
    /// Of a run of a scene, whose document came as `document_json`.
    pub fn of(scene: &Scene, document_json: &[u8]) -> Self {
        let bodies = scene.document.bodies.iter().zip(&scene.bodies).filter(|(_, body)| body.rigid.is_none());
        Self {
            document_json: document_json.to_vec(),
            scene_hash: scene.content_hash.clone(),
            mesh_hashes: bodies
                .map(|(document, body)| (document.name.clone(), mesh_hash(&body.mesh)))
                .collect(),
        }
    }
}

/// SHA-256 of a mesh as it was placed: node positions, elements, parts.
fn mesh_hash(mesh: &Mesh) -> String {
    let mut hash = Sha256::new();
    mesh.nodes.iter().flat_map(|x| x.iter()).for_each(|x| hash.update(x.to_le_bytes()));
    // Hexahedra alone are known by their nodes, as they were when there was nothing else.
    if mesh.cells.hexes().is_none() {
        mesh.cells.iter().for_each(|cell| hash.update([cell.kind.table().vtk.number]));
    }
    mesh.cells.connectivity().iter().for_each(|node| hash.update(node.to_le_bytes()));
    mesh.part_of.iter().for_each(|part| hash.update(part.to_le_bytes()));
    hexadecimal(&hash.finalize())
}

/// The metadata record about the run; colours go from 0 to `top` [Pa].
pub(super) fn run_metadata(
    info: &RecordingInfo,
    plan: &Plan,
    scale: TimeScale,
    top: f64,
) -> Result<BTreeMap<String, String>, RecordError> {
    let mut metadata: BTreeMap<String, String> = [
        ("engine", "contuse".to_owned()),
        ("engine_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("engine_commit", option_env!("CONTUSE_COMMIT").unwrap_or("unknown").to_owned()),
        ("scene", plan.name.clone()),
        ("scene_hash", info.scene_hash.clone()),
        ("units", "SI: m, kg, s, N, Pa, J".to_owned()),
        ("time_factor", scale.factor.to_string()),
        ("log_time", "simulated time × time_factor [ns], strictly increasing".to_owned()),
        ("publish_time", "simulated time [ns]".to_owned()),
        ("end_time_s", plan.end_time.to_string()),
        ("every_steps", plan.every_steps.to_string()),
        ("field_times_s", serde_json::to_string(&plan.field_times)?),
        ("fields", serde_json::to_string(&plan.fields)?),
        ("colour", "von Mises stress, viridis".to_owned()),
        ("colour_range_pa", serde_json::to_string(&[0.0, top])?),
        ("plan_report", serde_json::to_string(&plan.report)?),
        ("notice", NOTICE.to_owned()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into();
    let hashes = info.mesh_hashes.iter().map(|(body, hash)| (format!("mesh_hash/{body}"), hash.clone()));
    metadata.extend(hashes);
    Ok(metadata)
}

/// The metadata record about the end of a run.
pub(super) fn ending_metadata(
    complete: bool,
    ending: &str,
    why: &str,
    time: f64,
    step: u64,
) -> BTreeMap<String, String> {
    [
        ("complete", complete.to_string()),
        ("ending", ending.to_owned()),
        ("why", why.to_owned()),
        ("time_s", time.to_string()),
        ("step", step.to_string()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into()
}
