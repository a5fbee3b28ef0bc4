//! Lists of settings in a study: their length, and the limits of each entry.

use crate::scene::Problem;
use crate::scene::problem::Pointer;
use serde_json::Value;

/// Maximum number of entries in a list of settings: each is at least one run.
pub(super) const MOST_ENTRIES: usize = 16;

/// A list of settings with its limits.
pub(super) struct Entries<'a, T> {
    /// Member of the study that contains it.
    pub name: &'a str,
    /// Entries as given in the document.
    pub written: &'a [T],
    /// Limit of each entry.
    pub limit: String,
    /// Suggested correction of the entries.
    pub remedy: &'a str,
}

impl<T: Copy + PartialEq + Into<Value>> Entries<'_, T> {
    /// All problems: too many entries, and the first that is inadmissible or repeated.
    pub fn problems(&self, is_good: impl Fn(T) -> bool) -> Vec<Problem> {
        let first = self.written.iter().enumerate().take(MOST_ENTRIES);
        let of_entries = first.filter_map(|(index, entry)| {
            if !is_good(*entry) {
                let message = format!("{} cannot be that", self.name);
                return Some(self.problem(index, "out_of_range", &message, &self.limit, self.remedy));
            }
            let earlier = self.written[..index].iter().position(|other| other == entry)?;
            let message = format!("this is entry {earlier} again");
            Some(self.problem(index, "repeated_item", &message, "each entry once", "keep one of them"))
        });
        too_many(self.name, self.written.len()).into_iter().chain(of_entries).collect()
    }

    fn problem(&self, index: usize, code: &'static str, message: &str, limit: &str, remedy: &str) -> Problem {
        let place = Pointer::root().key(self.name).index(index);
        Problem::error(code, &place, message).value(self.written[index]).limit(limit).remedy(remedy)
    }
}

/// The problem of a list that is too long.
pub(super) fn too_many(name: &str, count: usize) -> Option<Problem> {
    (count > MOST_ENTRIES).then(|| {
        Problem::error("too_many", &Pointer::root().key(name), format!("{name} is too long"))
            .value(count)
            .limit(format!("at most {MOST_ENTRIES} entries"))
            .remedy("each entry is a run or more: ask for those that differ")
    })
}
