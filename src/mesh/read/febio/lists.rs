//! Lists of elements and of their numbers in FEBio files.

use crate::mesh::read::cursor::shown;
use crate::mesh::read::xml::Xml;
use crate::mesh::{CellKind, MeshError};
use roxmltree::Node;

/// What the elements of a list are.
pub(super) enum Kind {
    Cell(CellKind),
    /// Shells and lines, of which only the nodes count.
    Boundary,
    /// Other volumes, by their name.
    Other(String),
}

impl Kind {
    pub(super) fn of(name: &str) -> Self {
        let name = name.to_ascii_lowercase();
        match name.as_str() {
            "hex8" => Self::Cell(CellKind::Hex8),
            "tet4" => Self::Cell(CellKind::Tet4),
            "tet10" => Self::Cell(CellKind::Tet10),
            "penta6" => Self::Cell(CellKind::Wedge6),
            _ if ["tri", "quad", "q4", "line", "truss", "beam", "point"]
                .iter()
                .any(|p| name.starts_with(p)) =>
            {
                Self::Boundary
            }
            _ => Self::Other(name),
        }
    }
}

/// Numbers separated by commas.
///
/// # Errors
/// `Malformed` for anything else.
pub(super) fn numbers(xml: &Xml, node: Node) -> Result<Vec<u64>, MeshError> {
    let text = node.text().unwrap_or_default().trim();
    if text.is_empty() {
        return Ok(Vec::new());
    }
    let number = |field: &str| {
        let field = field.trim();
        let found = || format!("expected a number, found {}", shown(field.as_bytes()));
        field.parse().map_err(|_| xml.error(node, found()))
    };
    text.split(',').map(number).collect()
}

/// The numbers of a set: a list since version 4, an element with its number for each before.
///
/// # Errors
/// `Malformed` for anything else.
pub(super) fn members(xml: &Xml, set: Node) -> Result<Vec<u64>, MeshError> {
    let mut listed = Vec::new();
    for child in set.children().filter(Node::is_element) {
        listed.push(xml.number(child, "id")?);
    }
    if listed.is_empty() { numbers(xml, set) } else { Ok(listed) }
}
