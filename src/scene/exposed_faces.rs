//! The boundary faces of a body that can be hit, without the cut sections where it is held.

use super::document::{BodyDocument, Generator, MeshDocument, Role, SceneDocument};
use crate::mesh::Mesh;
use crate::mesh::surface::faces_within;

/// Node sets of a generated limb on its cut sections.
pub const CUTS: [&str; 2] = ["end_low", "end_high"];

/// The exposed part of the boundary `faces` of a body (index of the document, with its mesh): the faces within the skin set
/// of the measures for the tissue, otherwise all faces with a node that no entry of `fixed` holds, and that is on no cut section of a
/// generated limb.
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
    let cuts = CUTS.iter().filter(|_| is_generated_limb(body)).filter_map(|cut| mesh.node_sets.get(*cut));
    let held = body.fixed.iter().flat_map(|fixed| set_of(&fixed.set));
    held.chain(cuts.flatten()).for_each(|node| is_held[*node as usize] = true);
    faces.iter().filter(|face| !face.iter().all(|node| is_held[*node as usize])).copied().collect()
}

/// Whether a body is a segment of a limb, which ends in cut sections.
pub fn is_generated_limb(body: &BodyDocument) -> bool {
    matches!(body.mesh, Some(MeshDocument::Generator(Generator::LimbSegment(_))))
}
