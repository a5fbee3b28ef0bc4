//! Named sets of nodes or elements, as lists of numbers and ranges until all are known.

use crate::mesh::MeshError;
use crate::mesh::read::assembly::within_names;
use crate::mesh::read::entries::{Numbers, most_entries, within_limit};
use std::collections::HashMap;

/// Sets by name, not case-sensitive; the first spelling is kept.
pub(super) struct Sets {
    /// Index in `named` of each name, in capitals; only looked up.
    index: HashMap<String, usize>,
    /// In the order of first mention.
    named: Vec<NamedSet>,
    entries: u64,
    most_entries: u64,
}

struct NamedSet {
    /// Name in its first spelling.
    name: String,
    numbers: Vec<Numbers>,
    /// Number of entries, with ranges counted in full.
    entries: u64,
    /// Sets that were added as a whole, with their number of entries at that time.
    taken: HashMap<usize, u64>,
}

impl Sets {
    /// No sets yet, for a file of this size.
    pub(super) fn of_file(bytes: usize) -> Self {
        Self { index: HashMap::new(), named: Vec::new(), entries: 0, most_entries: most_entries(bytes) }
    }

    /// Adds numbers to a set, which is created if necessary.
    ///
    /// # Errors
    /// `Unsupported` when all sets together exceed a limit.
    pub(super) fn add(&mut self, name: &str, numbers: Numbers) -> Result<(), MeshError> {
        let to = self.touch(name)?;
        self.count(to, numbers.count())?;
        self.named[to].numbers.push(numbers);
        Ok(())
    }

    /// Index of a set, which is created if necessary.
    ///
    /// # Errors
    /// `Unsupported` when there are too many.
    pub(super) fn touch(&mut self, name: &str) -> Result<usize, MeshError> {
        let key = name.to_uppercase();
        if let Some(&place) = self.index.get(&key) {
            return Ok(place);
        }
        let place = self.named.len();
        within_names(place + 1)?;
        self.index.insert(key, place);
        self.named.push(NamedSet {
            name: name.to_owned(),
            numbers: Vec::new(),
            entries: 0,
            taken: HashMap::new(),
        });
        Ok(place)
    }

    /// The numbers of a set, if it exists.
    pub(super) fn get(&self, name: &str) -> Option<&[Numbers]> {
        self.index.get(&name.to_uppercase()).map(|&place| self.named[place].numbers.as_slice())
    }

    /// Adds all numbers of the set `from` to the set `to`; `false` when `from` does not exist.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub(super) fn add_set(&mut self, to: &str, from: &str) -> Result<bool, MeshError> {
        let Some(&from) = self.index.get(&from.to_uppercase()) else { return Ok(false) };
        let to = self.touch(to)?;
        let entries = self.named[from].entries;
        // The set itself, or one that it contains already, adds nothing.
        if to == from || self.named[to].taken.get(&from) == Some(&entries) {
            return Ok(true);
        }
        self.count(to, entries)?;
        let numbers = self.named[from].numbers.clone();
        self.named[to].taken.insert(from, entries);
        self.named[to].numbers.extend(numbers);
        Ok(true)
    }

    /// Counts entries before they are added, and checks the limit.
    fn count(&mut self, to: usize, entries: u64) -> Result<(), MeshError> {
        self.entries = self.entries.saturating_add(entries);
        within_limit(self.entries, self.most_entries)?;
        self.named[to].entries += entries;
        Ok(())
    }

    /// Name (in its first spelling) and numbers of each set, in the order of first mention.
    pub(super) fn in_order(&self) -> impl Iterator<Item = (&str, &[Numbers])> {
        self.named.iter().map(|set| (set.name.as_str(), set.numbers.as_slice()))
    }
}
