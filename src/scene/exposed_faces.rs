//! The boundary faces of a body that can be hit, without the cut sections where it is held.

use super::document::{BodyDocument, Generator, MeshDocument, Role, SceneDocument};
use crate::mesh::Mesh;
use crate::mesh::surface::faces_within;

/// Node sets of a generated limb on its cut sections.
pub const CUTS: [&str; 2] = ["end_low", "end_high"];

/// Node set of generated layers at their skin.
pub(super) const TOP: &str = "z_max";

/// Node sets of generated layers below their skin: there the piece is cut out of a body.
pub(super) const CUT_SIDES: [&str; 5] = ["x_min", "x_max", "y_min", "y_max", "z_min"];

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
    let set_of = |name: &str| nodes_of(mesh, name);
    if let (Role::Tissue, Some(name)) = (body.role, &document.measures.skin_set) {
        return faces_within(faces, set_of(name));
    }
    // Held faces may have nodes of several sets; each cut is flat.
    let held = held_nodes(body, mesh);
    let cuts = if is_top_held(mesh, &held) { &[][..] } else { cuts_of(body) };
    let cuts = cuts.iter().map(|cut| marked(mesh, set_of(cut)));
    let hidden: Vec<Vec<bool>> = std::iter::once(held).chain(cuts).collect();
    let is_in = |face: &[u32; 4], set: &[bool]| face.iter().all(|node| set[*node as usize]);
    faces.iter().filter(|face| !hidden.iter().any(|set| is_in(face, set))).copied().collect()
}

/// Whether depths in a body (with its mesh) are counted from the top of its generated layers, as no skin set says otherwise.
pub fn counts_from_top(document: &SceneDocument, body: &BodyDocument, mesh: &Mesh) -> bool {
    let has_skin_set = document.measures.skin_set.is_some();
    let is_layered = matches!(body.mesh, Some(MeshDocument::Generator(Generator::LayeredBlock(_))));
    let is_free = || !is_top_held(mesh, &held_nodes(body, mesh));
    body.role == Role::Tissue && !has_skin_set && is_layered && is_free()
}

/// Nodes of a set; none where there is no such set.
fn nodes_of<'a>(mesh: &'a Mesh, name: &str) -> &'a [u32] {
    mesh.node_sets.get(name).map_or(&[][..], Vec::as_slice)
}

/// Which nodes of a mesh are among some.
fn marked<'a>(mesh: &Mesh, nodes: impl IntoIterator<Item = &'a u32>) -> Vec<bool> {
    let mut is_marked = vec![false; mesh.nodes.len()];
    nodes.into_iter().for_each(|node| is_marked[*node as usize] = true);
    is_marked
}

/// Which nodes a body is held at.
fn held_nodes(body: &BodyDocument, mesh: &Mesh) -> Vec<bool> {
    marked(mesh, body.fixed.iter().flat_map(|fixed| nodes_of(mesh, &fixed.set)))
}

/// Whether layers are held at their top, so that they are hit elsewhere.
fn is_top_held(mesh: &Mesh, held: &[bool]) -> bool {
    let top = nodes_of(mesh, TOP);
    !top.is_empty() && top.iter().all(|node| held[*node as usize])
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
