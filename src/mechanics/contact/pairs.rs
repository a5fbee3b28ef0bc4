//! The contact pairs of a model, by number.
//!
//! Where every two of many bodies may touch, their pairs are half a million for a thousand bodies, of which each body meets a
//! handful. Such pairs are not listed: their numbers determine their sides, and whatever is stored for a pair is stored in
//! a sparse list once the two come near.

use super::{ContactLaw, ContactPair, Master};
use std::ops::Range;

/// Mesh sizes that differ by less are equal [-].
const ROUNDING: f64 = 1e-9;

/// All pairs: those of meshes and with planes that are listed, then every two of some meshes, then the listed ones with a rigid
/// side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pairs {
    meshes: Vec<ContactPair>,
    every: EveryTwo,
    rigid: Vec<ContactPair>,
}

/// Pairs of every two of some surfaces, numbered from 0: the first surface with all behind it, and so on.
#[derive(Clone, Debug, PartialEq)]
pub struct EveryTwo {
    /// Index of each surface, and its mean face size [m]: the finer of two is the slave, the first if they are equal.
    surfaces: Vec<(usize, f64)>,
    law: ContactLaw,
    /// Slave and master are exchanged.
    is_exchanged: bool,
}

impl Default for EveryTwo {
    fn default() -> Self {
        Self::new(Vec::new(), ContactLaw::Frictionless)
    }
}

impl EveryTwo {
    /// Every two of the `surfaces`, given with their mean face sizes [m], under one law.
    pub fn new(surfaces: Vec<(usize, f64)>, law: ContactLaw) -> Self {
        Self { surfaces, law, is_exchanged: false }
    }

    /// Indices of the surfaces.
    pub fn surfaces(&self) -> impl Iterator<Item = usize> {
        self.surfaces.iter().map(|(surface, _)| *surface)
    }

    /// The law of its pairs.
    pub fn law(&self) -> ContactLaw {
        self.law
    }

    /// Number of pairs, listed or every two of the surfaces.
    pub fn len(&self) -> usize {
        self.first_of(self.surfaces.len().saturating_sub(1))
    }

    /// Whether there are no pairs.
    pub fn is_empty(&self) -> bool {
        self.surfaces.len() < 2
    }

    /// Number of the first pair of the surface at a place with those behind it.
    fn first_of(&self, place: usize) -> usize {
        place * (2 * self.surfaces.len().max(1) - place - 1) / 2
    }

    /// Number of the pair of the surfaces at two places, the first smaller.
    pub fn number(&self, first: usize, second: usize) -> usize {
        self.first_of(first) + second - first - 1
    }

    fn get(&self, number: usize) -> ContactPair {
        let (mut low, mut high) = (0, self.surfaces.len());
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            if self.first_of(middle) <= number { low = middle } else { high = middle }
        }
        let (a, b) = (self.surfaces[low], self.surfaces[number - self.first_of(low) + low + 1]);
        let is_second = (b.1 < a.1 * (1.0 - ROUNDING)) != self.is_exchanged;
        let (slave, master) = if is_second { (b.0, a.0) } else { (a.0, b.0) };
        ContactPair { slave, master: Master::Surface(master), law: self.law }
    }
}

impl Pairs {
    /// Listed pairs without and with a rigid side, and between them every two of some meshes.
    pub fn new(meshes: Vec<ContactPair>, every: EveryTwo, rigid: Vec<ContactPair>) -> Self {
        Self { meshes, every, rigid }
    }

    /// Number of all pairs.
    pub fn len(&self) -> usize {
        self.mesh_count() + self.rigid.len()
    }

    /// Whether there are no pairs.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of pairs without a rigid side; these come first.
    pub fn mesh_count(&self) -> usize {
        self.meshes.len() + self.every.len()
    }

    /// Numbers of the pairs of every two meshes.
    pub fn unlisted(&self) -> Range<usize> {
        self.meshes.len()..self.mesh_count()
    }

    /// The meshes of which every two are a pair.
    pub fn every_two(&self) -> &EveryTwo {
        &self.every
    }

    /// A pair by its number, below [`Pairs::len`].
    pub fn get(&self, number: usize) -> ContactPair {
        let every = self.unlisted();
        if every.contains(&number) {
            self.every.get(number - every.start)
        } else if number < every.start {
            self.meshes[number]
        } else {
            self.rigid[number - every.end]
        }
    }

    /// The listed pairs with their numbers, ascending.
    pub fn listed(&self) -> impl Iterator<Item = (usize, &ContactPair)> {
        let meshes = self.meshes.iter().enumerate();
        meshes.chain(self.rigid.iter().enumerate().map(|(i, pair)| (self.mesh_count() + i, pair)))
    }

    /// The pairs with a rigid side, with the number of the first.
    pub fn rigid(&self) -> (&[ContactPair], usize) {
        (&self.rigid, self.mesh_count())
    }

    /// All pairs with their numbers, ascending; as many as the square of the number of bodies.
    pub fn each(&self) -> impl Iterator<Item = (usize, ContactPair)> {
        (0..self.len()).map(|number| (number, self.get(number)))
    }

    /// The pairs of two different meshes with slave and master exchanged, and the number of each listed one in this list.
    pub fn exchanged(&self) -> (Self, Vec<usize>) {
        let exchanged = |(number, pair): (usize, &ContactPair)| match pair.master {
            Master::Surface(master) if master != pair.slave => {
                let master = (master, Master::Surface(pair.slave));
                Some((ContactPair { slave: master.0, master: master.1, law: pair.law }, number))
            }
            _ => None,
        };
        let (meshes, numbers) = self.meshes.iter().enumerate().filter_map(exchanged).unzip();
        let every = EveryTwo { is_exchanged: !self.every.is_exchanged, ..self.every.clone() };
        (Self { meshes, every, rigid: Vec::new() }, numbers)
    }
}

impl FromIterator<ContactPair> for Pairs {
    /// Listed pairs, those with a rigid master last.
    fn from_iter<I: IntoIterator<Item = ContactPair>>(pairs: I) -> Self {
        let is_mesh = |pair: &ContactPair| !matches!(pair.master, Master::Rigid(_));
        let (meshes, rigid) = pairs.into_iter().partition(is_mesh);
        Self { meshes, rigid, every: EveryTwo::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(slave: usize, master: usize) -> ContactPair {
        ContactPair { slave, master: Master::Surface(master), law: ContactLaw::Frictionless }
    }

    #[test]
    fn every_two_surfaces_have_one_number_between_the_listed_ones() {
        // Surface 5 is the finest, 7 the coarsest.
        let every = EveryTwo::new(vec![(3, 1.0), (5, 0.5), (7, 2.0), (9, 1.0)], ContactLaw::of(0.3));
        let rigid = ContactPair { slave: 3, master: Master::Rigid(0), law: ContactLaw::Frictionless };
        let pairs = Pairs::new(vec![pair(3, 3)], every.clone(), vec![rigid]);
        assert_eq!((pairs.len(), pairs.mesh_count(), pairs.unlisted()), (8, 7, 1..7));
        let sides: Vec<(usize, Master)> = pairs.each().map(|(_, pair)| (pair.slave, pair.master)).collect();
        let two = |slave, master| (slave, Master::Surface(master));
        let between = [two(5, 3), two(3, 7), two(3, 9), two(5, 7), two(5, 9), two(9, 7)];
        let expected = [&[two(3, 3)][..], &between, &[(3, Master::Rigid(0))]].concat();
        assert_eq!(sides, expected);
        for (first, second) in [(0, 1), (0, 3), (1, 2), (2, 3)] {
            let found = pairs.get(pairs.unlisted().start + every.number(first, second));
            let of = [every.surfaces[first].0, every.surfaces[second].0];
            assert!(of.contains(&found.slave) && found.law == ContactLaw::Coulomb(0.3));
        }
        // With both sides exchanged, and without the pair of one surface.
        let (exchanged, numbers) = pairs.exchanged();
        assert!(numbers.is_empty() && exchanged.len() == 6);
        for (i, (slave, master)) in between.into_iter().enumerate() {
            assert_eq!(
                (Master::Surface(exchanged.get(i).slave), exchanged.get(i).master),
                (master, Master::Surface(slave))
            );
        }
    }

    #[test]
    fn fewer_than_two_surfaces_have_no_pairs() {
        for surfaces in [Vec::new(), vec![(0, 1.0)]] {
            let every = EveryTwo::new(surfaces, ContactLaw::Frictionless);
            assert!(every.is_empty());
        }
    }
}
