//! Node positions of one cell.

pub use crate::mechanics::element::MOST_NODES;
use crate::mechanics::tensor::Vec3;
use std::ops::Deref;

/// Positions [m] of the nodes of one cell of any kind, without heap allocation; dereferences to a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellPoints {
    x: [Vec3; MOST_NODES],
    count: usize,
}

impl CellPoints {
    /// Positions of at most [`MOST_NODES`] nodes.
    pub fn new(nodes: &[u32], position: impl Fn(u32) -> Vec3) -> Self {
        let mut x = [Vec3::zeros(); MOST_NODES];
        for (x, &node) in x.iter_mut().zip(nodes) {
            *x = position(node);
        }
        Self { x, count: nodes.len().min(MOST_NODES) }
    }

    /// Applies a map to each position.
    #[must_use]
    pub fn map(mut self, moved: impl Fn(&Vec3) -> Vec3) -> Self {
        self.x[..self.count].iter_mut().for_each(|x| *x = moved(x));
        self
    }
}

impl Deref for CellPoints {
    type Target = [Vec3];

    fn deref(&self) -> &[Vec3] {
        &self.x[..self.count]
    }
}
