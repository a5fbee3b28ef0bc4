//! Estimated run time of a plan, from the scene's table of costs.

use super::compiled::Plan;
use super::contact_plan::ContactPlan;
use super::integrator::Integrator;
use crate::mechanics::contact::Master;
use crate::mechanics::force::ElementBlock;
use crate::scene::cost::{FactorSize, StepLoad, element_s};

/// Element-steps per second and core of a block in a plan whose evaluation goes through so many bytes.
pub(super) fn element_steps_per_s(block: &ElementBlock, evaluated_bytes: usize) -> f64 {
    let parameters = &block.parameters;
    1.0 / element_s(
        &parameters.material,
        (block.kind, parameters.formulation),
        [parameters.shear_viscosity > 0.0, parameters.has_memory()],
        evaluated_bytes,
    )
}

/// Run time on one core [s] if every element is evaluated in every step, without recording.
pub(super) fn run_time_s(plan: &Plan, steps: u64, evaluated_bytes: usize) -> f64 {
    let evaluate =
        |block: &ElementBlock| block.elements.len() as f64 / element_steps_per_s(block, evaluated_bytes);
    // Without folds, the search for self-contact costs almost nothing.
    let slaves = |contact: &ContactPlan| {
        let nodes = |surface: usize| contact.surfaces[surface].nodes.len();
        let listed = contact.pairs.listed().filter(|(_, pair)| pair.master != Master::Surface(pair.slave));
        listed.map(|(_, pair)| nodes(pair.slave)).sum::<usize>()
            + contact.pairs.every_two().surfaces().map(nodes).sum::<usize>()
    };
    let load = StepLoad {
        elements: plan.element_count(),
        forces_s: plan.blocks.iter().map(evaluate).sum(),
        nodes: plan.node_count(),
        slaves: plan.contact.as_ref().map_or(0, slaves),
    };
    let step_s = match &plan.integrator {
        Integrator::Explicit(_) => load.explicit_step_s(),
        Integrator::Implicit(implicit) => load.implicit_step_s(&FactorSize {
            entries: implicit.systems.factor_entries as f64,
            flops: implicit.systems.factor_flops,
        }),
    };
    steps as f64 * step_s
}
