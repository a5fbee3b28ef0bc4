//! Named sets of nodes or elements, as lists of numbers and ranges until all are known.

use crate::mesh::MeshError;
use std::collections::BTreeMap;

/// Numbers that a set may name in all, ranges counted out: a limit lest a short file ask for endless memory.
const MAX_ENTRIES: u64 = 20_000_000;

/// Refuses more entries than the limit.
///
/// # Errors
/// `Unsupported` beyond the limit.
pub(super) fn within_limit(entries: u64) -> Result<(), MeshError> {
    if entries <= MAX_ENTRIES {
        return Ok(());
    }
    Err(MeshError::Unsupported {
        what: format!("sets of more than {MAX_ENTRIES} entries in all"),
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
#[derive(Default)]
pub(super) struct Sets {
    by_name: BTreeMap<String, (String, Vec<Numbers>)>,
    /// Names in the order of their first mention.
    order: Vec<String>,
    entries: u64,
}

impl Sets {
    /// Adds numbers to a set, which is made when it is new.
    ///
    /// # Errors
    /// `Unsupported` when all sets together grow beyond a limit.
    pub(super) fn add(&mut self, name: &str, numbers: Numbers) -> Result<(), MeshError> {
        self.entries = self.entries.saturating_add(numbers.count());
        within_limit(self.entries)?;
        self.touch(name).push(numbers);
        Ok(())
    }

    /// The numbers of a set, which is made when it is new.
    pub(super) fn touch(&mut self, name: &str) -> &mut Vec<Numbers> {
        let key = name.to_uppercase();
        let order = &mut self.order;
        let entry = self.by_name.entry(key).or_insert_with_key(|key| {
            order.push(key.clone());
            (name.to_owned(), Vec::new())
        });
        &mut entry.1
    }

    /// The numbers of a set that exists.
    pub(super) fn get(&self, name: &str) -> Option<&[Numbers]> {
        self.by_name.get(&name.to_uppercase()).map(|(_, numbers)| numbers.as_slice())
    }

    /// Adds all numbers of the set `from` to the set `to`; `false` when there is no `from`.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub(super) fn add_set(&mut self, to: &str, from: &str) -> Result<bool, MeshError> {
        let Some(numbers) = self.get(from).map(<[Numbers]>::to_vec) else { return Ok(false) };
        for range in numbers {
            self.add(to, range)?;
        }
        Ok(true)
    }

    /// Name (as first spelled) and numbers of each set, in the order of their first mention.
    pub(super) fn in_order(&self) -> impl Iterator<Item = (&str, &[Numbers])> {
        self.order.iter().map(|key| {
            let (name, numbers) = &self.by_name[key];
            (name.as_str(), numbers.as_slice())
        })
    }
}
