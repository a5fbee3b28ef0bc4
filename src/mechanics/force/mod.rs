//! Internal forces of blocks of elements.
//!
//! An [`ElementBlock`] holds the elements of one body that share a law and a formulation, in batches of [`BATCH`] lanes,
//! structure of arrays, and batches in chunks of a few hundred elements. The kind, the law and the formulation are matched once a chunk; everything inside
//! is monomorphised for them and the instruction set. A chunk sums its forces at its own nodes, and
//! each node then sums its few chunks in a fixed order ([`Assembly`]): no two threads write to one place, and the bits do
//! not depend on how many there are.

mod activity;
mod assembled_bound;
mod assembly;
mod block;
mod block_tangent;
mod branch_totals;
mod chunk;
mod conserving;
mod ellipticity;
mod erosion;
mod first_pass;
mod forces;
mod internal;
mod memory;
mod nodal_pressure;
mod nodal_volumes;
mod one_point;
mod packed;
mod parameters;
mod points;
mod pressure;
mod rate;
mod rate_stiffness;
mod reduced;
mod rows;
mod shear_viscosity;
mod stiffness;
mod totals;
mod viscous;

pub use crate::threads::Threads;
pub use activity::Activity;
pub use assembled_bound::AssembledBound;
pub use assembly::Assembly;
pub use block::{ElementBlock, NodeList};
pub use block_tangent::{BlockTangent, NodalTerm};
pub use branch_totals::BranchTotals;
pub use erosion::{Eroding, Erosion};
pub use forces::ElementForces;
pub use internal::{AssembledRows, ForceInput};
pub use parameters::{
    BlockError, BlockInput, BlockParameters, ErosionLimits, Formulation, MOST_SINGLE_RATIO,
};
pub use points::{PointBatch, PointField, PointInput, PointScalar};
pub use rate::stretch_rate;
pub use rate_stiffness::EndOfStep;
pub use stiffness::{CORNER_PAIRS, StiffnessBatch, corner_pair};
pub use totals::{BatchTotals, BlockTotals};

pub use super::lanes::BATCH;

#[cfg(test)]
mod tests;
