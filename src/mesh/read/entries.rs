//! Ranges of node and element numbers, and the limit on their entries.

use crate::mesh::MeshError;

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
