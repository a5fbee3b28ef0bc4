//! The boundary faces of a body that can be hit, without the cut sections where it is held.

use super::document::{Role, SceneDocument};
use crate::mesh::Mesh;
use crate::mesh::surface::faces_within;

/// The exposed part of the boundary `faces` of a body (index of the document, with its mesh): the faces within the skin set
/// of the measures for the tissue, otherwise all faces with a node that no entry of `fixed` holds.
pub fn exposed_faces(
    document: &SceneDocument,
    body: usize,
    mesh: &Mesh,
    faces: &[[u32; 4]],
) -> Vec<[u32; 4]> {
    let body = &document.bodies[body];
    let set_of = |name: &String| mesh.node_sets.get(name).map_or(&[][..], Vec::as_slice);
    if let (Role::Tissue, Some(name)) = (body.role, &document.measures.skin_set) {
        return faces_within(faces, set_of(name));
    }
    let mut is_held = vec![false; mesh.nodes.len()];
    for node in body.fixed.iter().flat_map(|fixed| set_of(&fixed.set)) {
        is_held[*node as usize] = true;
    }
    faces.iter().filter(|face| !face.iter().all(|node| is_held[*node as usize])).copied().collect()
}
