//! What a run costs, from a fixed table and never from a stopwatch, so that a scene always gets the same plan.
//!
//! Measured on one core of a virtual Intel Xeon (Sapphire Rapids family, AVX-512) with `cargo bench`: `element_kernels` for
//! the elements, `scenes` for the rest of a step.

use super::{Implicit, Integrator, Plan};
use crate::mechanics::force::{BlockParameters, ElementBlock, Formulation};
use crate::mechanics::material::Material;

/// Time of one element-step on one core [ns]: while the data of the elements lie in the cache, and when they do not.
type Nanoseconds = [f64; 2];

const MOONEY_RIVLIN_MEAN_DILATATION: Nanoseconds = [186.0, 246.0];
const MOONEY_RIVLIN_FULL: Nanoseconds = [204.0, 274.0];
const MOONEY_RIVLIN_REDUCED: Nanoseconds = [84.0, 156.0];
/// The matrix of Holzapfel–Gasser–Ogden and the coupled form are counted like the neo-Hookean law.
const NEO_HOOKEAN_MEAN_DILATATION: Nanoseconds = [167.0, 233.0];
const NEO_HOOKEAN_FULL: Nanoseconds = [196.0, 256.0];
const NEO_HOOKEAN_REDUCED: Nanoseconds = [83.0, 157.0];
/// Each family of fibres, on top of its neo-Hookean matrix.
const FIBRE_FAMILY: Nanoseconds = [48.0, 31.0];

/// The rest of a step [ns]: sums, ledger and measures for each node, contact for each node of a slave surface. What whole
/// runs of `ball_on_block` and `flashball_thigh` take beyond their elements, parted by estimate.
const NODE: f64 = 70.0;
const SLAVE_NODE: f64 = 350.0;

/// Iterations and matrices of an implicit step, about: what steps of impacts take that are as long as explicit ones.
const ITERATIONS: f64 = 4.0;
const MATRICES: f64 = 0.5;
/// Stiffness of an element and its place in the matrix [ns], speed of a factorisation [GFLOP/s], an entry of the factor in one
/// solution [ns], and in one of many at once as a share of that.
const STIFFNESS: f64 = 4000.0;
const FACTOR_GFLOPS: f64 = 20.0;
const FACTOR_ENTRY: f64 = 1.0;
const COLUMN: f64 = 0.15;
/// Share of the slave nodes that are candidates at a time, with as many master nodes.
const TOUCHED: f64 = 0.2;

/// Up to so many bytes the data of the elements lie in the cache.
const CACHE_BYTES: usize = 4_000_000;

/// Element-steps per second and core of a block in a plan whose sweep goes through so many bytes.
pub(super) fn element_steps_per_s(parameters: &BlockParameters, swept_bytes: usize) -> f64 {
    1e9 / element_ns(parameters)[usize::from(swept_bytes > CACHE_BYTES)]
}

/// Run time on one core [s] if every element is swept in every step, without recording.
pub(super) fn run_time_s(plan: &Plan, steps: u64, swept_bytes: usize) -> f64 {
    let element_s = |block: &ElementBlock| {
        block.elements.len() as f64 / element_steps_per_s(&block.parameters, swept_bytes)
    };
    let elements_s: f64 = plan.blocks.iter().map(element_s).sum();
    let slaves: usize = plan
        .contact
        .iter()
        .flat_map(|contact| contact.pairs.iter().map(|pair| contact.surfaces[pair.slave].nodes.len()))
        .sum();
    if let Integrator::Implicit(implicit) = &plan.integrator {
        return steps as f64 * implicit_step_s(plan, implicit, elements_s, slaves);
    }
    let rest_s = 1e-9 * (NODE * plan.node_count() as f64 + SLAVE_NODE * slaves as f64);
    steps as f64 * (elements_s + rest_s)
}

/// An implicit step: sweeps and solutions of every iteration, and its share of a matrix with factor and compliances.
fn implicit_step_s(plan: &Plan, implicit: &Implicit, elements_s: f64, slaves: usize) -> f64 {
    let size = &implicit.systems;
    let solution = 1e-9 * FACTOR_ENTRY * size.factor_entries as f64;
    let columns = 3.0 * TOUCHED * slaves as f64;
    let matrix = 1e-9 * (STIFFNESS * plan.element_count() as f64 + size.factor_flops / FACTOR_GFLOPS)
        + columns * solution * COLUMN;
    ITERATIONS * (elements_s + 2.0 * solution) + MATRICES * matrix
}

fn element_ns(parameters: &BlockParameters) -> Nanoseconds {
    let matrix = match (parameters.material, parameters.formulation) {
        (Material::MooneyRivlin(_), Formulation::MeanDilatation) => MOONEY_RIVLIN_MEAN_DILATATION,
        (Material::MooneyRivlin(_), Formulation::Full) => MOONEY_RIVLIN_FULL,
        (Material::MooneyRivlin(_), Formulation::Reduced) => MOONEY_RIVLIN_REDUCED,
        (_, Formulation::MeanDilatation) => NEO_HOOKEAN_MEAN_DILATATION,
        (_, Formulation::Full) => NEO_HOOKEAN_FULL,
        (_, Formulation::Reduced) => NEO_HOOKEAN_REDUCED,
    };
    let families = parameters.material.family_count() as f64;
    [0, 1].map(|i| matrix[i] + families * FIBRE_FAMILY[i])
}
