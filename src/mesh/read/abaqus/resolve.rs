//! After all lines are read: the part of each cell, and the nodes of each set.

use super::Reader;
use crate::mesh::read::assembly::{NodeTag, free_name};
use crate::mesh::read::entries::{Numbers, most_entries, within_limit};
use crate::mesh::{Cell, MeshError};

impl Reader<'_> {
    /// Assigns each cell a part: its solid section, else the set of its `*ELEMENT`, else the first `*ELSET`.
    ///
    /// # Errors
    /// `Malformed` when a section or a set refers to something undefined, or an element has two sections.
    pub(super) fn assign_parts(&mut self) -> Result<(), MeshError> {
        let mut name_of: Vec<Option<String>> = vec![None; self.assembly.cells().len()];
        self.sections.sort_by_key(|section| section.to_uppercase());
        self.sections.dedup_by_key(|section| section.to_uppercase());
        for section in &self.sections {
            let ranges = self.element_sets.get(section).unwrap_or_default();
            for (cell, offset) in self.cells_in(ranges)? {
                let name = &mut name_of[cell as usize];
                if name.as_ref().is_some_and(|other| !other.eq_ignore_ascii_case(section)) {
                    return Err(self.error(offset, "an element has two solid sections"));
                }
                *name = Some(section.clone());
            }
        }
        for (name, card) in name_of.iter_mut().zip(&self.card_set_of) {
            if let (None, Some(card)) = (&name, card) {
                *name = Some(self.card_sets[*card as usize].clone());
            }
        }
        if name_of.iter().any(Option::is_none) {
            for (set, ranges) in self.element_sets.in_order() {
                for (cell, _) in self.cells_in(ranges)? {
                    name_of[cell as usize].get_or_insert_with(|| set.to_owned());
                }
            }
        }
        let without = name_of.iter().filter(|name| name.is_none()).count();
        if without > 0 {
            let note =
                format!("{without} volume elements are in no element set; their part is called unnamed");
            self.assembly.notes.push(note);
        }
        for name in name_of {
            let part = self.assembly.part(name.as_deref().unwrap_or("unnamed"));
            self.assembly.part_of.push(part);
        }
        Ok(())
    }

    /// Element numbers of an entry of a surface: one element or a set.
    ///
    /// # Errors
    /// `Malformed` when the set does not exist.
    fn elements_named(&self, element: &str, offset: usize) -> Result<Vec<Numbers>, MeshError> {
        if let Ok(number) = element.parse::<u64>() {
            return Ok(vec![Numbers::one(number, offset)]);
        }
        let set = self.element_sets.get(element).map(<[Numbers]>::to_vec);
        set.ok_or_else(|| self.error(offset, format!("there is no element set {element}")))
    }

    /// The cells among these elements, with the places where they are named.
    ///
    /// # Errors
    /// `Malformed` when a single element number does not exist.
    fn cells_in(&self, ranges: &[Numbers]) -> Result<Vec<(u32, usize)>, MeshError> {
        let mut cells = Vec::new();
        for range in ranges {
            for number in range.each() {
                match self.elements.get(&number) {
                    Some(Some(cell)) => cells.push((*cell, range.offset)),
                    None if range.is_one() => {
                        return Err(self.error(range.offset, format!("there is no element {number}")));
                    }
                    Some(None) | None => {}
                }
            }
        }
        Ok(cells)
    }

    /// Node sets from sets of nodes, from elements that are not volumes, and from surfaces.
    ///
    /// # Errors
    /// `Malformed` when a surface refers to something undefined; `Unsupported` when sets are too large.
    pub(super) fn collect_node_sets(&mut self) -> Result<(), MeshError> {
        for (name, ranges) in self.node_sets.in_order() {
            let set = self.assembly_set(ranges);
            self.assembly.node_sets.insert(name.to_owned(), set);
        }
        for (name, ranges) in self.facets.in_order() {
            let set = self.assembly_set(ranges);
            let name = free_name(&self.assembly.node_sets, name, "elements");
            self.assembly.node_sets.insert(name, set);
        }
        let (mut entries, most) = (0_u64, most_entries(self.bytes.len()));
        for (name, faces) in std::mem::take(&mut self.surfaces) {
            let mut set = Vec::new();
            for (element, side, offset) in faces {
                let ranges = self.elements_named(&element, offset)?;
                entries = ranges.iter().fold(entries, |sum, range| sum.saturating_add(range.count()));
                within_limit(entries, most)?;
                for (cell, _) in self.cells_in(&ranges)? {
                    let Cell { kind, nodes } = self.assembly.cells().get(cell as usize);
                    let Some(face) = kind.table().faces.get(side) else {
                        let message = format!("a {} has no face S{}", kind.table().title, side + 1);
                        return Err(self.error(offset, message));
                    };
                    let on_face = face.facets.iter().flatten();
                    set.extend(on_face.map(|&i| NodeTag { tag: nodes[i], offset }));
                }
            }
            let name = free_name(&self.assembly.node_sets, &name, "surface");
            self.assembly.node_sets.insert(name, set);
        }
        Ok(())
    }

    /// The nodes of a set. A single number is kept even if there is no such node, which is reported later.
    fn assembly_set(&self, ranges: &[Numbers]) -> Vec<NodeTag> {
        ranges
            .iter()
            .flat_map(|range| range.each().map(move |tag| (tag, range)))
            .filter(|(tag, range)| range.is_one() || self.assembly.has_node(*tag))
            .map(|(tag, range)| NodeTag { tag, offset: range.offset })
            .collect()
    }
}
