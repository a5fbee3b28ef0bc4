//! Reads the children of an XML element one after another; children that remain unread are refused.

use super::deck::Deck;
use super::node::{elements, text, title};
use roxmltree::Node;
use std::collections::BTreeSet;

/// An element whose children are taken.
pub(super) struct Item<'x> {
    /// The XML element whose children and attributes are taken from here.
    pub node: Node<'x, 'x>,
    taken: BTreeSet<&'x str>,
}

impl<'x> Item<'x> {
    pub(super) fn new(node: Node<'x, 'x>) -> Self {
        Self { node, taken: BTreeSet::new() }
    }

    /// The first child of a name.
    pub(super) fn take(&mut self, name: &'x str) -> Option<Node<'x, 'x>> {
        self.taken.insert(name);
        elements(self.node).find(|child| child.has_tag_name(name))
    }

    /// The text of a child.
    pub(super) fn text(&mut self, name: &'x str) -> Option<&'x str> {
        self.take(name).map(text)
    }

    /// Whether a flag is set.
    pub(super) fn flag(&mut self, name: &'x str) -> bool {
        self.text(name).is_some_and(|value| value != "0")
    }

    /// A child that is one number throughout; `None` where there is none, or something else, which is refused.
    pub(super) fn number(&mut self, name: &'x str, deck: &mut Deck) -> Option<f64> {
        let child = self.take(name)?;
        if child.has_attribute("lc") {
            deck.refuse(child, "a parameter with a load curve", "give it a constant value");
            return None;
        }
        deck.constant(child)
    }

    /// A number that has to be there.
    pub(super) fn required(&mut self, name: &'x str, deck: &mut Deck) -> Option<f64> {
        if self.take(name).is_none() {
            deck.refuse(self.node, format!("no <{name}>"), "give it a value in FEBio Studio");
        }
        self.number(name, deck)
    }

    /// Refuses what was not taken, but for children of these names, which do not change the physical problem.
    pub(super) fn finish(self, without_effect: &[&str], deck: &mut Deck) {
        for child in elements(self.node) {
            let name = child.tag_name().name();
            if !self.taken.contains(name) && !without_effect.contains(&name) {
                let what = format!("{} in {}", title(child), title(self.node));
                deck.refuse_as(child, what, "has no counterpart in a scene: remove it in the file");
            }
        }
    }
}
