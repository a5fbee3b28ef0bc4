//! Warnings in the order in which they matter: the one rule for text, page, report and JSON.

use serde::{Serialize, Serializer};
use std::ops::Deref;

/// How much a warning limits the use of the numbers, most severe first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Gravity {
    /// The scene has no impact on the tissue.
    NoImpact,
    /// Numbers are wrong: tissue squeezed against its base, a law beyond its limits.
    Wrong,
    /// The impact is not over: the numbers are not final.
    NotFinal,
    /// A law was used beyond its range.
    BeyondRange,
    /// The mesh does not resolve main numbers, or their error is unknown.
    NotResolved,
    /// The mesh is too coarse for something that the numbers depend on.
    Coarse,
    /// Numbers are less accurate than they could be.
    Inaccurate,
    /// It is not known how well a law holds.
    Untested,
    /// The numbers stand; the warning says how far, or what to improve.
    Remark,
}

/// Warnings of a run, most severe first; those of one gravity in the order in which they were found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Warnings {
    words: Vec<String>,
    /// Of each of the words.
    gravities: Vec<Gravity>,
}

impl Warnings {
    /// Adds those that are not among them.
    pub(super) fn add(&mut self, gravity: Gravity, warnings: impl IntoIterator<Item = String>) {
        for warning in warnings {
            if !self.words.contains(&warning) {
                let at = self.gravities.partition_point(|of| *of <= gravity);
                self.words.insert(at, warning);
                self.gravities.insert(at, gravity);
            }
        }
    }

    /// Adds one on the accuracy of the numbers.
    pub fn add_of_accuracy(&mut self, warning: String) {
        self.add(Gravity::Inaccurate, [warning]);
    }

    /// The first of the most severe, unless it is a remark.
    pub(super) fn worst(&self) -> Option<String> {
        self.gravities.first().filter(|gravity| **gravity < Gravity::Remark).and(self.words.first()).cloned()
    }
}

impl Deref for Warnings {
    type Target = [String];

    fn deref(&self) -> &[String] {
        &self.words
    }
}

impl IntoIterator for Warnings {
    type Item = String;
    type IntoIter = std::vec::IntoIter<String>;

    fn into_iter(self) -> Self::IntoIter {
        self.words.into_iter()
    }
}

impl Serialize for Warnings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.words.serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gravest_come_first_and_once() {
        let mut all = Warnings::default();
        for (gravity, words) in [
            (Gravity::Remark, "remark"),
            (Gravity::Inaccurate, "inaccurate"),
            (Gravity::BeyondRange, "range"),
            (Gravity::NotFinal, "not final"),
            (Gravity::Remark, "range"),
            (Gravity::Untested, "untested"),
            (Gravity::NotFinal, "neither"),
            (Gravity::Coarse, "coarse"),
            (Gravity::NotResolved, "not resolved"),
            (Gravity::Wrong, "squeezed"),
            (Gravity::NoImpact, "no impact"),
        ] {
            all.add(gravity, [words.to_owned()]);
        }
        all.add_of_accuracy("own mesh".into());
        assert_eq!(all.worst().as_deref(), Some("no impact"));
        let order = [
            "no impact",
            "squeezed",
            "not final",
            "neither",
            "range",
            "not resolved",
            "coarse",
            "inaccurate",
            "own mesh",
            "untested",
            "remark",
        ];
        assert_eq!(all[..], order);
        assert_eq!(serde_json::to_value(&all).ok(), Some(serde_json::json!(order)));
    }

    #[test]
    fn a_remark_is_not_the_worst() {
        let mut all = Warnings::default();
        all.add(Gravity::Remark, ["remark".to_owned()]);
        assert_eq!(all.worst(), None);
    }
}
