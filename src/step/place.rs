//! Positions of the contact surfaces.

use super::phase::Phase;
use super::state::State;
use crate::mechanics::contact::Surface;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;

/// Absolute positions x_n [m] of the current contact surfaces, into `x`.
pub(super) fn place_surfaces(
    plan: &Plan,
    surfaces: &[Surface],
    (state, phase): (&State, Phase),
    x: &mut [Vec3],
) {
    let bodies = plan.contact.iter().flat_map(|contact| &contact.surface_body);
    for (surface, &body) in surfaces.iter().zip(bodies) {
        let time = if phase.flies() { state.time } else { 0.0 };
        let flight = plan.bodies[body].flight_velocity * time;
        for node in surface.nodes.iter().map(|node| *node as usize) {
            x[node] = plan.X[node] + flight + state.u[node];
        }
    }
}
