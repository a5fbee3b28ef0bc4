//! Erosion of elements during a run, see [`Erosion`](crate::mechanics::force::Erosion).

use super::branches::Branches;
use super::contact::ContactStep;
use super::ledger::Ledger;
use super::state::State;
use crate::mechanics::force::{ElementForces, Threads};
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use std::sync::Arc;

/// Erodes the elements that the force evaluation at t_n has found beyond the limits of their parts, before the step `h`
/// [s] to t_{n+1} with the velocities `v_after` [m/s], nodes × 3. Their forces at t_n still act in that step: the
/// energy removed with them is their strain energy at t_n plus the work `½ h fᵀ v₊` of these forces. Energy in branches
/// of Prony series no longer counts as relaxed later.
pub(super) fn erode(
    plan: &Plan,
    (forces, threads): (&mut ElementForces, &Threads),
    (state, ledger, branches): (&mut State, &mut Ledger, &Branches),
    (h, v_after): (f64, &[Vec3]),
) {
    if !plan.erodes() {
        return;
    }
    let eroding = forces.find_eroding(threads, &plan.blocks);
    if eroding.is_empty() {
        return;
    }
    // Power of the internal forces at the nodes concerned, before erosion.
    let corners = |element: u32| {
        let body = &plan.bodies[plan.body_of_element(element)];
        body.cells.nodes((element - body.elements.start) as usize)
    };
    let mut nodes: Vec<u32> = eroding.iter().flat_map(|eroding| corners(eroding.element)).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let power = |forces: &ElementForces, node: u32| {
        forces.at_node(&plan.assembly, node as usize).dot(&v_after[node as usize])
    };
    let before: Vec<f64> = nodes.iter().map(|node| power(forces, *node)).collect();

    // Remove the elements and book their energies.
    let erosion = Arc::make_mut(&mut state.erosion);
    for element in &eroding {
        erosion.add(element, &plan.blocks);
        ledger.eroded[element.body] += element.energy;
        ledger.viscous[element.body] -= element.in_branches;
        for (index, energies) in element.branches.iter().enumerate() {
            if let Some(place) = branches.place(element.block, index) {
                ledger.branches[place] -= energies.stored;
            }
        }
    }
    // Reset without them: their history is as if they had never moved.
    erosion.forget(&plan.blocks, &mut state.history);
    // Internal forces without the eroded elements, and the work by which they differ.
    forces.take_out(erosion);
    let input = state.force_input();
    forces.evaluate(threads, &plan.blocks, &input);
    forces.add_viscous(threads, &plan.blocks, &input, &state.v);
    for (node, before) in nodes.into_iter().zip(before) {
        ledger.eroded[plan.body_of_node(node)] += 0.5 * h * (before - power(forces, node));
    }
}

/// Updates forces and contact to the state; `gone` is the number of eroded elements accounted for.
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
        contact.expose(plan, &state.erosion);
    }
}
