//! A map from a few of many places, such as the nodes of a surface.

/// No entry.
const NONE: u32 = u32::MAX;

/// Values of some places, in the order of the places once sorted.
#[derive(Clone, Debug)]
pub(super) struct PlaceMap<T> {
    entries: Vec<(u32, T)>,
    /// Index of the entry of each place.
    of: Vec<u32>,
}

impl<T> Default for PlaceMap<T> {
    fn default() -> Self {
        Self::of(0)
    }
}

impl<T> PlaceMap<T> {
    /// An empty map of so many places.
    pub fn of(places: usize) -> Self {
        Self { entries: Vec::new(), of: vec![NONE; places] }
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    pub fn contains(&self, place: u32) -> bool {
        self.of[place as usize] != NONE
    }

    pub fn get(&self, place: u32) -> Option<&T> {
        self.entries.get(self.of[place as usize] as usize).map(|(_, value)| value)
    }

    /// The value of a place; a new one is added at the end.
    pub fn entry(&mut self, place: u32, new: impl FnOnce() -> T) -> &mut T {
        let index = &mut self.of[place as usize];
        if *index == NONE {
            *index = self.entries.len() as u32;
            self.entries.push((place, new()));
        }
        &mut self.entries[*index as usize].1
    }

    /// Sets the value of a place.
    pub fn insert(&mut self, place: u32, value: T)
    where
        T: Copy,
    {
        *self.entry(place, || value) = value;
    }

    pub fn iter(&self) -> impl Iterator<Item = (u32, &T)> {
        self.entries.iter().map(|(place, value)| (*place, value))
    }

    pub fn values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.entries.iter_mut().map(|(_, value)| value)
    }

    /// Sorts the entries by their places.
    pub fn sort(&mut self) {
        if !self.entries.is_sorted_by_key(|(place, _)| *place) {
            self.entries.sort_unstable_by_key(|(place, _)| *place);
            self.number();
        }
    }

    /// Keeps the entries that satisfy a condition.
    pub fn retain(&mut self, is_kept: impl Fn(&T) -> bool) {
        let (of, count) = (&mut self.of, self.entries.len());
        self.entries.retain(|(place, value)| {
            let is_kept = is_kept(value);
            if !is_kept {
                of[*place as usize] = NONE;
            }
            is_kept
        });
        if self.entries.len() < count {
            self.number();
        }
    }

    /// Removes all entries; places without one are not touched.
    pub fn clear(&mut self) {
        self.retain(|_| false);
    }

    /// Notes the index of each entry.
    fn number(&mut self) {
        for (index, (place, _)) in self.entries.iter().enumerate() {
            self.of[*place as usize] = index as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_found_sorted_and_removed() {
        let mut map = PlaceMap::of(10);
        for (place, value) in [(7, 70), (2, 20), (5, 50), (7, 71)] {
            *map.entry(place, || 0) += value;
        }
        map.sort();
        assert_eq!(map.iter().collect::<Vec<_>>(), [(2, &20), (5, &50), (7, &141)]);
        map.retain(|value| *value != 20);
        assert!(!map.contains(2) && map.get(5) == Some(&50) && map.get(7) == Some(&141));
        map.clear();
        assert!(map.is_empty() && map.get(7).is_none());
    }
}
