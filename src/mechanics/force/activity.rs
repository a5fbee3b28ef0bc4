//! Inactive elements: not evaluated until something reaches them, with identical results.
//!
//! In an explicit step a disturbance travels by one element. An element whose nodes have u = 0 and v = 0 bit by bit, without load, has
//! no force, so it need not be evaluated until one of its nodes moves; the bits are those of an evaluation over everything. What is
//! active stays active: a node that has come back to exactly zero is not worth looking for.

use super::block::ElementBlock;
use super::chunk::ChunkForces;
use super::{Assembly, ElementForces};
use crate::tensor::Vec3;
use std::ops::Range;

/// Which nodes have moved, and which have to be stepped.
#[derive(Debug)]
pub struct Activity {
    /// Nodes that have moved.
    moved: Vec<bool>,
    /// Blocks of nodes that belong to an element that is active, or have moved.
    active: Vec<bool>,
    /// Chunks with a node that has just been marked.
    dirty: Vec<u32>,
}

impl Activity {
    /// Nodes that are stepped, or not, together.
    pub const NODES: usize = 64;

    /// Every node and element is active, as before the first evaluation.
    pub fn everything(node_count: usize, forces: &ElementForces) -> Self {
        let blocks = node_count.div_ceil(Self::NODES);
        // A node marks its chunks once in a run: with capacity for all of them a step allocates nothing.
        let places = forces.chunks.iter().map(|chunk| chunk.force.len()).sum();
        Self { moved: vec![true; node_count], active: vec![true; blocks], dirty: Vec::with_capacity(places) }
    }

    /// Which blocks of [`Activity::NODES`] consecutive nodes have to be stepped.
    pub fn active(&self) -> &[bool] {
        &self.active
    }

    /// Nodes of a range that have to be stepped, ascending.
    pub fn stepped(&self, nodes: Range<u32>) -> impl Iterator<Item = usize> {
        let (first, end) = (nodes.start as usize, nodes.end as usize);
        let blocks = (first / Self::NODES..end.div_ceil(Self::NODES)).filter(|block| self.active[*block]);
        blocks.flat_map(move |block| (block * Self::NODES).max(first)..((block + 1) * Self::NODES).min(end))
    }

    /// Deactivates what is at rest: nodes with u = 0 and v = 0 bit by bit, and elements without a history whose nodes all
    /// are. Call after an evaluation over all elements, so that the inactive ones have their sums and extremes.
    pub fn deactivate_at_rest(
        &mut self,
        forces: &mut ElementForces,
        blocks: &[ElementBlock],
        assembly: &Assembly,
        (u, v): (&[Vec3], &[Vec3]),
    ) {
        self.moved.fill(false);
        self.active.fill(false);
        for chunk in &mut forces.chunks {
            chunk.active = 0;
            let rows = blocks[chunk.block as usize].history_rows();
            for i in 0..chunk.batches.len() {
                let history = &chunk.history[i * rows..(i + 1) * rows];
                if history.iter().any(|row| row.0.iter().any(|x| *x != 0.0)) {
                    self.activate_batch(&blocks[chunk.block as usize], assembly, chunk, i);
                }
            }
        }
        let at_rest = |node: &usize| u[*node] == Vec3::zeros() && v[*node] == Vec3::zeros();
        for node in (0..u.len()).filter(|node| !at_rest(node)) {
            self.mark(assembly, node);
        }
        self.spread(forces, blocks, assembly);
    }

    /// Activates the elements of those nodes that have begun to move, among the nodes that are stepped.
    pub fn activate_moving(
        &mut self,
        forces: &mut ElementForces,
        blocks: &[ElementBlock],
        assembly: &Assembly,
        v: &[Vec3],
    ) {
        if forces.chunks.iter().all(ChunkForces::is_wholly_active) {
            return;
        }
        for block in 0..self.active.len() {
            if self.active[block] {
                let nodes = block * Self::NODES..((block + 1) * Self::NODES).min(self.moved.len());
                for node in nodes {
                    if !self.moved[node] && v[node] != Vec3::zeros() {
                        self.mark(assembly, node);
                    }
                }
            }
        }
        self.spread(forces, blocks, assembly);
    }

    /// Activates the elements of nodes that have been moved from outside.
    pub fn activate_nodes(
        &mut self,
        forces: &mut ElementForces,
        blocks: &[ElementBlock],
        assembly: &Assembly,
        nodes: impl Iterator<Item = u32>,
    ) {
        for node in nodes {
            self.mark(assembly, node as usize);
        }
        self.spread(forces, blocks, assembly);
    }

    /// Marks a node that has moved, and those that follow it, with their chunks.
    fn mark(&mut self, assembly: &Assembly, node: usize) {
        self.mark_itself(assembly, node);
        for (follower, _) in assembly.followers().led_by(node) {
            self.mark_itself(assembly, *follower as usize);
        }
    }

    fn mark_itself(&mut self, assembly: &Assembly, node: usize) {
        if !self.moved[node] {
            self.moved[node] = true;
            self.active[node / Self::NODES] = true;
            self.dirty.extend(assembly.places(node).iter().map(|(chunk, _)| *chunk));
        }
    }

    /// Activates the inactive batches of dirty chunks that have a node that has moved.
    fn spread(&mut self, forces: &mut ElementForces, blocks: &[ElementBlock], assembly: &Assembly) {
        self.dirty.sort_unstable();
        self.dirty.dedup();
        for d in 0..self.dirty.len() {
            let c = self.dirty[d];
            let chunk = &mut forces.chunks[c as usize];
            let block = &blocks[chunk.block as usize];
            let nodes = block.nodes_of_chunk(chunk.chunk as usize);
            let first = block.chunks[chunk.chunk as usize].batches.start as usize;
            for i in 0..chunk.batches.len() {
                let is_reached = || {
                    let batch = block.nodes_of_batch(first + i);
                    batch.as_flattened().iter().any(|node| self.moved[nodes[*node as usize] as usize])
                };
                if chunk.active & (1 << i) == 0 && is_reached() {
                    self.activate_batch(block, assembly, chunk, i);
                }
            }
        }
        self.dirty.clear();
    }

    /// A batch acts on its nodes from here on, and on those that they follow.
    fn activate_batch(
        &mut self,
        block: &ElementBlock,
        assembly: &Assembly,
        chunk: &mut ChunkForces,
        i: usize,
    ) {
        chunk.active |= 1 << i;
        let nodes = block.nodes_of_chunk(chunk.chunk as usize);
        let first = block.chunks[chunk.chunk as usize].batches.start as usize;
        for node in block.nodes_of_batch(first + i).as_flattened() {
            let node = nodes[*node as usize] as usize;
            self.active[node / Self::NODES] = true;
            for (master, _) in assembly.followers().masters(node) {
                self.active[*master as usize / Self::NODES] = true;
            }
        }
    }
}
