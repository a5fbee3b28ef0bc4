//! Whether a list of contacts has one already that is detected again.

use super::finder::VALLEY;
use crate::contact::{Contact, Kind};

/// Whether `contacts` have one at the place of `candidate`; `rigid` are the rigid bodies of slave and master.
pub fn is_known(contacts: &[Contact], candidate: &Contact, rigid: [Option<u32>; 2]) -> bool {
    let is_same = |c: &Contact| match candidate.kind {
        // A mesh node has one contact per pair except in concave regions; a rigid body touches at several points.
        Kind::Node | Kind::Averaged => {
            matches!(c.kind, Kind::Node | Kind::Averaged | Kind::Side)
                && (rigid[0].is_none() || c.point == candidate.point)
        }
        Kind::Side => {
            matches!(c.kind, Kind::Node | Kind::Side) && c.frame[0].dot(&candidate.frame[0]) > VALLEY
        }
        // A rigid body may touch a face at several points.
        Kind::Fixed if rigid != [None; 2] => c.kind == candidate.kind && c.stencil == candidate.stencil,
        Kind::Fixed | Kind::Bulge | Kind::Guard => {
            c.kind == candidate.kind && c.stencil.nodes() == candidate.stencil.nodes()
        }
    };
    contacts.iter().any(|c| (c.pair, c.slave) == (candidate.pair, candidate.slave) && is_same(c))
}
