//! Which material the parts of a FEBio file have.

use roxmltree::Node;
use std::collections::BTreeMap;

/// Type of the material of a rigid body.
pub(crate) const RIGID: &str = "rigid body";

/// Names or numbers of the materials of the parts of volumes, by the names of the parts.
pub(crate) fn materials_of_parts<'s>(root: Node<'s, 's>, mesh: Node<'s, 's>) -> BTreeMap<&'s str, &'s str> {
    let sections = mesh.children().filter(|node| node.has_tag_name("Elements"));
    let domains = root.children().filter(|node| node.has_tag_name("MeshDomains"));
    let solids =
        domains.flat_map(|section| section.children()).filter(|node| node.has_tag_name("SolidDomain"));
    let assigned = |node: Node<'s, 's>| Some((node.attribute("name")?.trim(), node.attribute("mat")?));
    sections.chain(solids).filter_map(assigned).collect()
}

/// The materials by their names and their numbers.
pub(crate) fn materials<'s>(root: Node<'s, 's>) -> BTreeMap<&'s str, Node<'s, 's>> {
    let sections = root.children().filter(|node| node.has_tag_name("Material"));
    let mut materials = BTreeMap::new();
    for node in sections.flat_map(|section| section.children()).filter(Node::is_element) {
        for named in ["name", "id"].into_iter().filter_map(|key| node.attribute(key)) {
            materials.entry(named).or_insert(node);
        }
    }
    materials
}

/// The parts that are rigid bodies, with the byte offsets of their materials: one material is one body.
pub(super) fn rigid_parts<'s>(root: Node<'s, 's>, mesh: Node<'s, 's>) -> BTreeMap<&'s str, usize> {
    let materials = materials(root);
    let is_rigid = |material: &&Node| material.attribute("type") == Some(RIGID);
    let rigid = |(part, named): (&'s str, &'s str)| {
        Some((part, materials.get(named).filter(is_rigid)?.range().start))
    };
    materials_of_parts(root, mesh).into_iter().filter_map(rigid).collect()
}
