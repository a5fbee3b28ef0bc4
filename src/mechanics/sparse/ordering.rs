//! Fill-reducing order of a graph: nested dissection, then the postorder of its elimination tree.
//!
//! The postorder leaves the fill unchanged and makes the columns of every supernode contiguous, so that the
//! factorisation can treat them as a dense panel.

use super::SparseError;
use feral_scotch::{CscPattern, scotch_order};

/// A graph by its adjacency: symmetric, sorted, without loops.
pub(crate) struct Graph {
    /// Start of the neighbours of each vertex, vertices + 1.
    pub start: Vec<i32>,
    /// Neighbours, ascending for each vertex.
    pub neighbours: Vec<i32>,
}

impl Graph {
    /// From cliques of vertices, such as the nodes of elements; repeated edges are merged.
    pub fn from_cliques<'a>(vertices: usize, cliques: impl Iterator<Item = &'a [u32]>) -> Self {
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for clique in cliques {
            for &a in clique {
                edges.extend(clique.iter().filter(|b| **b != a).map(|&b| (a, b)));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let mut start = vec![0; vertices + 1];
        for (a, _) in &edges {
            start[*a as usize + 1] += 1;
        }
        for a in 0..vertices {
            start[a + 1] += start[a];
        }
        Self { start, neighbours: edges.into_iter().map(|(_, b)| b.cast_signed()).collect() }
    }

    /// Neighbours of a vertex.
    pub fn of(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let range = self.start[vertex as usize] as usize..self.start[vertex as usize + 1] as usize;
        self.neighbours[range].iter().map(|b| b.cast_unsigned())
    }

    /// The vertices in the order of elimination.
    pub fn elimination_order(&self) -> Result<Vec<u32>, SparseError> {
        let vertices = self.start.len() - 1;
        let failed = |reason: String| SparseError::Ordering { nodes: vertices, reason };
        let pattern = CscPattern::new(vertices, &self.start, &self.neighbours)
            .ok_or_else(|| failed("its adjacency is not sorted".into()))?;
        let order = scotch_order(&pattern).map_err(|e| failed(format!("{e:?}")))?;
        let order: Vec<u32> = order.into_iter().map(i32::cast_unsigned).collect();
        Ok(self.postordered(&order))
    }

    /// The same elimination, with each subtree of its elimination tree contiguous.
    fn postordered(&self, order: &[u32]) -> Vec<u32> {
        let parent = self.elimination_tree(order);
        let none = u32::MAX;
        let count = order.len();
        // Children of each position, the roots being those of `count`; lists by first child and next sibling,
        // ascending.
        let (mut first, mut next) = (vec![none; count + 1], vec![none; count]);
        for child in (0..count).rev() {
            let above = if parent[child] == none { count } else { parent[child] as usize };
            next[child] = first[above];
            first[above] = child as u32;
        }
        let mut out = Vec::with_capacity(count);
        let mut path = vec![count];
        while let Some(&top) = path.last() {
            let child = first[top];
            if child == none {
                path.pop();
                if top < count {
                    out.push(order[top]);
                }
            } else {
                first[top] = next[child as usize];
                path.push(child as usize);
            }
        }
        out
    }

    /// Parent of each position in the order, `u32::MAX` at roots (Liu 1990, with path compression).
    fn elimination_tree(&self, order: &[u32]) -> Vec<u32> {
        let none = u32::MAX;
        let mut position = vec![0_u32; order.len()];
        for (i, vertex) in order.iter().enumerate() {
            position[*vertex as usize] = i as u32;
        }
        let (mut parent, mut ancestor) = (vec![none; order.len()], vec![none; order.len()]);
        for (i, vertex) in order.iter().enumerate() {
            let i = i as u32;
            for neighbour in self.of(*vertex) {
                let mut below = position[neighbour as usize];
                while below < i {
                    let above = std::mem::replace(&mut ancestor[below as usize], i);
                    if above == none {
                        parent[below as usize] = i;
                    }
                    if above == none || above == i {
                        break;
                    }
                    below = above;
                }
            }
        }
        parent
    }
}
