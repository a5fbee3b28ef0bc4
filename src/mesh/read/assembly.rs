//! From the contents of a file, in its own numbering, to a [`Mesh`].

use crate::mechanics::tensor::Vec3;
use crate::mesh::names::{MOST_NAMES, fault, shortened};
use crate::mesh::{CellKind, Cells, Mesh, MeshError, Place};
use std::collections::{BTreeMap, HashMap};

/// Largest number of names listed in a note on what is not used.
const MOST_LISTED: usize = 50;

/// What a file has that is not used.
#[derive(Default)]
pub(super) struct Unused {
    /// Number of each of the first [`MOST_LISTED`] names, and the byte offset of its first one, where that is known.
    counts: BTreeMap<String, (usize, Option<usize>)>,
    /// Number of names beyond those.
    more: usize,
}

impl Unused {
    /// Counts one of this name, at a byte offset.
    pub(super) fn add(&mut self, name: &str, offset: Option<usize>) {
        if let Some((count, _)) = self.counts.get_mut(name) {
            *count += 1;
        } else if self.counts.len() < MOST_LISTED {
            self.counts.insert(name.to_owned(), (1, offset));
        } else {
            self.more += 1;
        }
    }
}

/// A node number of the file, and the byte offset where it occurs.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeTag {
    /// Number in the file.
    pub(super) tag: u64,
    /// Byte offset in the file.
    pub(super) offset: usize,
}

/// The pieces of a mesh as read from a file, with the node numbers of the file.
#[derive(Default)]
pub(super) struct Assembly {
    nodes: Vec<Vec3>,
    /// Index in `nodes` of each node number; only looked up, never iterated.
    index: HashMap<u64, u32>,
    /// Kind and node numbers of each cell, in our node order.
    cells: Cells<u64>,
    /// Byte offset of each cell.
    offsets: Vec<usize>,
    /// Part index of each cell.
    pub(super) part_of: Vec<u32>,
    /// Names of the parts, in order of appearance.
    parts: Vec<String>,
    /// Index in `parts` of each name; only looked up.
    part_index: HashMap<String, u32>,
    /// Node sets by name.
    pub(super) node_sets: BTreeMap<String, Vec<NodeTag>>,
    /// Volume elements of unsupported kinds: the number of each.
    pub(super) unsupported: BTreeMap<String, usize>,
    /// Remarks for the user.
    pub(super) notes: Vec<String>,
}

impl Assembly {
    /// Adds a node; returns `false` if its number is already used.
    pub(super) fn add_node(&mut self, tag: u64, position: Vec3) -> bool {
        let index = self.nodes.len() as u32;
        self.nodes.push(position);
        self.index.insert(tag, index).is_none()
    }

    /// Whether the file has a node of this number.
    pub(super) fn has_node(&self, tag: u64) -> bool {
        self.index.contains_key(&tag)
    }

    /// Adds a cell with nodes in our order; the reader adds its part to `part_of`.
    pub(super) fn add_cell(&mut self, kind: CellKind, nodes: &[u64], offset: usize) {
        self.cells.push(kind, nodes);
        self.offsets.push(offset);
    }

    /// The cells read so far.
    pub(super) fn cells(&self) -> &Cells<u64> {
        &self.cells
    }

    /// Index of the part with a name, which is added if new.
    pub(super) fn part(&mut self, name: &str) -> u32 {
        if let Some(&part) = self.part_index.get(name) {
            return part;
        }
        let part = self.parts.len() as u32;
        self.parts.push(name.to_owned());
        self.part_index.insert(name.to_owned(), part);
        part
    }

    /// Notes what a file has that is not used: names after `mark`, with the number of each and the place of the first.
    pub(super) fn note_unused(
        &mut self,
        (what, mark): (&str, &str),
        unused: &Unused,
        place: impl Fn(usize) -> Place,
    ) {
        if unused.counts.is_empty() {
            return;
        }
        let named = |(name, (count, first)): (&String, &(usize, Option<usize>))| {
            let name = shortened(name);
            match first.map(&place) {
                None => format!("{mark}{name} ({count})"),
                Some(first) if *count == 1 => format!("{mark}{name} ({first})"),
                Some(first) => format!("{mark}{name} ({count}, first in {first})"),
            }
        };
        let mut list: Vec<String> = unused.counts.iter().map(named).collect();
        if unused.more > 0 {
            list.push(format!("and {} more", unused.more));
        }
        self.notes.push(format!("{what} not used: {}", list.join(", ")));
    }

    /// The mesh, with nodes in the order of the file; `place` names the place of a byte offset.
    ///
    /// # Errors
    /// `UnsupportedElements`, `Empty`, and `Malformed` for a reference to a missing node.
    pub(super) fn into_mesh(self, place: impl Fn(usize) -> Place) -> Result<Mesh, MeshError> {
        if !self.unsupported.is_empty() {
            let kinds = self.unsupported.iter().map(|(kind, count)| format!("{kind} ({count})")).collect();
            return Err(MeshError::UnsupportedElements { kinds });
        }
        if self.cells.is_empty() {
            return Err(MeshError::Empty);
        }
        check_names(self.parts.iter().chain(self.node_sets.keys()))?;
        let resolve = |tag: u64, offset: usize| {
            self.index.get(&tag).copied().ok_or_else(|| MeshError::Malformed {
                place: place(offset),
                message: format!("there is no node {tag}"),
            })
        };
        let mut mesh =
            Mesh { part_of: self.part_of, parts: self.parts, notes: self.notes, ..Mesh::default() };
        mesh.cells = self.cells.try_map(|cell, tag| resolve(tag, self.offsets[cell]))?;
        for (name, tags) in &self.node_sets {
            let mut set = tags.iter().map(|t| resolve(t.tag, t.offset)).collect::<Result<Vec<u32>, _>>()?;
            set.sort_unstable();
            set.dedup();
            mesh.node_sets.insert(name.clone(), set);
        }
        mesh.nodes = self.nodes;
        note_what_is_dropped(&mut mesh);
        Ok(mesh)
    }
}

/// The name, with its origin appended if a node set has that name already.
pub(super) fn free_name(taken: &BTreeMap<String, Vec<NodeTag>>, name: &str, origin: &str) -> String {
    if taken.contains_key(name) { format!("{name}_{origin}") } else { name.to_owned() }
}

/// Refuses too many names, and invalid ones.
fn check_names<'a>(names: impl Iterator<Item = &'a String>) -> Result<(), MeshError> {
    for (index, name) in names.enumerate() {
        within_names(index + 1)?;
        if let Some(limit) = fault(name) {
            return Err(MeshError::Unsupported {
                what: format!("the name {:?} of a part or a node set", shortened(name)),
                remedy: format!("names have {limit}"),
            });
        }
    }
    Ok(())
}

/// Refuses more names than a mesh may have.
///
/// # Errors
/// `Unsupported` beyond the limit.
pub(super) fn within_names(count: usize) -> Result<(), MeshError> {
    if count <= MOST_NAMES {
        return Ok(());
    }
    Err(MeshError::Unsupported {
        what: format!("more than {MOST_NAMES} parts and sets"),
        remedy: "remove those that are not needed".into(),
    })
}

/// Drops nodes without elements, and notes which sets disappear with them.
fn note_what_is_dropped(mesh: &mut Mesh) {
    let names: Vec<String> = mesh.node_sets.keys().cloned().collect();
    let dropped = mesh.drop_unused_nodes();
    if dropped > 0 {
        mesh.notes.push(format!("{dropped} nodes without a volume element were omitted"));
    }
    mesh.node_sets.retain(|_, set| !set.is_empty());
    let gone: Vec<String> = names.into_iter().filter(|name| !mesh.node_sets.contains_key(name)).collect();
    if !gone.is_empty() {
        mesh.notes.push(format!(
            "node sets without any node of a volume element were omitted: {}",
            gone.join(", ")
        ));
    }
}
