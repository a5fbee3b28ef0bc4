//! Removes negative gaps of rigid bodies that remain after linearisation: by translation and rotation, outside the
//! velocities, with a limit.
//!
//! All contacts at the new positions at once: the smallest displacement d, in the norm of the masses, after which no
//! gap is negative,
//!
//! ```text
//! min ½ dᵀ M d   with   g + C d ≥ 0
//! ```
//!
//! That is the frictionless law of [`crate::contact::solution::gauss_seidel`] with gaps in the place of velocities, so its solver is
//! used: corners of one face do not lift each other in turn, and open gaps are unaffected.

use super::meshes::{CAP, MovableNodes};
use crate::contact::detection::detector::Motion;
use crate::contact::detection::detectors::Detectors;
use crate::contact::detection::penetration::TOLERANCE;
use crate::contact::solution::gauss_seidel::{Options, Workspace, solve_with_rigid};
use crate::contact::{Contact, Reaction, RigidSides};
use crate::rigid::{Pose, rotated};
use crate::tensor::Vec3;

/// A correction need not be exact: the next step removes the remainder.
const OPTIONS: Options = Options { tolerance: 1e-6, max_sweeps: 200, acceptable: 0.0 };

/// Buffers of the projection, kept from step to step.
pub struct RigidProjection {
    contacts: Vec<Contact>,
    /// Displacement of each node [m], and rotation of each spin node [rad]; zero between calls.
    d: Vec<Vec3>,
    reactions: Vec<Reaction>,
    workspace: Workspace,
}

impl RigidProjection {
    /// For so many nodes, and at most so many contacts.
    pub fn new(nodes: usize, contacts: usize) -> Self {
        Self {
            contacts: Vec::with_capacity(contacts),
            d: vec![Vec3::zeros(); nodes],
            reactions: Vec::with_capacity(contacts),
            workspace: Workspace::with_capacity(0, contacts),
        }
    }

    /// Separates what overlaps at the positions `x` [m] and `poses` by translation and rotation. `sides`: the rigid bodies,
    /// whatever their poses in it; `nodes`: mobility of the nodes of meshes; `fraction`: fraction of [`CAP`] that may be removed
    /// [-]. Appends each node's displacement (node, Δx [m]) to `moved`.
    pub fn project(
        &mut self,
        detectors: &mut Detectors,
        sides: &RigidSides,
        (nodes, fraction): (MovableNodes, f64),
        x: &mut [Vec3],
        poses: &mut [Pose],
        moved: &mut Vec<(u32, Vec3)>,
    ) {
        let motion = Motion { x, x_end: x, poses, poses_end: poses };
        // Positions that are not finite are reported by the next step.
        if detectors.detect_rigid(&motion, &mut self.contacts).is_err() {
            return;
        }
        for contact in &mut self.contacts {
            // The step has rejected stencils with too many nodes.
            if let Some(stencil) = contact.stencil.without(nodes.followers) {
                contact.stencil = stencil;
            }
        }
        // The smallest thickness of a rigid body, and the mean size of the faces of a mesh: corrections are small against both.
        let bodies = sides.bodies;
        let size = |contact: &Contact| {
            let of_pair = sides.of_pair(contact.pair).into_iter().flatten();
            of_pair.map(|body| bodies[body as usize].shape.size()).fold(f64::INFINITY, f64::min)
        };
        let length = |contact: &Contact| match sides.of_pair(contact.pair)[0] {
            Some(_) => size(contact),
            None => size(contact).min(detectors.surfaces().slave(contact.pair as usize).mean_size),
        };
        for contact in &mut self.contacts {
            contact.gap += contact.kind.kept * length(contact);
        }
        if self.contacts.iter().all(|contact| contact.gap >= -TOLERANCE * size(contact)) {
            return;
        }
        // Gaps, limited by the cap, take the place of velocities.
        for contact in &mut self.contacts {
            let cap = contact.kind.pace * CAP;
            let gap = contact.gap.max(-fraction * cap * length(contact));
            contact.drift = contact.frame[0] * gap;
            contact.gap = 0.0;
        }
        let rigid = RigidSides { poses, ..*sides };
        let Self { contacts, d, reactions, workspace, .. } = self;
        solve_with_rigid(contacts, &rigid, nodes.inverse_mass, 1.0, d, reactions, &OPTIONS, workspace);
        // Apply the displacements and rotations.
        for contact in &self.contacts {
            for &node in contact.stencil.nodes() {
                let step = std::mem::replace(&mut self.d[node as usize], Vec3::zeros());
                if step != Vec3::zeros() {
                    nodes.shift((node, step), x, moved);
                }
            }
        }
        for (pose, body) in poses.iter_mut().zip(bodies) {
            let turn = std::mem::replace(&mut self.d[body.spin as usize], Vec3::zeros());
            pose.orientation = rotated(&pose.orientation, &turn, 1.0);
            pose.centre = x[body.centre as usize];
        }
    }
}
