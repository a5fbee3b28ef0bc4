//! Contents of a file of either version, and the mesh made from them.

use super::element_kind::ElementKind;
use crate::mesh::cell::MOST_NODES;
use crate::mesh::read::assembly::{Assembly, NodeTag};
use crate::mesh::read::cursor::{Cursor, Numbers, place_of};
use crate::mesh::{Mesh, MeshError};
use std::collections::{BTreeMap, HashMap};

/// Contents read so far.
#[derive(Default)]
pub(super) struct Contents {
    pub assembly: Assembly,
    /// Names of the physical groups by dimension and tag.
    pub names: BTreeMap<(u8, i32), String>,
    /// Physical groups of each geometrical entity by dimension and tag (version 4).
    pub groups_of_entity: BTreeMap<(u8, i32), Vec<i32>>,
    /// Physical group of each cell, 0 for none.
    pub group_of_cell: Vec<i32>,
    /// Nodes of the elements in each physical group of points, lines and surfaces.
    pub boundary: BTreeMap<(u8, i32), Vec<NodeTag>>,
    /// Whether the element of each number is a volume; only looked up.
    pub is_volume: HashMap<u64, bool>,
    /// Number of cells in more than one physical group.
    pub in_many_groups: usize,
}

impl Contents {
    /// Adds one element with its number and its physical groups. Version 2 repeats points, lines and surfaces for each of their groups.
    ///
    /// # Errors
    /// `Malformed` for a second element of the number of a volume.
    pub fn add_element(
        &mut self,
        cursor: &Cursor,
        (number, kind): (u64, &ElementKind),
        groups: &[i32],
        (nodes, offset): (&[u64], usize),
    ) -> Result<(), MeshError> {
        let is_volume = kind.dimension == 3;
        if let Some(is_other_volume) = self.is_volume.insert(number, is_volume)
            && (is_volume || is_other_volume)
        {
            return Err(cursor.error_at(offset, format!("element {number} is defined twice")));
        }
        if let Some(cell) = kind.cell {
            let mut ours = [0; MOST_NODES];
            let order = cell.table().gmsh.order;
            for (ours, &place) in ours.iter_mut().zip(order) {
                *ours = nodes[place];
            }
            self.assembly.add_cell(cell, &ours[..order.len()], offset);
            self.group_of_cell.push(groups.first().copied().unwrap_or(0));
            self.in_many_groups += usize::from(groups.len() > 1);
            return Ok(());
        }
        if is_volume {
            *self.assembly.unsupported.entry(kind.name.to_owned()).or_default() += 1;
            return Ok(());
        }
        for &group in groups {
            let nodes = nodes.iter().map(|&tag| NodeTag { tag, offset });
            self.boundary.entry((kind.dimension, group)).or_default().extend(nodes);
        }
        Ok(())
    }

    /// Adds a node of the file.
    pub fn add_node(
        &mut self,
        cursor: &Cursor,
        tag: u64,
        position: [f64; 3],
        offset: usize,
    ) -> Result<(), MeshError> {
        if self.assembly.add_node(tag, position.into()) {
            Ok(())
        } else {
            Err(cursor.error_at(offset, format!("node {tag} is defined twice")))
        }
    }

    /// Names the groups and makes the mesh. Groups without a name are called `physical_1`, those of lines and points
    /// `physical_line_1` and `physical_point_1`, since tags are unique only within a dimension.
    pub fn into_mesh(mut self, bytes: &[u8], numbers: Numbers) -> Result<Mesh, MeshError> {
        let name_of = |dimension: u8, group: i32| match (self.names.get(&(dimension, group)), dimension) {
            (Some(name), _) => name.clone(),
            (None, 0) => format!("physical_point_{group}"),
            (None, 1) => format!("physical_line_{group}"),
            (None, _) if group == 0 => "unnamed".to_owned(),
            (None, _) => format!("physical_{group}"),
        };
        let mut groups = self.group_of_cell.clone();
        groups.sort_unstable();
        groups.dedup();
        let part_of_group: BTreeMap<i32, u32> =
            groups.into_iter().map(|group| (group, self.assembly.part(&name_of(3, group)))).collect();
        self.assembly.part_of = self.group_of_cell.iter().map(|group| part_of_group[group]).collect();
        for ((dimension, group), nodes) in std::mem::take(&mut self.boundary) {
            // Group 0 means no group.
            if group != 0 {
                self.assembly.node_sets.entry(name_of(dimension, group)).or_default().extend(nodes);
            }
        }
        if self.in_many_groups > 0 {
            self.assembly.notes.push(format!(
                "{} volume elements are in more than one physical group and belong to the first",
                self.in_many_groups
            ));
        }
        self.assembly.into_mesh(|offset| place_of(bytes, offset, numbers))
    }
}
