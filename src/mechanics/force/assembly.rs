//! The sum of forces at each node over its chunks, in a fixed order.

use super::block::ElementBlock;
use crate::followers::Followers;
use crate::tensor::Vec3;
use std::sync::Arc;

/// Where each node finds its entry in each chunk: a compressed list, ascending in the chunk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assembly {
    /// Where the list of each node starts, nodes + 1.
    start: Vec<u32>,
    /// (chunk over all blocks, node in the chunk).
    places: Vec<(u32, u32)>,
    /// Nodes that follow others: these sum their forces.
    followers: Arc<Followers>,
}

impl Assembly {
    /// Assembly of all blocks of a plan.
    pub fn new(node_count: usize, blocks: &[ElementBlock]) -> Self {
        let chunks = || blocks.iter().flat_map(|b| (0..b.chunk_count()).map(|c| b.nodes_of_chunk(c)));
        let mut start = vec![0_u32; node_count + 1];
        for node in chunks().flatten() {
            start[*node as usize + 1] += 1;
        }
        for node in 0..node_count {
            start[node + 1] += start[node];
        }
        let mut next = start.clone();
        let mut places = vec![(0, 0); start[node_count] as usize];
        for (chunk, nodes) in chunks().enumerate() {
            for (i, node) in nodes.iter().enumerate() {
                let place = &mut next[*node as usize];
                places[*place as usize] = (chunk as u32, i as u32);
                *place += 1;
            }
        }
        Self { start, places, followers: Arc::default() }
    }

    /// The chunks of a node, each with the number of the node in it.
    #[inline]
    pub(super) fn places(&self, node: usize) -> &[(u32, u32)] {
        &self.places[self.start[node] as usize..self.start[node + 1] as usize]
    }

    /// As `self`, with nodes that follow others.
    #[must_use]
    pub fn with(self, followers: Arc<Followers>) -> Self {
        Self { followers, ..self }
    }

    /// The nodes that follow others.
    pub fn followers(&self) -> &Arc<Followers> {
        &self.followers
    }

    /// Sum of a force of each chunk's nodes, by chunk and node in it, at a node. A node gets its fractions of those of its followers, in
    /// ascending order, a follower nothing.
    #[inline]
    pub(super) fn sum_at(&self, node: usize, force: impl Fn(usize, usize) -> Vec3) -> Vec3 {
        let own = |node: usize| {
            let mut sum = Vec3::zeros();
            for (chunk, i) in self.places(node) {
                sum += force(*chunk as usize, *i as usize);
            }
            sum
        };
        if self.followers.is_empty() {
            return own(node);
        }
        if self.followers.contains(node) {
            return Vec3::zeros();
        }
        let led = self.followers.led_by(node);
        led.iter().fold(own(node), |sum, (follower, w)| sum + own(*follower as usize) * *w)
    }

    /// Memory of the lists [bytes].
    pub fn memory(&self) -> usize {
        4 * self.start.len() + 8 * self.places.len() + self.followers.memory()
    }
}
