//! A surface against its mirror image in a plane of symmetry where it ends: both move alike, so each node meets the plane, without friction.

use super::boundary::Boundary;
use super::detector::Motion;
use super::frame::local_frame;
use super::narrow_phase::NEAR;
use crate::contact::kind::{Gap, Identity, Kind};
use crate::contact::stencil::Stencil;
use crate::contact::{Contact, ContactLaw};
use crate::tensor::Vec3;

/// A node against the plane, which is flat: linearisation leaves nothing to project.
const IMAGE: Kind =
    Kind { gap: Gap::NotMeasured, has_friction: false, identity: Identity::Normal, ..Kind::NODE };

/// Appends the contacts of a surface with its mirror images, as contacts of the pair of the surface with itself.
pub(super) fn meet_images(boundary: &Boundary, pair: u32, motion: &Motion, contacts: &mut Vec<Contact>) {
    for (axis, on_plane) in boundary.mirrors.iter().enumerate() {
        let Some(on_plane) = on_plane else { continue };
        // Its nodes are held.
        let at = motion.x[*on_plane as usize][axis];
        let normal = Vec3::ith(axis, 1.0);
        let near = |node: &u32| {
            let [start, end] = [motion.x, motion.x_end].map(|x| x[*node as usize][axis] - at);
            start.min(end) <= NEAR * boundary.mean_size
        };
        contacts.extend(boundary.nodes_off(axis).filter(near).map(|slave| Contact {
            pair,
            kind: IMAGE,
            slave,
            face: u32::MAX,
            stencil: Stencil::of_node(slave),
            frame: local_frame(&normal, &Vec3::zeros()),
            gap: motion.x[slave as usize][axis] - at,
            point: motion.x[slave as usize],
            drift: Vec3::zeros(),
            law: ContactLaw::Frictionless,
        }));
    }
}
