//! Whether a list of contacts has one already that is detected again.

use super::finder::VALLEY;
use crate::contact::Contact;
use crate::contact::kind::Identity;

/// Whether `contacts` have one that is the same as `candidate`, by the candidate's [`Identity`].
pub fn is_known(contacts: &[Contact], candidate: &Contact) -> bool {
    let is_of_node = |c: &Contact| matches!(c.kind.identity, Identity::Node | Identity::Normal);
    let is_of_kind = |c: &Contact| c.kind == candidate.kind;
    let is_same = |c: &Contact| match candidate.kind.identity {
        Identity::Node => is_of_node(c),
        Identity::Normal => is_of_node(c) && c.frame[0].dot(&candidate.frame[0]) > VALLEY,
        Identity::Nodes => is_of_kind(c) && c.stencil.nodes() == candidate.stencil.nodes(),
        Identity::Weights => is_of_kind(c) && c.stencil == candidate.stencil,
        Identity::Point => is_of_kind(c) && c.point == candidate.point,
    };
    contacts.iter().any(|c| (c.pair, c.slave) == (candidate.pair, candidate.slave) && is_same(c))
}
