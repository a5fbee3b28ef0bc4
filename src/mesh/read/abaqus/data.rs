//! Data lines: nodes, elements, members of sets, faces of surfaces.

use super::sets::Sets;
use super::{Block, CardSet, Reader};
use crate::mesh::read::cursor::{fortran_position, shown};
use crate::mesh::read::entries::Numbers;
use crate::mesh::{CellKind, MeshError};
use std::borrow::Cow;

impl Reader<'_> {
    /// Reads one data line.
    pub(super) fn data(
        &mut self,
        fields: &[Cow<str>],
        continues: bool,
        offset: usize,
    ) -> Result<(), MeshError> {
        // The block is moved out while its line is read, so that the rest of the reader can change.
        let mut block = std::mem::replace(&mut self.block, Block::Skipped);
        match &mut block {
            Block::Skipped => {}
            Block::Nodes { set } => self.node(fields, set.as_deref(), offset)?,
            Block::Cells { kind, set, pending, start } => {
                if pending.is_empty() {
                    *start = offset;
                }
                for field in fields {
                    pending.push(self.number(field, offset)?);
                }
                if pending.len() > kind.node_count() {
                    self.cell(*kind, pending, set.as_ref(), *start)?;
                    pending.clear();
                }
            }
            Block::Others { set, kind, volume, fresh } => {
                let skip = if *fresh {
                    self.other_element(fields, set.as_deref(), kind, *volume, offset)?
                } else {
                    0
                };
                if let (Some(set), false) = (set, *volume) {
                    for field in &fields[skip..] {
                        let node = self.number(field, offset)?;
                        self.facets.add(set, Numbers::one(node, offset))?;
                    }
                }
                *fresh = !continues;
            }
            Block::Set { name, of_nodes, generate: true } => {
                let range = self.range(fields, offset)?;
                self.sets(*of_nodes).add(name, range)?;
            }
            Block::Set { name, of_nodes, generate: false } => {
                self.set_members(fields, name, *of_nodes, offset)?;
            }
            Block::Surface { name } => self.surface_face(fields, name, offset)?,
            Block::Instance => {
                let remedy = "write the nodes at their final positions";
                return Err(self.refuse(offset, "a translated or rotated *INSTANCE", remedy));
            }
        }
        self.block = block;
        Ok(())
    }

    fn sets(&mut self, of_nodes: bool) -> &mut Sets {
        if of_nodes { &mut self.node_sets } else { &mut self.element_sets }
    }

    /// Parses a node or element number.
    fn number(&self, field: &str, offset: usize) -> Result<u64, MeshError> {
        field.parse().map_err(|_| {
            self.error(
                offset,
                format!("expected the number of a node or an element, found {}", shown(field.as_bytes())),
            )
        })
    }

    /// A node: number and coordinates, which default to zero.
    fn node(&mut self, fields: &[Cow<str>], set: Option<&str>, offset: usize) -> Result<(), MeshError> {
        let tag = self.number(&fields[0], offset)?;
        let coordinates = fields[1..].iter().map(AsRef::as_ref);
        let position = fortran_position(coordinates, |message| self.error(offset, message))?;
        if !self.assembly.add_node(tag, position) {
            return Err(self.error(offset, format!("node {tag} is defined twice")));
        }
        match set {
            Some(set) => self.node_sets.add(set, Numbers::one(tag, offset)),
            None => Ok(()),
        }
    }

    /// A cell: number and nodes.
    fn cell(
        &mut self,
        kind: CellKind,
        numbers: &[u64],
        set: Option<&CardSet>,
        offset: usize,
    ) -> Result<(), MeshError> {
        let nodes = &numbers[1..];
        if nodes.len() != kind.node_count() {
            let message = format!("an element of {} nodes with {}", kind.node_count(), nodes.len());
            return Err(self.error(offset, message));
        }
        let index = self.assembly.cells().len() as u32;
        self.assembly.add_cell(kind, nodes, offset);
        if let Some(set) = set {
            self.element_sets.add(&set.name, Numbers::one(numbers[0], offset))?;
        }
        self.card_set_of.push(set.map(|set| set.index));
        self.add_element(numbers[0], Some(index), offset)
    }

    /// First line of an element of unsupported type. Returns the number of fields of its number.
    fn other_element(
        &mut self,
        fields: &[Cow<str>],
        set: Option<&str>,
        kind: &str,
        volume: bool,
        offset: usize,
    ) -> Result<usize, MeshError> {
        let number = self.number(&fields[0], offset)?;
        self.add_element(number, None, offset)?;
        if volume {
            *self.assembly.unsupported.entry(kind.to_owned()).or_default() += 1;
        }
        if let Some(set) = set {
            self.element_sets.add(set, Numbers::one(number, offset))?;
        }
        Ok(1)
    }

    fn add_element(&mut self, number: u64, cell: Option<u32>, offset: usize) -> Result<(), MeshError> {
        if self.elements.insert(number, cell).is_some() {
            return Err(self.error(offset, format!("element {number} is defined twice")));
        }
        Ok(())
    }

    /// A generated set: `first, last, step`.
    fn range(&self, fields: &[Cow<str>], offset: usize) -> Result<Numbers, MeshError> {
        let numbers = fields.iter().map(|field| self.number(field, offset)).collect::<Result<Vec<_>, _>>()?;
        let range = match numbers[..] {
            [first, last] => Numbers { first, last, step: 1, offset },
            [first, last, step] => Numbers { first, last, step, offset },
            _ => return Err(self.error(offset, "expected first, last and step of a range")),
        };
        if range.step == 0 || range.last < range.first {
            return Err(self.error(offset, "a range needs a step of at least one"));
        }
        Ok(range)
    }

    /// Members of a set: numbers, or names of earlier sets.
    fn set_members(
        &mut self,
        fields: &[Cow<str>],
        name: &str,
        of_nodes: bool,
        offset: usize,
    ) -> Result<(), MeshError> {
        for field in fields.iter().filter(|field| !field.is_empty()) {
            if let Ok(number) = field.parse::<u64>() {
                self.sets(of_nodes).add(name, Numbers::one(number, offset))?;
            } else if !self.sets(of_nodes).add_set(name, field.trim_matches('"'))? {
                return Err(self.error(offset, format!("no set {field} is defined above this line")));
            }
        }
        Ok(())
    }

    /// An entry of a surface: element number or set, and a face S1–S6.
    fn surface_face(&mut self, fields: &[Cow<str>], name: &str, offset: usize) -> Result<(), MeshError> {
        let [element, face] = fields else {
            return Err(self.error(offset, "expected an element or a set of them, and a face S1 to S6"));
        };
        let side = (1..=6).find(|i| face.eq_ignore_ascii_case(&format!("S{i}")));
        let Some(side) = side else {
            return Err(
                self.error(offset, format!("expected a face S1 to S6, found {}", shown(face.as_bytes())))
            );
        };
        let element = element.trim_matches('"').to_owned();
        self.surfaces.entry(name.to_owned()).or_default().push((element, side - 1, offset));
        Ok(())
    }
}
