//! Position projection: penetration that linearisation left is removed by moving nodes and rigid bodies, without changing
//! velocities.

pub mod meshes;
pub mod rigid;
