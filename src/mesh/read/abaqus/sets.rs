//! Named sets of nodes or elements, as lists of numbers and ranges until all are known.

use crate::mesh::MeshError;
use crate::mesh::read::assembly::within_names;
use std::collections::HashMap;

/// Number of set entries that every file may have, with ranges counted in full.
const FEW_ENTRIES: u64 = 500_000;
/// Bytes of a file for each entry beyond those: a file with so many entries has about so many bytes for each.
const BYTES_AN_ENTRY: u64 = 8;
/// Largest number of set entries of any file.
const MOST_ENTRIES: u64 = 20_000_000;

/// Largest number of set entries of a file of this size: prevents a short file from requesting endless memory.
pub(super) fn most_entries(bytes: usize) -> u64 {
    (FEW_ENTRIES + bytes as u64 / BYTES_AN_ENTRY).min(MOST_ENTRIES)
}

/// Refuses more entries than allowed.
///
/// # Errors
/// `Unsupported` beyond the limit.
pub(super) fn within_limit(entries: u64, most: u64) -> Result<(), MeshError> {
    if entries <= most {
        return Ok(());
    }
    Err(MeshError::Unsupported {
        what: format!("sets of more than {most} entries in all"),
        remedy: "remove sets that are not needed".into(),
    })
}

/// The numbers from `first` to `last` by `step`, and the place where they are given.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers {
    pub(super) first: u64,
    pub(super) last: u64,
    pub(super) step: u64,
    /// Byte offset in the file.
    pub(super) offset: usize,
}

impl Numbers {
    /// A range of one number.
    pub(super) fn one(number: u64, offset: usize) -> Self {
        Self { first: number, last: number, step: 1, offset }
    }

    /// Whether it is a single number, which must then exist; a range may skip missing numbers.
    pub(super) fn is_one(&self) -> bool {
        self.first == self.last
    }

    /// How many numbers it contains.
    pub(super) fn count(&self) -> u64 {
        ((self.last - self.first) / self.step).saturating_add(1)
    }

    /// All numbers of the range.
    pub(super) fn each(&self) -> impl Iterator<Item = u64> + use<> {
        let (first, step) = (self.first, self.step);
        (0..self.count()).map(move |i| first + i * step)
    }
}

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
