//! Penetrations that slave nodes against master faces miss: master nodes in slave faces, and crossing edges.
//!
//! - *A master node* may lie inside the slave by [`ALLOWED`] of a face and no deeper. Where the slave's nodes are
//!   close together they keep it out by themselves, and this constrains nothing; between nodes that are far apart, or
//!   at a corner of the master, it is what holds.
//! - *Two edges*, one of each surface and at least one of them sharp, are held against each other between their ends.
//!
//! Both are found as slave nodes are, where they move far by their time of impact: nothing tunnels.

use super::detector::{DetectionError, Detector, Motion};
use super::edges::EdgeFinder;
use super::frame::local_frame;
use super::node_to_face::NodeToFace;
use super::surfaces::PairSurfaces;
use crate::contact::kind::{Gap, Identity, Kind};
use crate::contact::stencil::Stencil;
use crate::contact::{ALLOWED, Contact, ContactLaw};
use crate::tensor::Vec3;
use crate::threads::Threads;

/// Shape function of a node above which a place on a face coincides with that node.
const AT_NODE: f64 = 0.999;

/// A master node against a face of the slave, which it may enter to the allowed depth: its gap is measured from there.
const MASTER_NODE: Kind = Kind { gap: Gap::ToSlave, kept: ALLOWED, identity: Identity::Nodes, ..Kind::NODE };

/// Finds the contacts of master nodes and of edges.
pub struct Guard {
    /// Finds the contacts of the pairs with slave and master exchanged.
    reversed: NodeToFace,
    /// Number of each of its listed pairs in the original list, and of the first of the others.
    listed: Vec<usize>,
    first_unlisted: usize,
    edges: EdgeFinder,
    found: Vec<Contact>,
}

impl Guard {
    /// For the pairs of two different meshes; `x` [m] are the positions of all nodes at the start of the run. A smooth edge
    /// whose angle grows by `bent` [rad] is sharp.
    pub fn new(surfaces: &PairSurfaces, bent: f64, x: &[Vec3]) -> Self {
        let (pairs, listed) = surfaces.pairs.exchanged();
        let slaves = pairs.listed().map(|(_, pair)| pair.slave).chain(pairs.every_two().surfaces());
        let most = slaves.map(|slave| surfaces.boundaries[slave].nodes.len()).sum();
        let reversed = surfaces.in_pairs(pairs);
        Self {
            edges: EdgeFinder::new(&reversed, x, bent),
            reversed: NodeToFace::of(reversed, x).with_one_face_per_node(),
            found: Vec::with_capacity(most),
            first_unlisted: surfaces.pairs.unlisted().start,
            listed,
        }
    }

    /// Searches long lists on several threads.
    #[must_use]
    pub fn on(self, threads: &Threads) -> Self {
        Self { reversed: self.reversed.on(threads), ..self }
    }
}

impl Detector for Guard {
    fn detect(&mut self, motion: &Motion, contacts: &mut Vec<Contact>) -> Result<(), DetectionError> {
        let before = contacts.len();
        // Master nodes that close against slave faces, to the allowed depth.
        let is_held = |pair: u32, slave: u32, contacts: &[Contact]| {
            contacts[..before].binary_search_by_key(&(pair, slave), |c| (c.pair, c.slave)).is_ok()
        };
        self.found.clear();
        self.reversed.detect(motion, &mut self.found)?;
        let number = |pair: u32| {
            let unlisted = (pair as usize).saturating_sub(self.listed.len()) + self.first_unlisted;
            self.listed.get(pair as usize).map_or(unlisted, |number| *number) as u32
        };
        for found in &self.found {
            let pair = number(found.pair);
            let face_size = self
                .reversed
                .surfaces()
                .master(found.pair as usize)
                .map(|boundary| boundary.sizes[found.face as usize]);
            let gap = found.gap + ALLOWED * face_size.unwrap_or(0.0);
            let change = |(node, w): (u32, f64)| (motion.x_end[node as usize] - motion.x[node as usize]) * w;
            let closing = found.frame[0].dot(&found.stencil.each().map(change).sum::<Vec3>());
            if gap.min(gap + closing) > 0.0 {
                continue;
            }
            // A slave node with a contact of its own makes this one redundant.
            let new = exchanged_contact(found, pair, gap);
            contacts.extend(new.filter(|new| !(is_at_node(found) && is_held(pair, new.slave, contacts))));
        }
        // Edges against edges.
        self.edges.detect(&self.reversed, number, motion, contacts);
        Ok(())
    }
}

/// Whether the place on the slave's face is one of its nodes.
fn is_at_node(found: &Contact) -> bool {
    found.stencil.master().any(|(_, w)| -w > AT_NODE)
}

/// The contact in terms of the original pair: the nodes of the face are its slave side. `None` for a face without
/// weights.
fn exchanged_contact(found: &Contact, pair: u32, gap: f64) -> Option<Contact> {
    let of_face = || found.stencil.master().map(|(node, w)| (node, -w));
    let heaviest = of_face().fold((0, 0.0), |best, (node, w)| if w > best.1 { (node, w) } else { best });
    Some(Contact {
        pair,
        kind: MASTER_NODE,
        slave: heaviest.0,
        face: found.face,
        stencil: Stencil::new(of_face(), [(found.slave, 1.0)])?,
        frame: local_frame(&-found.frame[0], &found.frame[1]),
        gap,
        point: found.point,
        drift: Vec3::zeros(),
        law: ContactLaw::Frictionless,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests;
