//! Subcycling: an element whose critical time step is a multiple of that of the mesh is evaluated every second or fourth step only.
//!
//! An element that is evaluated at t_n, the last time T₋ before and the next time T₊ later, acts on its nodes at t_n by the impulse
//! `½ (T₋ + T₊) f(u_n)`, and not in between: central differences with a step of its own. Momentum is conserved exactly, and the scheme
//! stays symplectic where steps do not change (Tuckerman, Berne & Martyna 1992; Lew, Marsden, Ortiz & West 2003). Elements at contacts are
//! evaluated in every step, so that reactions have no ripples.
//!
//! Steps form cycles, at whose beginnings all elements are evaluated. Batches are the unit: their intervals are powers of two of the step
//! of the cycle.

use super::block::ElementBlock;
use super::chunk::{Chunk, ChunkForces};
use super::cycle::{Interval, LONGEST, SAME_TIME, Subcycles, power_of_two};
use super::{Assembly, ElementForces, Threads};
use crate::lanes::Row;
use crate::tensor::Vec3;

/// Largest fraction of its critical time step in which an element is evaluated less often than the others [-]: the bound of
/// the element is that of the last evaluation, and kicks at intervals resonate with the motion of the nodes before the limit of stability.
const SLOW: f64 = 0.95;
/// Fraction of the largest strain of a step that such an element may be strained by from one evaluation to the next [-].
const SLOW_STRAIN: f64 = 0.5;
/// What a step uses of the admissible one at the beginning of its cycle [-], so that it is not divided where elements become stiffer.
const ROOM: f64 = 0.95;
/// Fraction of the work of all elements above which all are evaluated in every step.
const WORTHWHILE: f64 = 0.75;

/// What a new cycle has to keep to.
#[derive(Clone, Copy, Debug)]
pub struct CycleLimits {
    /// Longest step [s].
    pub longest: f64,
    /// Fraction of the critical time step that is used [-].
    pub safety: f64,
    /// Largest strain of an element in a step [-].
    pub strain: f64,
}

impl Subcycles {
    /// Of the blocks of a plan: none of them is evaluated less often than the others.
    pub fn new(blocks: &[ElementBlock]) -> Self {
        let of_chunk = |chunk: &Chunk| vec![Interval::EVERY_STEP; chunk.batches.len()];
        let intervals = blocks.iter().flat_map(|block| block.chunks.iter().map(of_chunk)).collect();
        Self { intervals, ..Self::default() }
    }

    /// Goes on by a step that ends at `time` [s], after its evaluation. Returns whether the cycle is over.
    pub fn advance(&mut self, time: f64, forces: &ElementForces, safety: f64) -> bool {
        if !self.are_active() {
            return true;
        }
        let was_synchronised = self.are_synchronised();
        self.on_grid = self.next_time().is_none_or(|next| next - time <= SAME_TIME * self.step);
        self.done += u32::from(self.on_grid);
        self.is_behind = false;
        for (intervals, chunk) in self.intervals.iter_mut().zip(&forces.chunks) {
            for (i, interval) in intervals.iter_mut().enumerate() {
                if chunk.evaluated & (1 << i) != 0 {
                    let stable = least(&chunk.batches[i].stable_step);
                    interval.stable = if was_synchronised { stable } else { stable.min(interval.stable) };
                }
                if interval.every == 1 {
                    interval.behind = 0.0;
                } else if self.on_grid && self.done.is_multiple_of(interval.every) {
                    // An element that has become stiffer is evaluated more often from now on.
                    interval.behind = interval.ahead;
                    let longest = SLOW * safety * interval.stable;
                    interval.set_every(power_of_two(longest / self.step, interval.every), self.step);
                }
                self.is_behind |= interval.behind > 0.0;
            }
        }
        self.done >= self.length
    }

    /// Ends a cycle, and prepares the next one where it is worthwhile. `touched` are the nodes of contacts.
    pub fn prepare(
        &mut self,
        (threads, forces): (&Threads, &mut ElementForces),
        (blocks, assembly): (&[ElementBlock], &Assembly),
        touched: impl Iterator<Item = u32>,
        limits: &CycleLimits,
    ) {
        // By the critical time steps of their neighbourhoods, and if that is worthwhile by strain.
        let stable = self.note_stable_steps(forces);
        let longest = (ROOM * limits.safety * stable).min(limits.longest);
        self.limit_by_neighbours(forces, (blocks, assembly), touched, stable);
        if self.work() <= WORTHWHILE {
            self.limit_strains(threads, forces, blocks, (SLOW_STRAIN * limits.strain, longest));
        }
        (self.length, self.longest) = (0, 0.0);
        if self.work() <= WORTHWHILE {
            self.longest = longest;
        }
        let is_prepared = self.longest > 0.0;
        for interval in self.intervals.iter_mut().flatten() {
            interval.set_every(if is_prepared { interval.every } else { 1 }, 0.0);
        }
    }

    /// Takes the critical time steps of the last evaluation, outside a cycle; returns the smallest of all [s].
    fn note_stable_steps(&mut self, forces: &ElementForces) -> f64 {
        let mut smallest = f64::INFINITY;
        for (intervals, chunk) in self.intervals.iter_mut().zip(&forces.chunks) {
            for (interval, totals) in intervals.iter_mut().zip(&chunk.batches) {
                if self.length == 0 {
                    interval.stable = least(&totals.stable_step);
                }
                smallest = smallest.min(interval.stable);
            }
        }
        smallest
    }

    /// Evaluations in a cycle over those in every step. Inactive elements count: whether there are any changes no bit.
    fn work(&self) -> f64 {
        let (mut work, mut all) = (0.0, 0.0);
        for interval in self.intervals.iter().flatten() {
            work += 1.0 / f64::from(interval.every);
            all += 1.0;
        }
        if all > 0.0 { work / all } else { 1.0 }
    }

    /// Limits strains from one evaluation to the next, in whole chunks: what is strained fast is so soon beside it, too.
    fn limit_strains(
        &mut self,
        threads: &Threads,
        forces: &mut ElementForces,
        blocks: &[ElementBlock],
        (limit, step): (f64, f64),
    ) {
        let longest = f64::from(LONGEST) * step;
        threads.for_each(&mut forces.chunks, |chunk| {
            chunk.rate = blocks[chunk.block as usize].rate_of_chunk(chunk, limit, longest);
        });
        for (chunk, intervals) in forces.chunks.iter().zip(&mut self.intervals) {
            for interval in intervals {
                interval.every = power_of_two(limit / (chunk.rate * step), interval.every);
            }
        }
    }

    /// Limits intervals by the shortest critical time step of an element and of those it shares nodes with: kicks at intervals resonate with
    /// the motion of nodes that stiff elements hold. Elements of `touched` nodes are evaluated in every step.
    fn limit_by_neighbours(
        &mut self,
        forces: &mut ElementForces,
        (blocks, assembly): (&[ElementBlock], &Assembly),
        touched: impl Iterator<Item = u32>,
        stable: f64,
    ) {
        let of_nodes = &mut forces.stable_steps;
        of_nodes.fill(f64::INFINITY);
        for (chunk, intervals) in forces.chunks.iter().zip(&self.intervals) {
            for (i, interval) in intervals.iter().enumerate() {
                for node in nodes_of_batch(blocks, chunk, i) {
                    of_nodes[node] = of_nodes[node].min(interval.stable);
                }
            }
        }
        touched.for_each(|node| of_nodes[node as usize] = 0.0);
        // The elements of a node that follows others act on these.
        for (node, masters) in assembly.followers().each() {
            for (master, _) in masters {
                of_nodes[*master as usize] = of_nodes[*master as usize].min(of_nodes[node as usize]);
            }
        }
        for (chunk, intervals) in forces.chunks.iter().zip(&mut self.intervals) {
            let block = &blocks[chunk.block as usize];
            let every_step = block.nodal_volumes.is_some() || block.parameters.memory.needs_every_step();
            for (i, interval) in intervals.iter_mut().enumerate() {
                let near = nodes_of_batch(blocks, chunk, i)
                    .fold(f64::INFINITY, |least, node| least.min(of_nodes[node]));
                // In shorter steps than the critical one all intervals are shorter.
                interval.every = if every_step { 1 } else { power_of_two(SLOW * near / stable, LONGEST) };
            }
        }
    }
}

/// Nodes of batch `i` of a chunk, in the numbering of the plan.
fn nodes_of_batch<'a>(
    blocks: &'a [ElementBlock],
    chunk: &ChunkForces,
    i: usize,
) -> impl Iterator<Item = usize> + 'a {
    let (block, number) = (&blocks[chunk.block as usize], chunk.chunk as usize);
    let nodes = block.nodes_of_chunk(number);
    let batch = block.chunks[number].batches.start as usize + i;
    block.nodes_of_batch(batch).as_flattened().iter().map(|node| nodes[usize::from(*node)] as usize)
}

fn least(row: &Row) -> f64 {
    row.0.iter().copied().fold(f64::INFINITY, f64::min)
}

impl ElementForces {
    /// Makes room for the impulses of elements that are not evaluated in every step.
    pub fn allow_subcycles(&mut self, node_count: usize) {
        for chunk in &mut self.chunks {
            chunk.impulse = vec![Vec3::zeros(); chunk.force.len()];
            chunk.viscous_impulse = vec![Vec3::zeros(); chunk.viscous.len()];
            chunk.change = vec![Vec3::zeros(); chunk.force.len()];
        }
        self.stable_steps = vec![f64::INFINITY; node_count];
    }

    /// Sum of the impulses of elements that are not evaluated in every step, at a node [N s].
    #[inline]
    pub fn impulse_at_node(&self, assembly: &Assembly, node: usize) -> Vec3 {
        assembly.sum_at(node, |chunk, i| self.chunks[chunk].impulse[i])
    }

    /// Sum of their forces times the difference of their intervals ahead and behind, at a node [N s].
    #[inline]
    pub fn change_at_node(&self, assembly: &Assembly, node: usize) -> Vec3 {
        assembly.sum_at(node, |chunk, i| self.chunks[chunk].change[i])
    }

    /// Sum of the impulses of their viscous forces at a node [N s].
    #[inline]
    pub fn viscous_impulse_at_node(&self, assembly: &Assembly, node: usize) -> Vec3 {
        assembly
            .sum_at(node, |chunk, i| self.chunks[chunk].viscous_impulse.get(i).copied().unwrap_or_default())
    }
}
