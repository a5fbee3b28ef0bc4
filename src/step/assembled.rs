//! When the bound of the critical time step by the assembled mesh is evaluated, and where it is kept.

use super::state::State;
use crate::mechanics::force::{AssembledBound, ElementForces, Threads};
use crate::plan::Plan;

/// Steps from one evaluation of the bound to the next: it costs about as much as the forces. More where the last one was no closer
/// than the elements alone.
const STEPS: u64 = 16;
const STEPS_WITHOUT_GAIN: u64 = 128;

/// The bound of a run, if any element has a mean dilatation. Its fractions are those of the state.
pub(super) struct AssembledStep<'p> {
    plan: &'p Plan,
    bound: Option<AssembledBound>,
}

impl<'p> AssembledStep<'p> {
    pub fn new(plan: &'p Plan) -> Self {
        let new = || AssembledBound::new(&plan.blocks, plan.node_count(), plan.bodies.len());
        Self { plan, bound: (!plan.fractions.is_empty()).then(new) }
    }

    /// Evaluates the bound where it is due, with the forces at t_n.
    pub fn evaluate(&mut self, threads: &Threads, forces: &ElementForces, state: &State) {
        if let Some(bound) = self.bound.as_mut().filter(|_| is_due(state)) {
            let Plan { blocks, assembly, own_inverse_mass, .. } = self.plan;
            bound.evaluate(threads, (blocks, assembly, own_inverse_mass), forces, &state.force_input());
        }
    }

    /// Hands the fractions of this step over to the next ones; before the step is counted.
    pub fn advance(&mut self, state: &mut State) {
        if let Some(bound) = self.bound.as_mut().filter(|_| is_due(state)) {
            bound.swap_fractions(&mut state.fractions);
        }
    }
}

fn is_due(state: &State) -> bool {
    let gains = || !AssembledBound::is_whole(&state.fractions);
    state.step.is_multiple_of(STEPS) && (state.step.is_multiple_of(STEPS_WITHOUT_GAIN) || gains())
}
