//! Values of contact pairs, stored for those that need one.

use crate::mechanics::contact::pairs::Pairs;
use serde::{Serialize, Serializer};
use std::ops::Index;

/// Most contact pairs that plan reports list, and that results and recordings list whether they touch or not: of a thousand bodies there
/// are half a million.
pub const MOST_LISTED_PAIRS: usize = 64;

/// Most bodies and blocks that plan reports list, and whose pairs are listed where every two may touch.
pub const MOST_LISTED_BODIES: usize = 64;

/// Values of pairs, by number: of all that are listed, and of the others that have touched.
#[derive(Clone, Debug, PartialEq)]
pub struct ByPair<T> {
    /// Number and value of a pair, ascending by number.
    values: Vec<(u32, T)>,
}

impl<T> Default for ByPair<T> {
    fn default() -> Self {
        Self { values: Vec::new() }
    }
}

impl<T> ByPair<T> {
    /// A value for each listed pair.
    pub fn new(pairs: Option<&Pairs>, mut value: impl FnMut(usize) -> T) -> Self {
        let listed = pairs.into_iter().flat_map(Pairs::listed);
        Self { values: listed.map(|(number, _)| (number as u32, value(number))).collect() }
    }

    /// The value of a pair, if it has one.
    pub fn get(&self, pair: usize) -> Option<&T> {
        self.find(pair).ok().map(|place| &self.values[place].1)
    }

    /// The value of a pair; a new one if it has none.
    pub fn of(&mut self, pair: usize, new: impl FnOnce() -> T) -> &mut T {
        let place = match self.find(pair) {
            Ok(place) => place,
            Err(place) => {
                self.values.insert(place, (pair as u32, new()));
                place
            }
        };
        &mut self.values[place].1
    }

    fn find(&self, pair: usize) -> Result<usize, usize> {
        self.values.binary_search_by_key(&pair, |(number, _)| *number as usize)
    }

    /// Number of pairs that have a value.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// All values, ascending by the number of their pairs.
    pub fn values(&self) -> impl DoubleEndedIterator<Item = &T> + Clone {
        self.values.iter().map(|(_, value)| value)
    }

    /// All values with the numbers of their pairs, ascending.
    pub fn each(&self) -> impl Iterator<Item = (usize, &T)> {
        self.values.iter().map(|(number, value)| (*number as usize, value))
    }

    /// As [`ByPair::each`], to be changed.
    pub fn each_mut(&mut self) -> impl Iterator<Item = (usize, &mut T)> {
        self.values.iter_mut().map(|(number, value)| (*number as usize, value))
    }

    /// Copies `other` into the existing buffer.
    pub fn copy_from(&mut self, other: &Self)
    where
        T: Clone,
    {
        self.values.clone_from(&other.values);
    }
}

impl<T> Index<usize> for ByPair<T> {
    type Output = T;

    /// The value of a pair that has one.
    fn index(&self, pair: usize) -> &T {
        &self.values[self.find(pair).unwrap_or(usize::MAX)].1
    }
}

impl<T: Serialize> Serialize for ByPair<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(self.values())
    }
}
