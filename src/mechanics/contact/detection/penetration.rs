//! The gaps of known contacts, measured again at new positions.

use super::boundary::Boundary;
use super::narrow_phase::eval_proximity;
use super::surfaces::PairSurfaces;
use crate::contact::Contact;
use crate::contact::kind::Gap;
use crate::contact::stencil::{Stencil, weighted};
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

/// The gap of a contact of the step at new positions `x` [m], if it is negative beyond what the contact may keep, measured as its
/// kind says. A node that has slid off its face is left to the next detection.
pub fn penetration(contact: &Contact, surfaces: &PairSurfaces, x: &[Vec3]) -> Option<Penetration> {
    let pair = contact.pair as usize;
    let node = contact.slave;
    // Most contacts are open: weights are gathered only for the others.
    let found = |gap: f64, normal: Vec3, size: f64, stencil: &dyn Fn() -> Option<Stencil>| {
        let depth = -gap - contact.kind.kept * size;
        let is_deep = depth > TOLERANCE * size;
        is_deep.then(stencil).flatten().map(|stencil| Penetration { depth, normal, stencil, size })
    };
    let on_face = |boundary: &Boundary, place: &Vec3| {
        let size = boundary.sizes[contact.face as usize];
        let proximity = eval_proximity(boundary, contact.face, place, x).filter(|p| !p.beyond)?;
        Some((proximity, boundary.faces[contact.face as usize], size))
    };
    let same = || Some(contact.stencil.clone());
    match contact.kind.gap {
        Gap::NotMeasured => None,
        Gap::ConstantWeights => {
            let size = surfaces.master(pair)?.sizes[contact.face as usize];
            let normal = contact.frame[0];
            found(normal.dot(&contact.stencil.difference(x)), normal, size, &same)
        }
        Gap::ToMaster => {
            let s = &x[node as usize];
            if let Some((point, normal, size)) = surfaces.plane(pair) {
                return found(normal.dot(&(s - point)), normal, size, &same);
            }
            let (p, face, size) = on_face(surfaces.master(pair)?, s)?;
            found(p.gap, p.normal, size, &|| Some(Stencil::node_on_face(node, &face, &p.weights)))
        }
        Gap::ToSlave => {
            // The node of the master, or those that it follows.
            let master = || contact.stencil.side(true);
            let (p, face, size) = on_face(surfaces.slave(pair), &weighted(master(), |n| x[n as usize]))?;
            let of_face = || face.into_iter().zip(p.weights);
            found(p.gap, -p.normal, size, &|| Stencil::new(of_face(), master()))
        }
    }
}
