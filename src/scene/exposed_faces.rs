//! The faces of a body that something may hit: its skin, and not the cuts through it where it is held.

use super::document::{Role, SceneDocument};
use crate::mesh::Mesh;
use crate::mesh::surface::faces_within;

/// Those of the outer `faces` of a body (a number of the document, with its mesh) that are its skin: the faces within the node set
/// that a tissue is measured on, or else all that are not wholly held by one entry of `fixed` or several.
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
