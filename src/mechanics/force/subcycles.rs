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
use super::chunk::Chunk;
use super::{Assembly, ElementForces, Threads};
use crate::lanes::Row;
use crate::tensor::Vec3;

/// Most steps between two evaluations of an element.
const LONGEST: u32 = 4;
/// Largest fraction of its critical time step in which an element is evaluated less often than the others [-]: the bound of
/// the element is that of the last evaluation, and kicks at intervals resonate with the motion of the nodes before the limit of stability.
const SLOW: f64 = 0.9;
/// What a step uses of the admissible one at the beginning of its cycle [-], so that it is not divided where elements become stiffer.
const ROOM: f64 = 0.95;
/// Times that differ by less than this fraction of a step are the same [-].
const SAME_TIME: f64 = 1e-6;
/// Fraction of the work of all elements above which all are evaluated in every step.
const WORTHWHILE: f64 = 0.75;

/// Times between the evaluations of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Steps of the cycle from one evaluation to the next, a power of two.
    every: u32,
    /// Time since the last evaluation [s]; 0 for the last step.
    behind: f64,
    /// Time to the next one [s]; 0 for the step to come.
    ahead: f64,
    /// Critical time step in the last evaluation [s].
    stable: f64,
}

impl Interval {
    const EVERY_STEP: Self = Self { every: 1, behind: 0.0, ahead: 0.0, stable: 0.0 };

    fn set_every(&mut self, every: u32, step: f64) {
        self.every = every;
        self.ahead = if every > 1 { f64::from(every) * step } else { 0.0 };
    }
}

/// The cycle that a run is in; part of its state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Subcycles {
    /// Number of steps, a power of two; 0 where all elements are evaluated in every step.
    length: u32,
    /// Those that are over.
    done: u32,
    /// Whether the time is that of the end of a step of the cycle: one that is too long is divided.
    on_grid: bool,
    /// Beginning [s].
    start: f64,
    /// Step [s].
    step: f64,
    /// Chunk by chunk.
    intervals: Vec<Vec<Interval>>,
}

/// What a new cycle has to keep to.
#[derive(Clone, Copy, Debug)]
pub struct CycleLimits {
    /// Time t_n [s].
    pub time: f64,
    /// Longest step [s].
    pub longest: f64,
    /// Time from t_n to the next one that must be met [s].
    pub remaining: f64,
    /// Fraction of the critical time step that is used [-].
    pub safety: f64,
    /// Largest strain of an element from one evaluation to the next [-].
    pub strain: f64,
}

impl Subcycles {
    /// Of the blocks of a plan: none of them is evaluated less often than the others.
    pub fn new(blocks: &[ElementBlock]) -> Self {
        let of_chunk = |chunk: &Chunk| vec![Interval::EVERY_STEP; chunk.batches.len()];
        let intervals = blocks.iter().flat_map(|block| block.chunks.iter().map(of_chunk)).collect();
        Self { intervals, ..Self::default() }
    }

    /// Whether some elements are evaluated less often than others.
    pub fn are_active(&self) -> bool {
        self.length > 0
    }

    /// Step of the cycle [s]; 0 outside one.
    pub fn step(&self) -> f64 {
        if self.are_active() { self.step } else { 0.0 }
    }

    /// Whether all elements are evaluated at t_n.
    pub fn are_synchronised(&self) -> bool {
        self.length == 0 || (self.on_grid && self.done == 0)
    }

    /// Time that the next step must not exceed [s]; `None` outside a cycle.
    pub fn next_time(&self) -> Option<f64> {
        self.are_active().then(|| self.start + f64::from(self.done + 1) * self.step)
    }

    /// What an evaluation at t_n reads; `last` is the step before [s].
    pub(super) fn of_chunk(&self, chunk: usize, last: f64) -> Option<ChunkCycle<'_>> {
        let intervals = self.intervals.get(chunk).filter(|_| self.are_active())?;
        let done = if self.on_grid { self.done } else { 1 };
        Some(ChunkCycle { intervals, done, last, next: self.step })
    }

    /// Goes on by a step that ends at `time` [s], after its evaluation. Returns whether the cycle is over.
    pub fn advance(&mut self, time: f64, forces: &ElementForces, safety: f64) -> bool {
        let Some(next) = self.next_time() else { return true };
        self.on_grid = next - time <= SAME_TIME * self.step;
        self.done += u32::from(self.on_grid);
        for (intervals, chunk) in self.intervals.iter_mut().zip(&forces.chunks) {
            for (i, interval) in intervals.iter_mut().enumerate() {
                if chunk.evaluated & (1 << i) != 0 {
                    interval.stable = least(&chunk.batches[i].stable_step);
                }
                if interval.every == 1 {
                    interval.behind = 0.0;
                } else if self.on_grid && self.done.is_multiple_of(interval.every) {
                    // An element that has become stiffer is evaluated more often from now on.
                    interval.behind = interval.ahead;
                    let longest = SLOW * safety * interval.stable;
                    interval.set_every(power_of_two(longest / self.step, interval.every), self.step);
                }
            }
        }
        self.done == self.length
    }

    /// Begins a new cycle where it is worthwhile, once the last one is over. `touched` are the nodes of contacts.
    pub fn begin(
        &mut self,
        (threads, forces): (&Threads, &mut ElementForces),
        (blocks, assembly): (&[ElementBlock], &Assembly),
        touched: impl Iterator<Item = u32>,
        limits: &CycleLimits,
    ) {
        // The step of all, and the most of them to the next time that must be met.
        let stable = self.note_stable_steps(forces);
        let longest = (ROOM * limits.safety * stable).min(limits.longest);
        let steps = (limits.remaining / longest - SAME_TIME).ceil().max(1.0);
        self.step = limits.remaining / steps;
        let most = power_of_two(steps, LONGEST);
        // By their critical time steps alone, and if that is worthwhile by strain and contact.
        let is_everything_behind = self.intervals.iter().flatten().all(|interval| interval.behind <= 0.0);
        for (chunk, intervals) in forces.chunks.iter().zip(&mut self.intervals) {
            let block = &blocks[chunk.block as usize];
            let every_step = block.nodal_volumes.is_some() || block.parameters.memory.softens();
            for interval in intervals {
                let longest = SLOW * limits.safety * interval.stable / self.step;
                interval.every = if every_step { 1 } else { power_of_two(longest, most) };
            }
        }
        let is_worthwhile = |cycle: &Self, forces: &ElementForces| cycle.work(forces) <= WORTHWHILE;
        if is_worthwhile(self, forces) {
            self.limit_strains(threads, forces, blocks, limits.strain);
            self.evaluate_at(assembly, blocks, touched);
        }
        if is_worthwhile(self, forces) {
            self.length = most;
        } else {
            // A last cycle of one step, for those that come from longer intervals.
            self.length = u32::from(!is_everything_behind);
            self.intervals.iter_mut().flatten().for_each(|interval| interval.every = 1);
        }
        let step = self.step;
        self.intervals.iter_mut().flatten().for_each(|interval| interval.set_every(interval.every, step));
        (self.start, self.done, self.on_grid) = (limits.time, 0, true);
    }

    /// Takes the critical time steps of the last evaluation; returns the smallest of active elements [s].
    fn note_stable_steps(&mut self, forces: &ElementForces) -> f64 {
        let mut smallest = f64::INFINITY;
        for (intervals, chunk) in self.intervals.iter_mut().zip(&forces.chunks) {
            for (i, interval) in intervals.iter_mut().enumerate() {
                if self.length == 0 {
                    interval.stable = least(&chunk.batches[i].stable_step);
                }
                if chunk.active & (1 << i) != 0 {
                    smallest = smallest.min(interval.stable);
                }
            }
        }
        smallest
    }

    /// Evaluations of active batches in the cycle, over those in every step.
    fn work(&self, forces: &ElementForces) -> f64 {
        let (mut work, mut all) = (0.0, 0.0);
        for (chunk, intervals) in forces.chunks.iter().zip(&self.intervals) {
            for (_, interval) in intervals.iter().enumerate().filter(|(i, _)| chunk.active & (1 << i) != 0) {
                work += 1.0 / f64::from(interval.every);
                all += 1.0;
            }
        }
        if all > 0.0 { work / all } else { 1.0 }
    }

    /// Limits strains from one evaluation to the next.
    fn limit_strains(
        &mut self,
        threads: &Threads,
        forces: &mut ElementForces,
        blocks: &[ElementBlock],
        limit: f64,
    ) {
        let longest = f64::from(LONGEST) * self.step;
        threads.for_each(&mut forces.chunks, |chunk| {
            for i in 0..chunk.batches.len() {
                let is_active = chunk.active & (1 << i) != 0;
                // Where the chunk as a whole is certain to be below the limit, no element is looked at.
                let looks = is_active && chunk.may_stretch_by(limit, longest);
                chunk.rates[i] =
                    if looks { blocks[chunk.block as usize].rate_of_batch(chunk, i) } else { 0.0 };
            }
        });
        for (chunk, intervals) in forces.chunks.iter().zip(&mut self.intervals) {
            for (interval, rate) in intervals.iter_mut().zip(&chunk.rates) {
                interval.every = power_of_two(limit / (rate * self.step), interval.every);
            }
        }
    }

    /// Evaluates the elements of these nodes in every step.
    fn evaluate_at(
        &mut self,
        assembly: &Assembly,
        blocks: &[ElementBlock],
        nodes: impl Iterator<Item = u32>,
    ) {
        let mut places: Vec<(u32, u32)> = Vec::new();
        for node in nodes {
            places.extend_from_slice(assembly.places(node as usize));
            for (master, _) in assembly.followers().masters(node as usize) {
                places.extend_from_slice(assembly.places(*master as usize));
            }
        }
        places.sort_unstable();
        places.dedup();
        for of_chunk in places.chunk_by(|a, b| a.0 == b.0) {
            let number = of_chunk[0].0;
            let Some((block, chunk)) = place_of(blocks, number as usize) else { continue };
            let first = block.chunks[chunk].batches.start as usize;
            for (i, interval) in self.intervals[number as usize].iter_mut().enumerate() {
                let nodes = block.nodes_of_batch(first + i).as_flattened();
                if nodes.iter().any(|node| of_chunk.binary_search(&(number, u32::from(*node))).is_ok()) {
                    interval.every = 1;
                }
            }
        }
    }
}

/// Block and chunk in it of a chunk over all blocks.
fn place_of(blocks: &[ElementBlock], number: usize) -> Option<(&ElementBlock, usize)> {
    let mut first = 0;
    for block in blocks {
        if number < first + block.chunk_count() {
            return Some((block, number - first));
        }
        first += block.chunk_count();
    }
    None
}

/// Largest power of two up to `value` and `most`; at least 1.
fn power_of_two(value: f64, most: u32) -> u32 {
    let mut power = most;
    while power > 1 && !(f64::from(power) <= value) {
        power /= 2;
    }
    power
}

fn least(row: &Row) -> f64 {
    row.0.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The cycle as a chunk sees it in one evaluation.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChunkCycle<'a> {
    intervals: &'a [Interval],
    done: u32,
    last: f64,
    next: f64,
}

impl ChunkCycle<'_> {
    /// Batches to evaluate, a bit each.
    pub fn due(&self) -> u32 {
        let is_due = |(_, interval): &(usize, &Interval)| self.done.is_multiple_of(interval.every);
        self.intervals.iter().enumerate().filter(is_due).map(|(i, _)| 1 << i).sum()
    }

    /// Time since the last evaluation of a batch [s].
    pub fn since(&self, batch: usize) -> f64 {
        let behind = self.intervals[batch].behind;
        if behind > 0.0 { behind } else { self.last }
    }

    /// Time over which the forces of a batch act at once [s]; `None` for those that act in every step.
    pub fn duration(&self, batch: usize) -> Option<f64> {
        let Interval { behind, ahead, .. } = self.intervals[batch];
        let ahead_or_next = if ahead > 0.0 { ahead } else { self.next };
        (behind > 0.0 || ahead > 0.0).then(|| 0.5 * (self.since(batch) + ahead_or_next))
    }
}

impl ElementForces {
    /// Makes room for the impulses of elements that are not evaluated in every step.
    pub fn allow_subcycles(&mut self) {
        for chunk in &mut self.chunks {
            chunk.impulse = vec![Vec3::zeros(); chunk.force.len()];
            chunk.viscous_impulse = vec![Vec3::zeros(); chunk.viscous.len()];
            chunk.rates = vec![0.0; chunk.batches.len()];
        }
    }

    /// Sum of the impulses of elements that are not evaluated in every step, at a node [N s].
    #[inline]
    pub fn impulse_at_node(&self, assembly: &Assembly, node: usize) -> Vec3 {
        assembly.sum_at(node, |chunk, i| self.chunks[chunk].impulse[i])
    }

    /// Sum of the impulses of their viscous forces at a node [N s].
    #[inline]
    pub fn viscous_impulse_at_node(&self, assembly: &Assembly, node: usize) -> Vec3 {
        assembly
            .sum_at(node, |chunk, i| self.chunks[chunk].viscous_impulse.get(i).copied().unwrap_or_default())
    }
}
