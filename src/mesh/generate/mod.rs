//! Generated meshes: balls, a baton, blocks and a limb segment, all of eight-node hexahedra.
//!
//! Each generator is a plain struct, as a scene document contains it. `problems` lists all parameters out of range, `generate` makes the
//! mesh or fails with the same list, `element_count` gives its size in advance, and `counts_mut` are the numbers that mesh studies
//! multiply.

pub mod block;
pub mod cylinder;
pub mod grading;
pub mod hollow_ball;
pub mod layered_block;
pub mod limb_segment;
pub mod solid_ball;

mod cubed_sphere;
mod ellipse;
mod generator;
mod o_grid;
mod parameters;

#[cfg(test)]
mod tests;

pub use generator::Generator;

/// Largest number of elements of a generated mesh: about 1 GB of mesh data.
pub const MAX_ELEMENTS: u64 = 10_000_000;

/// Name of the only part of a ball.
const BALL: &str = "ball";

/// A node set: the nodes, sorted and unique.
fn node_set(nodes: impl IntoIterator<Item = u32>) -> Vec<u32> {
    let mut set: Vec<u32> = nodes.into_iter().collect();
    set.sort_unstable();
    set.dedup();
    set
}

/// Note on the deviation of the facets from the true shape, "ball: faceted, 1.70 % below the exact volume 1.414e-5 m³".
fn faceting_note(part: &str, meshed_m3: f64, exact_m3: f64) -> String {
    let percent = 100.0 * (1.0 - meshed_m3 / exact_m3);
    let side = if percent < 0.0 { "above" } else { "below" };
    format!("{part}: faceted, {:.3} % {side} the exact volume {exact_m3:.6e} m³", percent.abs())
}
