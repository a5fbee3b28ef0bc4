//! Elements that are given up on the way, see [`Erosion`](crate::mechanics::force::Erosion).

use super::contact::ContactStep;
use super::state::State;
use crate::mechanics::force::{ElementForces, Threads};
use crate::plan::Plan;
use std::sync::Arc;

/// Gives up the elements that the sweep at t_n has found beyond what their parts bear: from t_{n+1} on they are gone. `state` has the
/// history of that sweep.
pub(super) fn erode(plan: &Plan, forces: &mut ElementForces, threads: &Threads, state: &mut State) {
    if !plan.erodes() {
        return;
    }
    let eroding = forces.find_eroding(threads, &plan.blocks);
    if eroding.is_empty() {
        return;
    }
    let erosion = Arc::make_mut(&mut state.erosion);
    for element in &eroding {
        erosion.add(element, &plan.blocks);
        state.ledger.eroded[element.body] += element.energy;
    }
    erosion.forget(&plan.blocks, &mut state.history);
}

/// Has forces and contact follow the state; `gone` is how many elements they know to be gone.
pub(super) fn follow<'p>(
    plan: &'p Plan,
    state: &State,
    gone: &mut usize,
    forces: &mut ElementForces,
    contact: Option<&mut ContactStep<'p>>,
) {
    let now = state.erosion.elements().len();
    if now == *gone {
        return;
    }
    *gone = now;
    forces.take_out(&state.erosion);
    if let Some(contact) = contact {
        contact.lay_bare(plan, &state.erosion);
    }
}
