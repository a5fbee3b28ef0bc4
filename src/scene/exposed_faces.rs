//! The boundary faces of a body that can be hit, without the cut sections where it is held.

use super::document::{BodyDocument, Generator, MeshDocument, Role, SceneDocument};
use crate::mesh::Mesh;
use crate::mesh::surface::faces_within;

/// Node sets of a generated limb on its cut sections.
pub const CUTS: [&str; 2] = ["end_low", "end_high"];

/// Node sets of generated layers below their skin, `z_max`: there the piece is cut out of a body.
const CUT_SIDES: [&str; 5] = ["x_min", "x_max", "y_min", "y_max", "z_min"];

/// The exposed part of the boundary `faces` of a body (index of the document, with its mesh): the faces within the skin set
/// of the measures for the tissue, otherwise all faces with a node that no entry of `fixed` holds, and that are on no cut section of
/// generated tissue.
pub fn exposed_faces(
    document: &SceneDocument,
    body: usize,
    mesh: &Mesh,
    faces: &[[u32; 4]],
) -> Vec<[u32; 4]> {
    let body = &document.bodies[body];
    let set_of = |name: &str| mesh.node_sets.get(name).map_or(&[][..], Vec::as_slice);
    if let (Role::Tissue, Some(name)) = (body.role, &document.measures.skin_set) {
        return faces_within(faces, set_of(name));
    }
    let marked = |nodes: &mut dyn Iterator<Item = &u32>| {
        let mut is_marked = vec![false; mesh.nodes.len()];
        nodes.for_each(|node| is_marked[*node as usize] = true);
        is_marked
    };
    // Held faces may have nodes of several sets; each cut is flat.
    let held = marked(&mut body.fixed.iter().flat_map(|fixed| set_of(&fixed.set)));
    // Layers that are held at their top are hit elsewhere.
    let top = set_of("z_max");
    let is_top_held = !top.is_empty() && top.iter().all(|node| held[*node as usize]);
    let cuts = if is_top_held { &[][..] } else { cuts_of(body) };
    let cuts = cuts.iter().map(|cut| marked(&mut set_of(cut).iter()));
    let hidden: Vec<Vec<bool>> = std::iter::once(held).chain(cuts).collect();
    let is_in = |face: &[u32; 4], set: &[bool]| face.iter().all(|node| set[*node as usize]);
    faces.iter().filter(|face| !hidden.iter().any(|set| is_in(face, set))).copied().collect()
}

/// Names of the node sets on the cut sections of a body; none unless it is generated tissue.
fn cuts_of(body: &BodyDocument) -> &'static [&'static str] {
    match body.mesh {
        Some(MeshDocument::Generator(Generator::LimbSegment(_))) => &CUTS,
        Some(MeshDocument::Generator(Generator::LayeredBlock(_))) => &CUT_SIDES,
        _ => &[],
    }
}

/// Whether a body is a segment of a limb, which ends in cut sections.
pub fn is_generated_limb(body: &BodyDocument) -> bool {
    matches!(body.mesh, Some(MeshDocument::Generator(Generator::LimbSegment(_))))
}
