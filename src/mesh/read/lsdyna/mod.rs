//! LS-DYNA keyword files `.k`, `.key`: nodes, solid elements, names of parts, sets; everything else is skipped and noted
//! (LS-DYNA Keyword User's Manual, Vol. I).
//!
//! The part of an element is named by the title of its `*PART`, or `part_<number>`. Sets of nodes, of segments, and of parts
//! become node sets, named by their titles or `set_<number>`; the nodes of shells form a node set named like their part.

mod card;
mod collect;
mod deck;
mod set;
mod solid;

#[cfg(test)]
mod tests;

use super::assembly::{Assembly, NodeTag, Unused, free_name, within_names};
use super::cursor::{fortran_position, shown};
use super::include::Include;
use crate::mesh::{Mesh, MeshError};
use card::{Card, Format};
use deck::{Deck, keyword_of};
use set::{Set, set_keyword};
use solid::Solid;
use std::collections::{BTreeMap, HashSet};

/// Reads a keyword file; `include` reads the files that it names.
///
/// # Errors
/// As [`super::read_mesh`].
pub(super) fn read(bytes: &[u8], include: Include) -> Result<Mesh, MeshError> {
    let deck = Deck::new(bytes, include)?;
    let mut reader = Reader::new(&deck);
    for line in deck.lines() {
        if let Some(keyword) = keyword_of(line.bytes) {
            reader.keyword(&keyword, line.bytes, line.offset)?;
        } else {
            reader.data(line.bytes, line.offset)?;
        }
    }
    reader.into_mesh()
}

/// Whether a file begins as a keyword file: with `*KEYWORD`, or with comments after `$`.
pub(super) fn begins(start: &[u8]) -> bool {
    let first = start.split(|&b| b == b'\n').find(|line| !line.starts_with(b"$"));
    let is_keyword =
        first.is_some_and(|line| keyword_of(line).is_some_and(|keyword| keyword.starts_with("KEYWORD")));
    is_keyword || (start.starts_with(b"$") && first.is_some_and(|line| line.starts_with(b"*")))
}

/// Meaning of the lines below the last keyword.
enum Block {
    /// A keyword that is not used: its lines are passed over.
    Skipped,
    Nodes,
    /// Solid elements; number, part and offset of one whose nodes are on the next line.
    Solids {
        begun: Option<(u64, u64, usize)>,
    },
    /// Shells, of which only the nodes count.
    Shells,
    /// Unsupported elements, by name.
    Others(&'static str),
    /// Titles and numbers of parts; the title if its number comes next.
    Parts {
        title: Option<String>,
    },
    Set(Box<Set>),
}

struct Reader<'d> {
    deck: &'d Deck<'d>,
    assembly: Assembly,
    /// Numbers of all nodes.
    nodes: Vec<u64>,
    /// Numbers of all solid elements; only looked up.
    elements: HashSet<u64>,
    /// Part of each cell by its number.
    part_of_cell: Vec<u64>,
    /// Title of each part.
    titles: BTreeMap<u64, String>,
    /// Nodes of the shells of each part.
    shells: BTreeMap<u64, Vec<NodeTag>>,
    sets: Vec<Set>,
    block: Block,
    /// Format of the deck, and of the block.
    format: [Format; 2],
    skipped: Unused,
}

impl<'d> Reader<'d> {
    fn new(deck: &'d Deck<'d>) -> Self {
        Self {
            deck,
            assembly: Assembly::default(),
            nodes: Vec::new(),
            elements: HashSet::new(),
            part_of_cell: Vec::new(),
            titles: BTreeMap::new(),
            shells: BTreeMap::new(),
            sets: Vec::new(),
            block: Block::Skipped,
            format: [Format::Standard; 2],
            skipped: Unused::default(),
        }
    }

    /// An error at a given offset.
    fn error(&self, offset: usize, message: impl Into<String>) -> MeshError {
        MeshError::Malformed { place: self.deck.place(offset), message: message.into() }
    }

    /// An error for an unsupported feature.
    fn refuse(&self, offset: usize, what: &str, remedy: &str) -> MeshError {
        MeshError::Unsupported { what: format!("{}: {what}", self.deck.place(offset)), remedy: remedy.into() }
    }

    /// Begins the block of a keyword.
    fn keyword(&mut self, keyword: &str, line: &[u8], offset: usize) -> Result<(), MeshError> {
        self.end_block()?;
        self.format[1] = Format::of_keyword(line, self.format[0]);
        self.block = match keyword {
            "KEYWORD" | "KEYWORD_ID" => {
                self.format = [Format::of_deck(line).unwrap_or(self.format[0]); 2];
                Block::Skipped
            }
            "TITLE" | "COMMENT" | "INCLUDE" | "END" => Block::Skipped,
            "NODE" => Block::Nodes,
            "ELEMENT_SOLID" => Block::Solids { begun: None },
            "ELEMENT_SHELL" => Block::Shells,
            "ELEMENT_TSHELL" => Block::Others("thick shell"),
            "PART" => Block::Parts { title: None },
            _ if keyword.starts_with("ELEMENT_SOLID_") => {
                let remedy = "write the elements as *ELEMENT_SOLID with the nodes that they have";
                return Err(self.refuse(offset, &format!("*{}", shown(keyword.as_bytes())), remedy));
            }
            "NODE_TRANSFORM" | "NODE_MERGE" | "NODE_MERGE_SET" => {
                return Err(self.refuse(
                    offset,
                    &format!("*{keyword}"),
                    "write the nodes as they are after it",
                ));
            }
            _ => {
                if let Some((members, titled)) = set_keyword(keyword) {
                    Block::Set(Box::new(Set::new(members, titled, offset)))
                } else {
                    self.skipped.add(keyword, Some(offset));
                    Block::Skipped
                }
            }
        };
        Ok(())
    }

    /// Reads one data line.
    fn data(&mut self, line: &[u8], offset: usize) -> Result<(), MeshError> {
        // The block is moved out while its line is read, so that the rest of the reader can change.
        let mut block = std::mem::replace(&mut self.block, Block::Skipped);
        let format = self.format[1];
        match &mut block {
            Block::Parts { title: title @ None } => {
                *title = Some(String::from_utf8_lossy(line).trim().to_owned());
            }
            Block::Set(set) if set.awaits_title() => self.set_line(set, line, format, offset)?,
            _ if line.is_empty() => {}
            Block::Skipped => {}
            Block::Nodes => self.node(&Card::node(line, format), offset)?,
            Block::Solids { begun } => self.solid(&Card::element(line, format), begun, offset)?,
            Block::Shells => self.shell(&Card::element(line, format), offset)?,
            Block::Others(name) => *self.assembly.unsupported.entry((*name).to_owned()).or_default() += 1,
            Block::Parts { title } => {
                let part = self.number(Card::plain(line, format).get(0), offset)?;
                self.titles.insert(part, title.take().unwrap_or_default());
            }
            Block::Set(set) => self.set_line(set, line, format, offset)?,
        }
        self.block = block;
        Ok(())
    }

    /// Parses the number of a node, an element, a part or a set.
    fn number(&self, field: &str, offset: usize) -> Result<u64, MeshError> {
        field
            .parse()
            .map_err(|_| self.error(offset, format!("expected a number, found {}", shown(field.as_bytes()))))
    }

    /// A node: number and coordinates, which default to zero.
    fn node(&mut self, card: &Card, offset: usize) -> Result<(), MeshError> {
        let tag = self.number(card.get(0), offset)?;
        let position = fortran_position((1..4).map(|i| card.get(i)), |message| self.error(offset, message))?;
        if !self.assembly.add_node(tag, position) {
            return Err(self.error(offset, format!("node {tag} is defined twice")));
        }
        self.nodes.push(tag);
        Ok(())
    }

    /// A line of a solid element: all of it, or its number and part, or its nodes.
    fn solid(
        &mut self,
        card: &Card,
        begun: &mut Option<(u64, u64, usize)>,
        offset: usize,
    ) -> Result<(), MeshError> {
        let ((element, part, start), first) = match begun.take() {
            Some(begun) => (begun, 0),
            None => ((self.number(card.get(0), offset)?, self.number(card.get(1), offset)?, offset), 2),
        };
        if first == 2 && card.is_blank_from(2) {
            *begun = Some((element, part, start));
            return Ok(());
        }
        let mut nodes = Vec::with_capacity(10);
        for field in card.from(first).take(10) {
            nodes.push(if field.is_empty() { 0 } else { self.number(field, offset)? });
        }
        if !self.elements.insert(element) {
            return Err(self.error(start, format!("element {element} is defined twice")));
        }
        match Solid::new(&nodes) {
            None => {
                let count = nodes.iter().filter(|node| **node != 0).count();
                Err(self.error(offset, format!("a solid element has 4, 8 or 10 nodes, not {count}")))
            }
            Some(Solid::Other(name)) => {
                *self.assembly.unsupported.entry(name.to_owned()).or_default() += 1;
                Ok(())
            }
            Some(Solid::Cell(kind, nodes)) => {
                self.assembly.add_cell(kind, &nodes, offset);
                self.part_of_cell.push(part);
                Ok(())
            }
        }
    }

    /// A shell: number, part and nodes.
    fn shell(&mut self, card: &Card, offset: usize) -> Result<(), MeshError> {
        let part = self.number(card.get(1), offset)?;
        for field in card.from(2).filter(|field| !field.is_empty()) {
            let tag = self.number(field, offset)?;
            if tag != 0 {
                self.shells.entry(part).or_default().push(NodeTag { tag, offset });
            }
        }
        Ok(())
    }

    /// Ends a block: keeps its set, and checks that no element is incomplete.
    fn end_block(&mut self) -> Result<(), MeshError> {
        match std::mem::replace(&mut self.block, Block::Skipped) {
            Block::Solids { begun: Some((element, _, offset)) } => {
                Err(self.error(offset, format!("element {element} has no nodes")))
            }
            Block::Set(set) => {
                self.sets.push(*set);
                within_names(self.sets.len())
            }
            _ => Ok(()),
        }
    }

    /// Name of a part: its title, with its number if another part has the same, or `part_` and its number.
    fn part_name(&self, part: u64, count: &BTreeMap<&str, usize>) -> String {
        match self.titles.get(&part).map(String::as_str) {
            None | Some("") => format!("part_{part}"),
            Some(title) if count[title] > 1 => format!("{title}_{part}"),
            Some(title) => title.to_owned(),
        }
    }

    /// The mesh of everything that was read; parts are in the order of their numbers.
    fn into_mesh(mut self) -> Result<Mesh, MeshError> {
        self.end_block()?;
        self.collect_sets()?;
        let mut count: BTreeMap<&str, usize> = BTreeMap::new();
        for title in self.titles.values() {
            *count.entry(title).or_default() += 1;
        }
        let mut parts = self.part_of_cell.clone();
        parts.sort_unstable();
        parts.dedup();
        let names: BTreeMap<u64, String> = parts
            .iter()
            .chain(self.shells.keys())
            .map(|&part| (part, self.part_name(part, &count)))
            .collect();
        let index: BTreeMap<u64, u32> =
            parts.into_iter().map(|part| (part, self.assembly.part(&names[&part]))).collect();
        self.assembly.part_of = self.part_of_cell.iter().map(|part| index[part]).collect();
        for (part, tags) in std::mem::take(&mut self.shells) {
            let name = free_name(&self.assembly.node_sets, &names[&part], "shells");
            self.assembly.node_sets.entry(name).or_default().extend(tags);
        }
        let deck = self.deck;
        self.assembly.note_unused(("keywords", "*"), &self.skipped, |offset| deck.place(offset));
        self.assembly.into_mesh(|offset| deck.place(offset))
    }
}
