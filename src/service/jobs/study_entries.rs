//! Lists of settings in a study: how long they may be, and what each entry must keep to.

use crate::scene::Problem;
use crate::scene::problem::Pointer;
use serde_json::Value;

/// Entries that a list of settings may have: each is a run or more.
pub(super) const MOST_ENTRIES: usize = 16;

/// A list of settings.
pub(super) struct Entries<'a, T> {
    /// The member of the study that holds it.
    pub name: &'a str,
    /// What was written.
    pub written: &'a [T],
    /// What each must keep to.
    pub limit: String,
    /// What to give.
    pub remedy: &'a str,
}

impl<T: Copy + PartialEq + Into<Value>> Entries<'_, T> {
    /// All that is wrong: that there are too many, and each of the first that is not good or comes again.
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
