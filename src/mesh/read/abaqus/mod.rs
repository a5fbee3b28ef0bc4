//! Abaqus and CalculiX `.inp` files: nodes, solid elements, sets and surfaces; everything else is skipped and noted.
//!
//! The part of an element is named by the `*SOLID SECTION` of its element set; without one, by the `ELSET` of its
//! `*ELEMENT`; without that, by the first `*ELSET` that lists it. Elements that are not volumes, in a named set, form a
//! node set. (Abaqus Analysis User's Manual, "Input syntax rules", "Defining elements by specifying their nodes".)

mod data;
mod lines;
mod resolve;
mod sets;

use super::assembly::{Assembly, Unused, within_names};
use super::cursor::{Numbers as Encoding, place_of};
use crate::mesh::{CellKind, Mesh, MeshError};
use lines::{Keyword, Line, Lines};
use sets::Sets;
use std::collections::{BTreeMap, HashMap};

/// Reads an `.inp` file.
///
/// # Errors
/// As [`super::read_mesh`].
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let mut reader = Reader::new(bytes);
    for (offset, line) in Lines::new(bytes) {
        match line {
            Line::Keyword(keyword) => reader.keyword(&keyword, offset)?,
            Line::Data { fields, continues } => reader.data(&fields, continues, offset)?,
        }
    }
    reader.into_mesh()
}

/// Meaning of the data lines below the last keyword.
enum Block {
    /// Data that is not used.
    Skipped,
    /// Nodes, of this node set if there is one.
    Nodes { set: Option<String> },
    /// Cells, of this element set if there is one; an element may continue over several lines.
    Cells { kind: CellKind, set: Option<CardSet>, pending: Vec<u64>, start: usize },
    /// Elements of unsupported types; `fresh` when the next line begins an element.
    Others { set: Option<String>, kind: String, volume: bool, fresh: bool },
    /// A set of nodes or of elements.
    Set { name: String, of_nodes: bool, generate: bool },
    /// A surface of element faces.
    Surface { name: String },
    /// Position of an instance, which must be the identity.
    Instance,
}

/// Element set named by an `*ELEMENT` line.
#[derive(Clone)]
struct CardSet {
    name: String,
    /// Its index in `card_sets`.
    index: u32,
}

/// A line-by-line reader of the file.
struct Reader<'a> {
    bytes: &'a [u8],
    assembly: Assembly,
    block: Block,
    node_sets: Sets,
    element_sets: Sets,
    /// Cell index of each element number, `None` for other elements.
    elements: HashMap<u64, Option<u32>>,
    /// Element set of the `*ELEMENT` line of each cell, as an index into `card_sets`.
    card_set_of: Vec<Option<u32>>,
    card_sets: Vec<String>,
    /// Index in `card_sets` of each name, in capitals.
    card_set_index: HashMap<String, u32>,
    /// Nodes of elements that are not volumes, by element set.
    facets: Sets,
    /// Faces of each surface: element number or set, face from 0, and byte offset.
    surfaces: BTreeMap<String, Vec<(String, usize, usize)>>,
    /// Names of the element sets of solid sections.
    sections: Vec<String>,
    skipped: Unused,
    parts_seen: usize,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            assembly: Assembly::default(),
            block: Block::Skipped,
            node_sets: Sets::of_file(bytes.len()),
            element_sets: Sets::of_file(bytes.len()),
            elements: HashMap::new(),
            card_set_of: Vec::new(),
            card_sets: Vec::new(),
            card_set_index: HashMap::new(),
            facets: Sets::of_file(bytes.len()),
            surfaces: BTreeMap::new(),
            sections: Vec::new(),
            skipped: Unused::default(),
            parts_seen: 0,
        }
    }

    /// An error at a given byte offset.
    fn error(&self, offset: usize, message: impl Into<String>) -> MeshError {
        let place = place_of(self.bytes, offset, Encoding::Text);
        MeshError::Malformed { place, message: message.into() }
    }

    /// An error for an unsupported feature.
    fn refuse(&self, offset: usize, what: &str, remedy: &str) -> MeshError {
        let place = place_of(self.bytes, offset, Encoding::Text);
        MeshError::Unsupported { what: format!("{place}: {what}"), remedy: remedy.into() }
    }

    /// Handles a keyword line, which begins a block.
    fn keyword(&mut self, keyword: &Keyword, offset: usize) -> Result<(), MeshError> {
        self.end_block()?;
        self.block = match keyword.name.as_str() {
            "NODE" => self.begin_nodes(keyword, offset)?,
            "ELEMENT" => self.begin_elements(keyword, offset)?,
            "NSET" => self.begin_set(keyword, offset, true)?,
            "ELSET" => self.begin_set(keyword, offset, false)?,
            "SURFACE" => self.begin_surface(keyword, offset)?,
            "SOLID SECTION" => {
                self.sections.extend(keyword.value("ELSET").map(str::to_owned));
                Block::Skipped
            }
            "INSTANCE" => Block::Instance,
            "PART" => {
                self.parts_seen += 1;
                if self.parts_seen > 1 {
                    let remedy = "write a flat input file with unique node numbers";
                    return Err(self.refuse(offset, "more than one *PART", remedy));
                }
                Block::Skipped
            }
            "INCLUDE" => {
                return Err(self.refuse(offset, "*INCLUDE", "put everything into one file"));
            }
            "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "ELGEN" | "ELCOPY" | "SYSTEM" => {
                let what = format!("*{} makes or moves nodes or elements", keyword.name);
                return Err(self.refuse(offset, &what, "write out all nodes and elements"));
            }
            "HEADING" | "PREPRINT" | "END PART" | "END INSTANCE" | "ASSEMBLY" | "END ASSEMBLY" => {
                Block::Skipped
            }
            other => {
                self.skipped.add(other, Some(offset));
                Block::Skipped
            }
        };
        Ok(())
    }

    fn begin_nodes(&mut self, keyword: &Keyword, offset: usize) -> Result<Block, MeshError> {
        self.refuse_other_files(keyword, offset)?;
        if keyword.value("SYSTEM").is_some_and(|system| !system.eq_ignore_ascii_case("R")) {
            return Err(self.refuse(offset, "nodes in curved coordinates", "write x, y, z"));
        }
        Ok(Block::Nodes { set: keyword.value("NSET").map(str::to_owned) })
    }

    fn begin_elements(&mut self, keyword: &Keyword, offset: usize) -> Result<Block, MeshError> {
        self.refuse_other_files(keyword, offset)?;
        let Some(kind) = keyword.value("TYPE").map(str::to_ascii_uppercase) else {
            return Err(self.error(offset, "*ELEMENT needs a TYPE"));
        };
        let set = keyword.value("ELSET").map(str::to_owned);
        if let Some(name) = &set {
            self.element_sets.touch(name)?;
        }
        if let Some(kind) = CellKind::of_abaqus(&kind) {
            let set = set.map(|name| self.card_set(name));
            return Ok(Block::Cells { kind, set, pending: Vec::new(), start: offset });
        }
        // Continuum, acoustic, diffusive and shell-like solids, cohesive and infinite elements, fluids.
        let volume =
            ["C3D", "AC3D", "DC3D", "DCC3D", "SC6", "SC8", "CSS8", "COH3D", "CIN3D", "FC3D", "Q3D", "EC3D"];
        let volume = volume.iter().any(|prefix| kind.starts_with(prefix));
        Ok(Block::Others { set, kind, volume, fresh: true })
    }

    /// Element set of an `*ELEMENT` line, under the first spelling of its name.
    fn card_set(&mut self, name: String) -> CardSet {
        let card_sets = &mut self.card_sets;
        let index = *self.card_set_index.entry(name.to_uppercase()).or_insert_with(|| {
            card_sets.push(name.clone());
            (card_sets.len() - 1) as u32
        });
        CardSet { name, index }
    }

    fn begin_set(&mut self, keyword: &Keyword, offset: usize, of_nodes: bool) -> Result<Block, MeshError> {
        let own = if of_nodes { "NSET" } else { "ELSET" };
        let Some(name) = keyword.value(own).filter(|name| !name.is_empty()).map(str::to_owned) else {
            return Err(self.error(offset, format!("*{own} needs a name, {own}=…")));
        };
        if of_nodes && keyword.has("ELSET") {
            return Err(self.refuse(offset, "a node set made from an element set", "list its nodes"));
        }
        let sets = if of_nodes { &mut self.node_sets } else { &mut self.element_sets };
        sets.touch(&name)?;
        Ok(Block::Set { name, of_nodes, generate: keyword.has("GENERATE") })
    }

    fn begin_surface(&mut self, keyword: &Keyword, offset: usize) -> Result<Block, MeshError> {
        let Some(name) = keyword.value("NAME").filter(|name| !name.is_empty()).map(str::to_owned) else {
            return Err(self.error(offset, "*SURFACE needs a NAME"));
        };
        match keyword.value("TYPE").map(str::to_ascii_uppercase).as_deref() {
            None | Some("ELEMENT") => {
                self.surfaces.entry(name.clone()).or_default();
                within_names(self.surfaces.len())?;
                Ok(Block::Surface { name })
            }
            Some(other) => {
                self.skipped.add(&format!("SURFACE of type {other}"), Some(offset));
                Ok(Block::Skipped)
            }
        }
    }

    /// Refuses data in other files.
    fn refuse_other_files(&self, keyword: &Keyword, offset: usize) -> Result<(), MeshError> {
        if keyword.has("INPUT") || keyword.has("FILE") {
            return Err(self.refuse(offset, "data in another file", "put everything into one file"));
        }
        Ok(())
    }

    /// Checks at the end of a block that no element is incomplete.
    fn end_block(&mut self) -> Result<(), MeshError> {
        match &self.block {
            Block::Cells { kind, pending, start, .. } if !pending.is_empty() => Err(self.error(
                *start,
                format!("an element of {} nodes with {}", kind.node_count(), pending.len() - 1),
            )),
            _ => Ok(()),
        }
    }

    /// The mesh of everything that was read.
    fn into_mesh(mut self) -> Result<Mesh, MeshError> {
        self.end_block()?;
        self.assign_parts()?;
        self.collect_node_sets()?;
        let place = |offset| place_of(self.bytes, offset, Encoding::Text);
        self.assembly.note_unused(("keywords", "*"), &self.skipped, place);
        self.assembly.into_mesh(place)
    }
}
