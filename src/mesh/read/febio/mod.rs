//! The mesh of FEBio files `.feb`, versions 2.5 to 4.0 (FEBio User Manual, "Mesh Section"). Materials, loads and all other
//! sections are omitted here, with a note of their lines; a first scene of the file takes them (`scene/febio/`).
//!
//! Parts are the `<Elements>` of volumes; `<NodeSet>`, `<Surface>`, `<ElementSet>`, and `<Elements>` of shells and lines become
//! node sets.

mod axes;
mod lists;
mod materials;
#[cfg(test)]
mod tests;

pub(crate) use axes::is_axes;
pub(crate) use materials::{RIGID, materials, materials_of_parts};

use self::lists::{Kind, members, numbers};
use super::assembly::{Assembly, NodeTag, free_name};
use super::cursor::shown;
use super::entries::{most_entries, within_limit};
use super::xml::Xml;
use crate::mechanics::tensor::Vec3;
use crate::mesh::{Mesh, MeshError};
use roxmltree::Node;
use std::collections::{BTreeMap, HashMap};

/// Beginning of the note on sections that are not part of the mesh.
pub(crate) const NOT_READ: &str = "only the mesh is read";

/// The names of node sets, by what they come from and their names in the file.
pub(crate) type SetNames = BTreeMap<(Origin, String), String>;

/// What a node set comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Origin {
    /// `<Elements>` of shells and lines, or `<ElementSet>`.
    Elements,
    /// `<NodeSet>`.
    Nodes,
    /// `<Surface>`.
    Surface,
    /// `<Edge>`.
    Edge,
    /// All nodes of a rigid body, by the name of its first `<Elements>`.
    RigidBody,
}

/// What is read of a file.
pub(crate) struct Found {
    /// The mesh. It has material axes where the file has some; x, y, z in elements without.
    pub(crate) mesh: Mesh,
    /// The names of its node sets.
    pub(crate) sets: SetNames,
    /// Whether each element has axes in the file; empty where none has.
    pub(crate) has_axes: Vec<bool>,
}

impl Origin {
    /// In the name of a set whose own name is taken.
    fn word(self) -> &'static str {
        match self {
            Self::Elements => "elements",
            Self::Nodes => "nodes",
            Self::Surface => "surface",
            Self::Edge => "edge",
            Self::RigidBody => "rigid_body",
        }
    }
}

/// Reads a `.feb` file.
///
/// # Errors
/// As [`super::read_mesh`].
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let text = String::from_utf8_lossy(bytes);
    Ok(read_xml(&Xml::new(&text)?)?.mesh)
}

/// The mesh of a parsed file, the names of its node sets, and which elements have material axes.
///
/// # Errors
/// As [`super::read_mesh`].
pub(crate) fn read_xml(xml: &Xml) -> Result<Found, MeshError> {
    let mesh = mesh_section(xml)?;
    let mut reader = Reader {
        xml,
        assembly: Assembly::default(),
        set_names: SetNames::new(),
        elements: HashMap::new(),
        rigid: materials::rigid_parts(xml.root(), mesh),
        rigid_nodes: BTreeMap::new(),
        entries: 0,
        most_entries: most_entries(xml.length()),
    };
    let sections = || mesh.children().filter(Node::is_element);
    for section in sections() {
        match section.tag_name().name() {
            "Nodes" => reader.nodes(section)?,
            "Elements" => reader.elements(section)?,
            _ => {}
        }
    }
    // Sets may come before the elements that they name.
    let mut unused = Vec::new();
    for section in sections() {
        match section.tag_name().name() {
            "Nodes" | "Elements" => {}
            "NodeSet" => reader.node_set(section)?,
            "ElementSet" => reader.element_set(section)?,
            "Surface" => reader.surface(section, Origin::Surface)?,
            "Edge" => reader.surface(section, Origin::Edge)?,
            _ => unused.push(section),
        }
    }
    // Sets of the file keep their names.
    for (name, nodes) in std::mem::take(&mut reader.rigid_nodes).into_values() {
        reader.add_set(&name, Origin::RigidBody, nodes);
    }
    let other = xml.root().children().filter(|child| child.is_element() && *child != mesh);
    let is_used = |child: &Node| {
        child.has_tag_name("Module")
            || child.has_tag_name("MeshData") && child.children().filter(Node::is_element).all(is_axes)
    };
    unused.extend(other.filter(|child| !is_used(child)));
    reader.note_unused(unused);
    let read = reader.assembly.into_mesh(|offset| xml.place(offset))?;
    let (axes, has_axes) = axes::axes(xml, mesh)?;
    Ok(Found { mesh: Mesh { axes, ..read }, sets: reader.set_names, has_axes })
}

/// The element with the mesh.
///
/// # Errors
/// For another version, or a section in another file.
pub(crate) fn mesh_section<'s>(xml: &'s Xml) -> Result<Node<'s, 's>, MeshError> {
    let root = xml.root();
    if !root.has_tag_name("febio_spec") {
        return Err(xml.error(root, format!("expected <febio_spec>, found <{}>", root.tag_name().name())));
    }
    let refused = |node: Node, what: String, remedy: &str| {
        let what = format!("{}: {what}", xml.place(node.range().start));
        Err(MeshError::Unsupported { what, remedy: remedy.to_owned() })
    };
    let version = xml.attribute(root, "version")?;
    let mesh = match version {
        "2.5" => xml.child(root, "Geometry")?,
        "3.0" | "4.0" => xml.child(root, "Mesh")?,
        _ => {
            let what = format!("version {} of FEBio files", shown(version.as_bytes()));
            return refused(root, what, "open it in FEBio Studio, and save it as version 4.0");
        }
    };
    let is_elsewhere = |node: &Node| node.has_tag_name("Include") || node.has_attribute("from");
    let is_in_mesh = |node: &Node| node.has_tag_name("Include");
    if let Some(node) = root.children().find(is_elsewhere).or_else(|| mesh.children().find(is_in_mesh)) {
        let what = format!("<{}> of another file", node.tag_name().name());
        return refused(node, what, "put everything into one file");
    }
    Ok(mesh)
}

/// Largest number of sections named in the note on those that are not used.
const MOST_LISTED: usize = 50;

struct Reader<'a> {
    xml: &'a Xml<'a>,
    assembly: Assembly,
    set_names: SetNames,
    /// Nodes of each element by its number: those of a cell, or of a shell or line.
    elements: HashMap<u64, Vec<u64>>,
    /// Parts of rigid bodies, with the byte offsets of their materials.
    rigid: BTreeMap<&'a str, usize>,
    /// The name of the first part of each rigid body, and its nodes, by the same.
    rigid_nodes: BTreeMap<usize, (String, Vec<NodeTag>)>,
    /// Entries of all sets, and how many are allowed.
    entries: u64,
    most_entries: u64,
}

impl<'a> Reader<'a> {
    fn nodes(&mut self, section: Node<'a, 'a>) -> Result<(), MeshError> {
        for node in section.children().filter(Node::is_element) {
            let tag: u64 = self.xml.number(node, "id")?;
            let mut position = Vec3::zeros();
            let mut fields = node.text().unwrap_or_default().split(',');
            for x in &mut position {
                let field = fields.next().unwrap_or_default().trim();
                let value = field.parse::<f64>().ok().filter(|value| value.is_finite());
                let found = || format!("expected a finite coordinate, found {}", shown(field.as_bytes()));
                *x = value.ok_or_else(|| self.xml.error(node, found()))?;
            }
            if fields.next().is_some() {
                return Err(self.xml.error(node, format!("node {tag} has more than three coordinates")));
            }
            if !self.assembly.add_node(tag, position) {
                return Err(self.xml.error(node, format!("node {tag} is defined twice")));
            }
        }
        Ok(())
    }

    fn elements(&mut self, section: Node<'a, 'a>) -> Result<(), MeshError> {
        let kind = Kind::of(self.xml.attribute(section, "type")?);
        let name =
            section.attribute("name").map(str::trim).filter(|name| !name.is_empty()).unwrap_or("unnamed");
        let rigid_body = self.rigid.get(name).copied().filter(|_| matches!(kind, Kind::Cell(_)));
        let mut boundary = Vec::new();
        for element in section.children().filter(Node::is_element) {
            let offset = element.range().start;
            let tag: u64 = self.xml.number(element, "id")?;
            let nodes = numbers(self.xml, element)?;
            match &kind {
                Kind::Cell(kind) if nodes.len() == kind.node_count() => {
                    let part = self.assembly.part(name);
                    self.assembly.add_cell(*kind, &nodes, offset);
                    self.assembly.part_of.push(part);
                    if let Some(material) = rigid_body {
                        let (_, own) =
                            self.rigid_nodes.entry(material).or_insert((name.to_owned(), Vec::new()));
                        own.extend(nodes.iter().map(|&tag| NodeTag { tag, offset }));
                    }
                }
                Kind::Cell(kind) => {
                    let message = format!("a {} with {} nodes", kind.table().title, nodes.len());
                    return Err(self.xml.error(element, message));
                }
                Kind::Boundary => boundary.extend(nodes.iter().map(|&tag| NodeTag { tag, offset })),
                Kind::Other(name) => *self.assembly.unsupported.entry(name.clone()).or_default() += 1,
            }
            if self.elements.insert(tag, nodes).is_some() {
                return Err(self.xml.error(element, format!("element {tag} is defined twice")));
            }
        }
        if matches!(kind, Kind::Boundary) {
            self.add_set(name, Origin::Elements, boundary);
        }
        Ok(())
    }

    fn add_set(&mut self, own: &str, origin: Origin, tags: Vec<NodeTag>) {
        let name = free_name(&self.assembly.node_sets, own, origin.word());
        self.set_names.insert((origin, own.to_owned()), name.clone());
        self.assembly.node_sets.entry(name).or_default().extend(tags);
    }

    fn node_set(&mut self, set: Node<'a, 'a>) -> Result<(), MeshError> {
        let name = self.xml.attribute(set, "name")?;
        let offset = set.range().start;
        let tags = members(self.xml, set)?.into_iter().map(|tag| NodeTag { tag, offset }).collect();
        self.add_set(name, Origin::Nodes, tags);
        Ok(())
    }

    fn element_set(&mut self, set: Node<'a, 'a>) -> Result<(), MeshError> {
        let name = self.xml.attribute(set, "name")?;
        let offset = set.range().start;
        let mut tags = Vec::new();
        for element in members(self.xml, set)? {
            let Some(nodes) = self.elements.get(&element) else {
                return Err(self.xml.error(set, format!("there is no element {element}")));
            };
            self.entries += nodes.len() as u64;
            within_limit(self.entries, self.most_entries)?;
            tags.extend(nodes.iter().map(|&tag| NodeTag { tag, offset }));
        }
        self.add_set(name, Origin::Elements, tags);
        Ok(())
    }

    /// A list of facets, each with its nodes.
    fn surface(&mut self, surface: Node<'a, 'a>, origin: Origin) -> Result<(), MeshError> {
        let name = self.xml.attribute(surface, "name")?;
        let mut tags = Vec::new();
        for facet in surface.children().filter(Node::is_element) {
            let offset = facet.range().start;
            tags.extend(numbers(self.xml, facet)?.into_iter().map(|tag| NodeTag { tag, offset }));
        }
        self.add_set(name, origin, tags);
        Ok(())
    }

    /// Notes the sections that are not used, with the line of the first of each name.
    fn note_unused(&mut self, sections: Vec<Node>) {
        let mut lines: Vec<(String, String)> = Vec::new();
        for section in sections {
            let name = section.tag_name().name();
            if lines.len() < MOST_LISTED && lines.iter().all(|(known, _)| known != name) {
                lines.push((name.to_owned(), self.xml.place(section.range().start).to_string()));
            }
        }
        if !lines.is_empty() {
            let list: Vec<String> =
                lines.into_iter().map(|(name, line)| format!("{name} ({line})")).collect();
            self.assembly.notes.push(format!("{NOT_READ}; not used: {}", list.join(", ")));
        }
    }
}
