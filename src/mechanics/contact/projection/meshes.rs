//! Removes negative gaps that remain after linearisation, by moving nodes: outside the velocities, with a limit.
//!
//! The end-of-step law is linear in the velocities, so after the step the true gap may be negative by O(h²). Removing
//! it by velocities (`v⁺ = −g/h`) would eject the node. Instead the nodes of the contact are moved apart along its
//! normal, each in proportion to its inverse mass, so that the centre of mass stays; fixed axes do not move.

use crate::contact::Contact;
use crate::contact::detection::penetration::{Penetration, penetration};
use crate::contact::detection::surfaces::PairSurfaces;
use crate::followers::Followers;
use crate::tensor::Vec3;

/// Largest correction of a contact in a step of usual length, as a fraction of the face's size, and less in a shorter
/// step, as where elements are crushed: more, within a fraction of a microsecond, would be an impact of its own.
pub const CAP: f64 = 0.005;
/// Passes over the contacts, which have nodes in common.
const PASSES: usize = 4;

/// Mobility of the nodes.
#[derive(Clone, Copy)]
pub struct MovableNodes<'a> {
    /// 1/m [1/kg] per node and axis.
    pub inverse_mass: &'a [Vec3],
    /// Nodes that follow others, without inertia of their own.
    pub followers: &'a Followers,
}

impl MovableNodes<'_> {
    /// Moves a node by `step` [m], and its followers by their weights.
    pub(super) fn shift(self, (node, step): (u32, Vec3), x: &mut [Vec3], moved: &mut Vec<(u32, Vec3)>) {
        x[node as usize] += step;
        moved.push((node, step));
        for (follower, w) in self.followers.led_by(node as usize) {
            x[*follower as usize] += step * *w;
            moved.push((*follower, step * *w));
        }
    }
}

/// Result of a projection.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProjectionReport {
    /// Contacts that were moved apart.
    pub corrected: usize,
    /// The deepest penetration before [m], zero if there was none.
    pub deepest: f64,
    /// The deepest penetration found by the last pass [m].
    pub left: f64,
}

/// Moves the nodes of penetrating `contacts` apart, at the positions `x` [m] of the end of the step.
///
/// Gaps are measured again, for the same node and face or with the same weights; a node that has slid off its face is
/// left to the next detection. `fraction` is the fraction of [`CAP`] that may be removed [-]. `moved` is cleared and
/// receives each displacement (node, Δx [m]), a node possibly more than once, so that its work against the internal
/// forces can be accounted for.
pub fn project_positions(
    contacts: &[Contact],
    surfaces: &PairSurfaces,
    (nodes, fraction): (MovableNodes, f64),
    x: &mut [Vec3],
    moved: &mut Vec<(u32, Vec3)>,
) -> ProjectionReport {
    moved.clear();
    let mut report = ProjectionReport::default();
    for pass in 0..PASSES {
        report.left = 0.0;
        let mut corrected = 0;
        for contact in contacts {
            let Some(found) = penetration(contact, surfaces, x) else { continue };
            report.left = report.left.max(found.depth);
            let cap = contact.kind.pace * fraction * CAP / PASSES as f64 * found.size;
            if separate(&found, found.depth.min(cap), nodes, x, moved) {
                corrected += 1;
            }
        }
        if pass == 0 {
            report.deepest = report.left;
            report.corrected = corrected;
        }
        if corrected == 0 {
            break;
        }
    }
    report
}

/// Opens the gap by `distance`; returns whether anything could move.
fn separate(
    found: &Penetration,
    distance: f64,
    movable: MovableNodes,
    x: &mut [Vec3],
    moved: &mut Vec<(u32, Vec3)>,
) -> bool {
    let (n, inverse_mass) = (&found.normal, movable.inverse_mass);
    // Detection has rejected stencils with too many nodes.
    let Some(stencil) = found.stencil.without(movable.followers) else { return false };
    let nodes = stencil.each();
    let compliance: f64 =
        nodes.clone().map(|(node, w)| w * w * inverse_mass[node as usize].component_mul(n).dot(n)).sum();
    let impulse = distance / compliance;
    if !impulse.is_finite() {
        return false;
    }
    for (node, w) in nodes {
        let step = inverse_mass[node as usize].component_mul(n) * (w * impulse);
        if step != Vec3::zeros() {
            movable.shift((node, step), x, moved);
        }
    }
    true
}

#[cfg(test)]
mod tests;
