//! Removes negative gaps that remain after linearisation, by moving nodes: outside the velocities, with a limit.
//!
//! The end-of-step law is linear in the velocities, so after the step the true gap may be negative by O(h²). Removing
//! it by velocities (`v⁺ = −g/h`) would eject the node. Instead the nodes of the contact are moved apart along its
//! normal, each in proportion to its inverse mass, so that the centre of mass stays; fixed axes do not move.

use crate::contact::ALLOWED;
use crate::contact::detection::detector::Detector;
use crate::contact::detection::narrow_phase::eval_proximity;
use crate::contact::stencil::{Stencil, weighted};
use crate::contact::{Contact, Kind};
use crate::followers::Followers;
use crate::tensor::Vec3;

/// Largest correction of a contact in a step of usual length, as a fraction of the face's size, and less in a shorter
/// step, as where elements are crushed: more, within a fraction of a microsecond, would be an impact of its own.
pub const CAP: f64 = 0.005;
/// Fraction of this cap for places between nodes, which may begin to touch at any depth.
pub const SLOW: f64 = 0.1;
/// Penetration that is left uncorrected, as a fraction of the face's size.
pub const TOLERANCE: f64 = 1e-8;
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
    detector: &Detector,
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
            let Some(found) = penetration(contact, detector, x) else { continue };
            report.left = report.left.max(found.depth);
            let slow = if contact.kind == Kind::Fixed { SLOW } else { 1.0 };
            let cap = slow * fraction * CAP / PASSES as f64 * found.size;
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

/// A negative gap, with the stencil and normal along which it is opened.
struct Penetration {
    depth: f64,
    normal: Vec3,
    stencil: Stencil,
    size: f64,
}

fn penetration(contact: &Contact, detector: &Detector, x: &[Vec3]) -> Option<Penetration> {
    let s = &x[contact.slave as usize];
    // Most contacts are open: weights are gathered only for the others.
    let found = |depth: f64, normal: Vec3, size: f64, stencil: &dyn Fn() -> Stencil| {
        (depth > TOLERANCE * size).then(|| Penetration { depth, normal, stencil: stencil(), size })
    };
    let same = || contact.stencil.clone();
    // Surfaces that bulge towards each other cross before anything detects it; moving them apart would do work.
    if contact.kind == Kind::Bulge {
        return None;
    }
    // The obstacle at the new positions: plane, master node in a slave face, fixed weights, or face.
    if let Some((point, normal, size)) = detector.plane(contact.pair as usize) {
        return found(-normal.dot(&(s - point)), normal, size, &same);
    }
    if contact.kind == Kind::Guard {
        return guard_penetration(contact, detector, x);
    }
    let boundary = detector.master_boundary(contact.pair as usize)?;
    let size = boundary.sizes[contact.face as usize];
    if !matches!(contact.kind, Kind::Node | Kind::Side) {
        let normal = contact.frame[0];
        let depth = -normal.dot(&contact.stencil.difference(x));
        // Two edges may keep what linearisation leaves, up to twice the allowed penetration of a node: from step to
        // step they cross elsewhere and along another normal, and pushing them out each time would do work without
        // end.
        let left = if contact.kind == Kind::Fixed { 2.0 * ALLOWED * size } else { 0.0 };
        return found(depth - left, normal, size, &same);
    }
    let p = eval_proximity(boundary, contact.face, s, x)?;
    // Slid off the face: the next detection finds its new face.
    if p.beyond {
        return None;
    }
    let face = &boundary.faces[contact.face as usize];
    found(-p.gap, p.normal, size, &|| Stencil::node_on_face(contact.slave, face, &p.weights))
}

/// Penetration of a master node into a slave face, beyond the allowed depth.
fn guard_penetration(contact: &Contact, detector: &Detector, x: &[Vec3]) -> Option<Penetration> {
    let boundary = detector.slave_boundary(contact.pair as usize);
    // The node of the master, or those that it follows.
    let node = contact.stencil.side(true);
    let place = weighted(node.clone(), |n| x[n as usize]);
    let size = boundary.sizes[contact.face as usize];
    let p = eval_proximity(boundary, contact.face, &place, x).filter(|p| !p.beyond)?;
    let depth = -p.gap - ALLOWED * size;
    let of_face = boundary.faces[contact.face as usize].into_iter().zip(p.weights);
    let stencil = Stencil::new(of_face, node)?;
    (depth > TOLERANCE * size).then_some(Penetration { depth, normal: -p.normal, stencil, size })
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
