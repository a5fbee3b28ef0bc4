//! The unknowns of a nodal vector field, and their order of elimination.

use super::SparseError;
use super::ordering::Graph;
use crate::followers::Followers;
use crate::tensor::Vec3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Marks a node without unknowns.
const NONE: u32 = u32::MAX;

/// The unknowns of a vector field at nodes: one for each free axis, those of a node contiguous, nodes in the order of
/// elimination.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// First unknown of each node, [`NONE`] where all axes are fixed.
    first: Vec<u32>,
    /// Free axes of each node, a bit each.
    free: Vec<u8>,
    /// Nodes with unknowns, in the order of elimination.
    order: Vec<u32>,
    /// Position of each node in the order, [`NONE`] for nodes without unknowns.
    position: Vec<u32>,
    /// Blocks of the lower triangle: start of the list of each position in the order, number of nodes in the order +
    /// 1.
    pub(super) block_start: Vec<u32>,
    /// Positions of the blocks below the diagonal, ascending in each list.
    pub(super) block_row: Vec<u32>,
    count: usize,
    /// Nodes that follow others, without unknowns of their own.
    followers: Arc<Followers>,
}

impl Unknowns {
    /// For nodes that are free along the axes where `is_free` says so, coupled by elements given by their nodes; none
    /// of them follows others.
    ///
    /// # Errors
    /// [`SparseError::Ordering`].
    pub fn new<'a, E: AsRef<[u32]> + ?Sized + 'a>(
        node_count: usize,
        is_free: impl Fn(usize, usize) -> bool,
        elements: impl Iterator<Item = &'a E>,
    ) -> Result<Self, SparseError> {
        Self::with_followers(node_count, is_free, elements, Arc::default())
    }

    /// As [`Self::new`], with nodes that follow others: an element couples the masters of its nodes.
    ///
    /// # Errors
    /// [`SparseError::Ordering`].
    pub fn with_followers<'a, E: AsRef<[u32]> + ?Sized + 'a>(
        node_count: usize,
        is_free: impl Fn(usize, usize) -> bool,
        elements: impl Iterator<Item = &'a E>,
        followers: Arc<Followers>,
    ) -> Result<Self, SparseError> {
        let is_unknown = |node: usize, axis: usize| !followers.contains(node) && is_free(node, axis);
        let free: Vec<u8> = (0..node_count)
            .map(|node| (0..3).filter(|axis| is_unknown(node, *axis)).map(|axis| 1_u8 << axis).sum())
            .collect();
        // Only nodes with unknowns are in the graph.
        let nodes: Vec<u32> = (0..node_count as u32).filter(|node| free[*node as usize] != 0).collect();
        let mut vertex = vec![NONE; node_count];
        for (i, node) in nodes.iter().enumerate() {
            vertex[*node as usize] = i as u32;
        }
        let clique = |nodes: &E| -> Vec<u32> {
            let movers = nodes.as_ref().iter().flat_map(|node| followers.movers(*node));
            let vertices: Vec<u32> = movers.map(|(n, _)| vertex[n as usize]).filter(|v| *v != NONE).collect();
            if followers.is_empty() { vertices } else { BTreeSet::from_iter(vertices).into_iter().collect() }
        };
        let cliques: Vec<Vec<u32>> = elements.map(clique).collect();
        let graph = Graph::from_cliques(nodes.len(), cliques.iter().map(Vec::as_slice));
        let elimination = graph.elimination_order()?;

        // Number the unknowns in the order of elimination.
        let order: Vec<u32> = elimination.iter().map(|v| nodes[*v as usize]).collect();
        let (mut first, mut position) = (vec![NONE; node_count], vec![NONE; node_count]);
        let mut count = 0;
        for (i, node) in order.iter().enumerate() {
            first[*node as usize] = count;
            position[*node as usize] = i as u32;
            count += free[*node as usize].count_ones();
        }
        // Pattern of the lower triangle.
        let (mut block_start, mut block_row) = (vec![0], Vec::new());
        for (i, v) in elimination.iter().enumerate() {
            let begin = block_row.len();
            let places = graph.of(*v).map(|neighbour| position[nodes[neighbour as usize] as usize]);
            block_row.extend(places.filter(|place| *place > i as u32));
            block_row[begin..].sort_unstable();
            block_start.push(block_row.len() as u32);
        }
        let count = count as usize;
        Ok(Self { first, free, order, position, block_start, block_row, count, followers })
    }

    /// Nodes that follow others.
    pub(super) fn followers(&self) -> &Followers {
        &self.followers
    }

    /// Number of unknowns in total.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The unknown of a node along an axis, `None` where it is fixed.
    pub fn of(&self, node: usize, axis: usize) -> Option<usize> {
        let free = self.free[node];
        let is_free = free & (1 << axis) != 0;
        is_free.then(|| (self.first[node] + (free & ((1 << axis) - 1)).count_ones()) as usize)
    }

    /// Gathers the unknown components of a nodal field, in their order.
    pub fn gather(&self, field: &[Vec3], to: &mut [f64]) {
        self.for_each(|unknown, node, axis| to[unknown] = field[node][axis]);
    }

    /// The reverse of [`Unknowns::gather`]; fixed components keep their values.
    pub fn scatter(&self, from: &[f64], field: &mut [Vec3]) {
        self.for_each(|unknown, node, axis| field[node][axis] = from[unknown]);
    }

    /// Visits (unknown, node, axis) in order.
    pub fn for_each(&self, mut visit: impl FnMut(usize, usize, usize)) {
        let mut unknown = 0;
        for node in self.order.iter().map(|node| *node as usize) {
            for axis in 0..3 {
                if self.free[node] & (1 << axis) != 0 {
                    visit(unknown, node, axis);
                    unknown += 1;
                }
            }
        }
    }

    /// Nodes in the order of elimination.
    pub(super) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Position of a node in the order, `None` where it has no unknowns.
    pub(super) fn position(&self, node: u32) -> Option<u32> {
        Some(self.position[node as usize]).filter(|place| *place != NONE)
    }

    /// First unknown of a position in the order.
    pub(super) fn first(&self, place: u32) -> usize {
        self.first[self.order[place as usize] as usize] as usize
    }

    /// Free axes of a position in the order, ascending.
    pub(super) fn axes(&self, place: u32) -> impl Iterator<Item = usize> + Clone + use<> {
        let free = self.free[self.order[place as usize] as usize];
        (0..3).filter(move |axis| free & (1 << axis) != 0)
    }
}
