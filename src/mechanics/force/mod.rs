//! Internal forces of blocks of elements.
//!
//! A [`ElementBlock`] holds the elements of one body that share a law and a formulation, in batches of [`BATCH`] lanes,
//! structure of arrays. One dynamic call sweeps a block; everything inside is monomorphised for the law, the
//! formulation and the instruction set. Forces go to a buffer of element forces, which each node then sums in a fixed
//! order ([`Assembly`]): no two threads write to one place, and the bits do not depend on how many there are.

mod assembly;
mod block;
mod points;
mod rate;
mod sweep;
mod threads;

pub use assembly::Assembly;
pub use block::{BlockInput, BlockParameters, ElementBlock};
pub use points::{PointBatch, PointField, PointScalar};
pub use rate::largest_stretch_rate;
pub use sweep::{BatchTotals, SweepInput, SweepOutput};
pub use threads::{BlockTotals, Threads};

pub use super::lanes::BATCH;
