//! A number of each element of a batch, in memory.

/// Width of a batch of elements: that of the widest register of any instruction set, in `f64`.
pub const BATCH: usize = 8;

/// One number of each element of a batch, aligned to the widest register: a load or store across two cache lines
/// takes twice as long, and without alignment most would be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Row(pub [f64; BATCH]);

impl std::ops::Index<usize> for Row {
    type Output = f64;
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl std::ops::IndexMut<usize> for Row {
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

/// A value on the stack, aligned to the widest register, see [`Row`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Aligned<T>(pub T);
