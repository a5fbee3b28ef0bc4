//! Nastran bulk data `.bdf`: nodes, solid elements, and shells (Nastran Quick Reference Guide, "Bulk Data Entries"). Parts are
//! called `part_<property>`; the nodes of shells form a node set of that name. Everything else is skipped and noted.

mod cards;

#[cfg(test)]
mod tests;

use super::assembly::{Assembly, NodeTag, Unused};
use super::cursor::{Numbers, fortran_position, place_of, shown};
use crate::mesh::{CellKind, Mesh, MeshError};
use cards::{Card, Cards};
use std::collections::{BTreeMap, HashSet};

/// Reads a bulk data file.
///
/// # Errors
/// As [`super::read_mesh`].
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let mut reader = Reader {
        bytes,
        assembly: Assembly::default(),
        elements: HashSet::new(),
        property_of_cell: Vec::new(),
        shells: BTreeMap::new(),
        skipped: Unused::default(),
    };
    let mut cards = Cards::new(bytes);
    for card in &mut cards {
        reader.card(&card)?;
    }
    if !cards.is_ended {
        reader.assembly.notes.push("the file has no ENDDATA: it may be cut short".into());
    }
    reader.into_mesh()
}

/// Solid elements: card, kind, and the name of the unsupported element with midside nodes.
const SOLIDS: [(&str, CellKind, &str); 3] = [
    ("CTETRA", CellKind::Tet4, "tetrahedron of 10 nodes without some of them"),
    ("CHEXA", CellKind::Hex8, "hexahedron of 20 nodes"),
    ("CPENTA", CellKind::Wedge6, "prism of 15 nodes"),
];

/// Elements with two dimensions, whose nodes follow number and property: name, number of nodes.
const SHELLS: [(&str, usize); 6] =
    [("CTRIA3", 3), ("CTRIAR", 3), ("CTRIA6", 6), ("CQUAD4", 4), ("CQUADR", 4), ("CQUAD8", 8)];

struct Reader<'a> {
    bytes: &'a [u8],
    assembly: Assembly,
    /// Numbers of all elements; only looked up.
    elements: HashSet<u64>,
    /// Property of each cell by its number.
    property_of_cell: Vec<u64>,
    /// Nodes of the shells of each property.
    shells: BTreeMap<u64, Vec<NodeTag>>,
    skipped: Unused,
}

impl Reader<'_> {
    /// An error in an entry.
    fn error(&self, card: &Card, message: impl Into<String>) -> MeshError {
        let place = place_of(self.bytes, card.offset, Numbers::Text);
        MeshError::Malformed { place, message: message.into() }
    }

    /// An error for an unsupported feature.
    fn refuse(&self, card: &Card, what: &str, remedy: &str) -> MeshError {
        let place = place_of(self.bytes, card.offset, Numbers::Text);
        MeshError::Unsupported { what: format!("{place}: {what}"), remedy: remedy.into() }
    }

    fn card(&mut self, card: &Card) -> Result<(), MeshError> {
        let solid = SOLIDS.iter().find(|(name, ..)| *name == card.name);
        let shell = SHELLS.iter().find(|(name, _)| *name == card.name);
        match (card.name.as_str(), solid, shell) {
            ("GRID", ..) => self.node(card),
            ("CPYRAM" | "CPYRA", ..) => {
                *self.assembly.unsupported.entry("pyramid".to_owned()).or_default() += 1;
                Ok(())
            }
            ("INCLUDE", ..) => Err(self.refuse(card, "INCLUDE", "put everything into one file")),
            ("GRDSET", ..) if !matches!(card.get(1), "" | "0") => Err(self.refuse(
                card,
                "nodes in a coordinate system by GRDSET",
                "write them in the basic system",
            )),
            (name, ..) if name.starts_with('=') => {
                Err(self.refuse(card, "replication of entries", "write every entry"))
            }
            (_, Some(&(_, kind, other)), _) => self.solid(card, kind, other),
            (_, _, Some(&(_, nodes))) => self.shell(card, nodes),
            _ => {
                self.skipped.add(&card.name, Some(card.offset));
                Ok(())
            }
        }
    }

    /// Parses the number of a node, an element or a property.
    fn number(&self, card: &Card, index: usize) -> Result<u64, MeshError> {
        let field = card.get(index);
        let found = || format!("expected a number, found {}", shown(field.as_bytes()));
        field.parse().map_err(|_| self.error(card, found()))
    }

    /// A node: number, coordinate system, coordinates, which default to zero.
    fn node(&mut self, card: &Card) -> Result<(), MeshError> {
        let tag = self.number(card, 0)?;
        if !matches!(card.get(1), "" | "0") {
            let what = format!("node {tag} in the coordinate system {}", shown(card.get(1).as_bytes()));
            return Err(self.refuse(card, &what, "write it in the basic system"));
        }
        let position = fortran_position((2..5).map(|i| card.get(i)), |message| self.error(card, message))?;
        if !self.assembly.add_node(tag, position) {
            return Err(self.error(card, format!("node {tag} is defined twice")));
        }
        Ok(())
    }

    /// Number and property of an element.
    fn element(&mut self, card: &Card) -> Result<u64, MeshError> {
        let element = self.number(card, 0)?;
        if !self.elements.insert(element) {
            return Err(self.error(card, format!("element {element} is defined twice")));
        }
        // The property defaults to the number of the element.
        if card.get(1).is_empty() { Ok(element) } else { self.number(card, 1) }
    }

    /// A solid element: its corners, and midside nodes that may follow.
    fn solid(&mut self, card: &Card, kind: CellKind, other: &str) -> Result<(), MeshError> {
        let property = self.element(card)?;
        let corners = kind.node_count();
        let midsides = (2 + corners..card.fields.len()).filter(|&i| !matches!(card.get(i), "" | "0")).count();
        let kind = match (kind, midsides) {
            (kind, 0) => kind,
            (CellKind::Tet4, 6) => CellKind::Tet10,
            _ => {
                *self.assembly.unsupported.entry(other.to_owned()).or_default() += 1;
                return Ok(());
            }
        };
        let nodes =
            (2..2 + kind.node_count()).map(|i| self.number(card, i)).collect::<Result<Vec<_>, _>>()?;
        self.assembly.add_cell(kind, &nodes, card.offset);
        self.property_of_cell.push(property);
        Ok(())
    }

    /// A shell, of which only the nodes count.
    fn shell(&mut self, card: &Card, nodes: usize) -> Result<(), MeshError> {
        let property = self.element(card)?;
        for i in (2..2 + nodes).filter(|&i| !card.get(i).is_empty()) {
            let tag = NodeTag { tag: self.number(card, i)?, offset: card.offset };
            self.shells.entry(property).or_default().push(tag);
        }
        Ok(())
    }

    /// The mesh of everything that was read; parts are in the order of their numbers.
    fn into_mesh(mut self) -> Result<Mesh, MeshError> {
        let name = |property: u64| format!("part_{property}");
        let mut properties = self.property_of_cell.clone();
        properties.sort_unstable();
        properties.dedup();
        let index: BTreeMap<u64, u32> =
            properties.into_iter().map(|property| (property, self.assembly.part(&name(property)))).collect();
        self.assembly.part_of = self.property_of_cell.iter().map(|property| index[property]).collect();
        self.assembly.node_sets = std::mem::take(&mut self.shells)
            .into_iter()
            .map(|(property, tags)| (name(property), tags))
            .collect();
        let place = |offset| place_of(self.bytes, offset, Numbers::Text);
        self.assembly.note_unused(("entries", ""), &self.skipped, place);
        self.assembly.into_mesh(place)
    }
}
