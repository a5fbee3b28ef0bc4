//! Sweeps in chunks, on one thread or on a pool: the same chunks, the same bits.

use super::block::ElementBlock;
use super::sweep::{BatchTotals, SweepInput, SweepOutput};
use super::{Assembly, BATCH, largest_stretch_rate};
use crate::mechanics::tensor::Vec3;
use rayon::prelude::*;

/// Batches that a thread takes at a time.
const CHUNK: usize = 16;
/// Nodes that a thread takes at a time.
const NODE_CHUNK: usize = 512;

/// The worker threads of one run.
#[derive(Debug)]
pub struct Threads {
    pool: Option<rayon::ThreadPool>,
}

impl Threads {
    /// A pool of `count` threads, or none at all for one.
    ///
    /// # Errors
    /// When the operating system gives no threads.
    pub fn new(count: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool =
            if count > 1 { Some(rayon::ThreadPoolBuilder::new().num_threads(count).build()?) } else { None };
        Ok(Self { pool })
    }

    /// Sweeps a whole block; `output` covers all of its batches.
    pub fn sweep(&self, block: &ElementBlock, input: &SweepInput, output: SweepOutput) {
        let Some(pool) = &self.pool else {
            return block.sweep(0, input, output);
        };
        let SweepOutput { force, dilatation, viscous_pressure, totals } = output;
        pool.install(|| {
            let slots = CHUNK * BATCH;
            force
                .par_chunks_mut(8 * slots)
                .zip(dilatation.par_chunks_mut(slots))
                .zip(viscous_pressure.par_chunks_mut(slots))
                .zip(totals.par_chunks_mut(CHUNK))
                .enumerate()
                .for_each(|(i, (((force, dilatation), viscous_pressure), totals))| {
                    block.sweep(
                        i * CHUNK,
                        input,
                        SweepOutput { force, dilatation, viscous_pressure, totals },
                    );
                });
        });
    }

    /// Internal force [N] of every node: `to[node] = Σ element forces`.
    pub fn assemble(&self, assembly: &Assembly, element_forces: &[Vec3], to: &mut [Vec3]) {
        let sum = |(chunk, to): (usize, &mut [Vec3])| {
            for (i, f) in to.iter_mut().enumerate() {
                *f = assembly.sum_at(chunk * NODE_CHUNK + i, element_forces);
            }
        };
        match &self.pool {
            Some(pool) => pool.install(|| to.par_chunks_mut(NODE_CHUNK).enumerate().for_each(sum)),
            None => to.chunks_mut(NODE_CHUNK).enumerate().for_each(sum),
        }
    }

    /// [`largest_stretch_rate`] over blocks. A maximum has no rounding, so its order is free.
    pub fn largest_stretch_rate(&self, blocks: &[ElementBlock], x: &[Vec3], v: &[Vec3]) -> f64 {
        let rate = |block: &ElementBlock, chunk: usize| {
            let end = ((chunk + 1) * CHUNK).min(block.batch_count());
            largest_stretch_rate(block, chunk * CHUNK..end, x, v)
        };
        let of_block = |block: &ElementBlock| {
            let chunks = block.batch_count().div_ceil(CHUNK);
            match &self.pool {
                Some(pool) => pool
                    .install(|| (0..chunks).into_par_iter().map(|c| rate(block, c)).reduce(|| 0.0, f64::max)),
                None => (0..chunks).map(|c| rate(block, c)).fold(0.0, f64::max),
            }
        };
        blocks.iter().map(of_block).fold(0.0, f64::max)
    }
}

/// The totals of a block as one: sums in slot order, extremes with their slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockTotals {
    /// Strain energy [J].
    pub strain: f64,
    /// Energy that bulk viscosity dissipated in the last step [J].
    pub viscous: f64,
    /// Smallest stable step [s] and its slot.
    pub stable_step: (f64, usize),
    /// Smallest J − 1 [-] and its slot.
    pub smallest_j: (f64, usize),
    /// Largest fibre exponent [-] and its slot.
    pub fibre_exponent: (f64, usize),
}

impl BlockTotals {
    /// Reduces the batches of a block in order.
    pub fn reduce(totals: &[BatchTotals]) -> Self {
        let mut sum = Self {
            strain: 0.0,
            viscous: 0.0,
            stable_step: (f64::INFINITY, 0),
            smallest_j: (f64::INFINITY, 0),
            fibre_exponent: (0.0, 0),
        };
        for (b, batch) in totals.iter().enumerate() {
            for lane in 0..BATCH {
                let slot = b * BATCH + lane;
                sum.strain += batch.strain[lane];
                sum.viscous += batch.viscous[lane];
                // Written so that a NaN wins: it must be seen, not skipped.
                if !(batch.stable_step[lane] >= sum.stable_step.0) {
                    sum.stable_step = (batch.stable_step[lane], slot);
                }
                if !(batch.smallest_j[lane] >= sum.smallest_j.0) {
                    sum.smallest_j = (batch.smallest_j[lane], slot);
                }
                if batch.fibre_exponent[lane] > sum.fibre_exponent.0 {
                    sum.fibre_exponent = (batch.fibre_exponent[lane], slot);
                }
            }
        }
        sum
    }
}
