//! The gaps of known contacts, measured again at new positions.

use super::narrow_phase::eval_proximity;
use super::surfaces::PairSurfaces;
use crate::contact::stencil::{Stencil, weighted};
use crate::contact::{ALLOWED, Contact, Kind};
use crate::tensor::Vec3;

/// Penetration that is not worth a correction, as a fraction of the face's size.
pub const TOLERANCE: f64 = 1e-8;

/// A negative gap at new positions.
pub struct Penetration {
    /// Depth to be removed [m].
    pub depth: f64,
    /// Unit normal from the master to the slave, along which the gap opens.
    pub normal: Vec3,
    /// The nodes of both sides with their weights at the new positions.
    pub stencil: Stencil,
    /// Size of the face [m].
    pub size: f64,
}

/// The gap of a contact of the step at new positions `x` [m], if it is negative: for the same node and face, or with the same
/// weights. A node that has slid off its face is left to the next detection.
pub fn penetration(contact: &Contact, surfaces: &PairSurfaces, x: &[Vec3]) -> Option<Penetration> {
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
    if let Some((point, normal, size)) = surfaces.plane(contact.pair as usize) {
        return found(-normal.dot(&(s - point)), normal, size, &same);
    }
    if contact.kind == Kind::Guard {
        return guard_penetration(contact, surfaces, x);
    }
    let boundary = surfaces.master(contact.pair as usize)?;
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
fn guard_penetration(contact: &Contact, surfaces: &PairSurfaces, x: &[Vec3]) -> Option<Penetration> {
    let boundary = surfaces.slave(contact.pair as usize);
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
