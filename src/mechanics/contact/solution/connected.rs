//! Which of the contacts of a step depend on each other.

/// Contacts in groups that grow together (union–find); the smallest number of a group stands for it.
#[derive(Clone, Debug, Default)]
pub(super) struct Connected {
    parent: Vec<usize>,
}

impl Connected {
    /// Begins with as many groups of one contact.
    pub fn restart(&mut self, contacts: usize) {
        self.parent.clear();
        self.parent.extend(0..contacts);
    }

    /// Makes one group of those of two contacts.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.parent[a.max(b)] = a.min(b);
    }

    /// Whether two contacts are in one group.
    pub fn are_one(&mut self, a: usize, b: usize) -> bool {
        self.first(a) == self.first(b)
    }

    /// Ends the growth: [`Self::firsts`] are known.
    pub fn close(&mut self) {
        // A parent is never larger than its child, and comes before it.
        for c in 0..self.parent.len() {
            self.parent[c] = self.parent[self.parent[c]];
        }
    }

    /// The first contact of the group of each contact, once it has [ended its growth](Self::close).
    pub fn firsts(&self) -> &[usize] {
        &self.parent
    }

    fn first(&mut self, mut c: usize) -> usize {
        while self.parent[c] != c {
            self.parent[c] = self.parent[self.parent[c]];
            c = self.parent[c];
        }
        c
    }
}
