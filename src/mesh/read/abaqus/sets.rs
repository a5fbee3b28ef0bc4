//! Named sets of nodes or elements, as lists of numbers and ranges until all are known.

use crate::mesh::MeshError;
use crate::mesh::read::assembly::within_names;
use std::collections::HashMap;

/// Entries that the sets of every file may have, ranges counted out.
const FEW_ENTRIES: u64 = 500_000;
/// Bytes of a file for each entry beyond those: who writes so many entries writes about so much for each.
const BYTES_AN_ENTRY: u64 = 8;
/// Entries that no file may have.
const MOST_ENTRIES: u64 = 20_000_000;

/// Entries that the sets of a file of so many bytes may have in all: a limit lest a short file ask for endless memory.
pub(super) fn most_entries(bytes: usize) -> u64 {
    (FEW_ENTRIES + bytes as u64 / BYTES_AN_ENTRY).min(MOST_ENTRIES)
}

/// Refuses more entries than there may be.
///
/// # Errors
/// `Unsupported` beyond the limit.
pub(super) fn within_limit(entries: u64, most: u64) -> Result<(), MeshError> {
    if entries <= most {
        return Ok(());
    }
    Err(MeshError::Unsupported {
        what: format!("sets of more than {most} entries in all"),
        remedy: "leave out sets that are not needed".into(),
    })
}

/// Numbers from `first` to `last` by `step`, and where they are named.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers {
    pub(super) first: u64,
    pub(super) last: u64,
    pub(super) step: u64,
    /// Byte offset in the file.
    pub(super) offset: usize,
}

impl Numbers {
    /// One number.
    pub(super) fn one(number: u64, offset: usize) -> Self {
        Self { first: number, last: number, step: 1, offset }
    }

    /// Whether it came as a single number, which must then exist; a range passes over numbers that do not.
    pub(super) fn is_one(&self) -> bool {
        self.first == self.last
    }

    /// How many numbers it holds.
    pub(super) fn count(&self) -> u64 {
        ((self.last - self.first) / self.step).saturating_add(1)
    }

    /// All its numbers.
    pub(super) fn each(&self) -> impl Iterator<Item = u64> + use<> {
        let (first, step) = (self.first, self.step);
        (0..self.count()).map(move |i| first + i * step)
    }
}

/// Sets by name. Names are the same in capitals and in small letters; the first spelling is kept.
pub(super) struct Sets {
    /// Place of each name, in capitals, in `named`; only looked up.
    index: HashMap<String, usize>,
    /// In the order of their first mention.
    named: Vec<NamedSet>,
    entries: u64,
    most_entries: u64,
}

struct NamedSet {
    /// As first spelled.
    name: String,
    numbers: Vec<Numbers>,
    /// How many numbers that are.
    entries: u64,
    /// Sets that were added whole, with the entries that they had.
    taken: HashMap<usize, u64>,
}

impl Sets {
    /// No sets, of a file of so many bytes.
    pub(super) fn of_file(bytes: usize) -> Self {
        Self { index: HashMap::new(), named: Vec::new(), entries: 0, most_entries: most_entries(bytes) }
    }

    /// Adds numbers to a set, which is made when it is new.
    ///
    /// # Errors
    /// `Unsupported` when all sets together grow beyond a limit.
    pub(super) fn add(&mut self, name: &str, numbers: Numbers) -> Result<(), MeshError> {
        let to = self.touch(name)?;
        self.count(to, numbers.count())?;
        self.named[to].numbers.push(numbers);
        Ok(())
    }

    /// The place of a set, which is made when it is new.
    ///
    /// # Errors
    /// `Unsupported` when there are very many.
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

    /// The numbers of a set that exists.
    pub(super) fn get(&self, name: &str) -> Option<&[Numbers]> {
        self.index.get(&name.to_uppercase()).map(|&place| self.named[place].numbers.as_slice())
    }

    /// Adds all numbers of the set `from` to the set `to`; `false` when there is no `from`.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub(super) fn add_set(&mut self, to: &str, from: &str) -> Result<bool, MeshError> {
        let Some(&from) = self.index.get(&from.to_uppercase()) else { return Ok(false) };
        let to = self.touch(to)?;
        let entries = self.named[from].entries;
        // Itself, or one that it holds already: nothing new.
        if to == from || self.named[to].taken.get(&from) == Some(&entries) {
            return Ok(true);
        }
        self.count(to, entries)?;
        let numbers = self.named[from].numbers.clone();
        self.named[to].taken.insert(from, entries);
        self.named[to].numbers.extend(numbers);
        Ok(true)
    }

    /// Counts entries before they are added.
    fn count(&mut self, to: usize, entries: u64) -> Result<(), MeshError> {
        self.entries = self.entries.saturating_add(entries);
        within_limit(self.entries, self.most_entries)?;
        self.named[to].entries += entries;
        Ok(())
    }

    /// Name (as first spelled) and numbers of each set, in the order of their first mention.
    pub(super) fn in_order(&self) -> impl Iterator<Item = (&str, &[Numbers])> {
        self.named.iter().map(|set| (set.name.as_str(), set.numbers.as_slice()))
    }
}
