//! Parts of the list of a pair, for threads to share.

use super::time_of_impact::Search;
use crate::contact::Contact;
use std::ops::Range;

/// Number of parts: so many that threads share them evenly.
pub(super) const PARTS: usize = 16;

/// Listed nodes of a part at least: with fewer a thread would wait for longer than it works.
pub(super) const LEAST: usize = 64;

/// A run of the nodes listed for a pair, searched by one thread, with room for what it finds.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Places in the list.
    pub range: Range<usize>,
    pub contacts: Vec<Contact>,
    /// In self-contact, for each node, the sum of the surface's relative motion from which on it may meet a listed face [m].
    pub inactive_until: Vec<f64>,
    pub search: Search,
}

impl Part {
    /// Room for so many contacts.
    pub fn with_capacity(most: usize) -> Self {
        Self { contacts: Vec::with_capacity(most), ..Self::default() }
    }

    /// In self-contact: forgets how far the nodes are from everything.
    pub fn restart(&mut self) {
        self.inactive_until.clear();
        self.inactive_until.resize(self.range.len(), f64::NEG_INFINITY);
    }
}

/// Parts for the lists of surfaces of up to so many nodes, without any node in them.
pub(super) fn parts_for(nodes: usize) -> Vec<Part> {
    (0..PARTS).map(|_| Part::with_capacity(nodes.div_ceil(PARTS).max(LEAST))).collect()
}

/// Divides a list of so many nodes among the parts.
pub(super) fn divide(parts: &mut [Part], count: usize) {
    parts.iter_mut().enumerate().for_each(|(i, part)| part.range = range_of(i, count));
}

/// The `i`-th part of so many places.
pub(super) fn range_of(i: usize, count: usize) -> Range<usize> {
    let of_each = count.div_ceil(PARTS).max(LEAST);
    (i * of_each).min(count)..((i + 1) * of_each).min(count)
}
