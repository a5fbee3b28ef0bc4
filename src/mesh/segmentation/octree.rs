//! A balanced octree over a box: leaves that touch differ by at most one halving, over faces, edges and corners.

use crate::mechanics::tensor::Vec3;
use std::collections::HashMap;

/// Largest number of halvings.
pub const MOST_HALVINGS: u8 = 7;

/// Largest number of finest cells along an axis: coordinates have 20 bits in the keys.
pub const MOST_CELLS: u32 = 1 << 20;

/// A leaf; its low corner in units of the finest cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// Low corner, in units of the finest cells.
    pub at: [u32; 3],
    /// Number of halvings of a cell of the base grid; the finest cells have [`Octree::depth`].
    pub level: u8,
}

/// Cells of different sizes that fill the box of a scan, each halved along all axes where a finer one is needed.
#[derive(Clone, Debug)]
pub struct Octree {
    /// Number of finest cells along each axis.
    pub cells: [u32; 3],
    /// Lengths of a finest cell [m].
    pub unit: Vec3,
    /// Largest number of halvings.
    pub depth: u8,
    /// The leaves, children in place of their parent.
    pub leaves: Vec<Leaf>,
    /// Index of each leaf; only looked up.
    index: HashMap<u64, u32>,
}

fn key(at: [u32; 3], level: u8) -> u64 {
    u64::from(level) << 60 | u64::from(at[0]) << 40 | u64::from(at[1]) << 20 | u64::from(at[2])
}

impl Octree {
    /// A grid of `base` cells over a box of these lengths [m], to be halved up to `depth` times.
    pub fn new(base: [u32; 3], lengths: &Vec3, depth: u8) -> Self {
        let size = 1 << depth;
        let cells = base.map(|n| n * size);
        let unit = Vec3::from_fn(|k, _| lengths[k] / f64::from(cells[k]));
        let mut leaves = Vec::with_capacity(base.iter().map(|n| *n as usize).product());
        for k in 0..base[2] {
            for j in 0..base[1] {
                leaves.extend((0..base[0]).map(|i| Leaf { at: [i, j, k].map(|n| n * size), level: 0 }));
            }
        }
        let mut tree = Self { cells, unit, depth, leaves, index: HashMap::new() };
        tree.make_index();
        tree
    }

    fn make_index(&mut self) {
        self.index = (0..).zip(&self.leaves).map(|(i, leaf)| (key(leaf.at, leaf.level), i)).collect();
    }

    /// Length of a leaf in finest cells.
    pub fn size(&self, level: u8) -> u32 {
        1 << (self.depth - level)
    }

    /// Longest edge of a leaf [m].
    pub fn edge(&self, level: u8) -> f64 {
        self.unit.max() * f64::from(self.size(level))
    }

    /// Low and high corner of a leaf [m].
    pub fn bounds(&self, leaf: Leaf) -> [Vec3; 2] {
        let size = self.size(leaf.level);
        [leaf.at, leaf.at.map(|n| n + size)].map(|corner| self.position(corner))
    }

    /// Position of a corner [m].
    pub fn position(&self, corner: [u32; 3]) -> Vec3 {
        Vec3::from_fn(|k, _| f64::from(corner[k]) * self.unit[k])
    }

    /// The leaf with a finest cell; `None` outside of the box.
    pub fn leaf_at(&self, cell: [i64; 3]) -> Option<usize> {
        if (0..3).any(|k| cell[k] < 0 || cell[k] >= i64::from(self.cells[k])) {
            return None;
        }
        let cell = cell.map(|n| n as u32);
        (0..=self.depth).rev().find_map(|level| {
            let mask = !(self.size(level) - 1);
            self.index.get(&key(cell.map(|n| n & mask), level)).map(|leaf| *leaf as usize)
        })
    }

    /// The leaves that have a corner, or a point of their surface, at a corner of cells: one for each octant, x first; `None`
    /// outside of the box.
    pub fn around(&self, corner: [u32; 3]) -> [Option<usize>; 8] {
        std::array::from_fn(|octant| {
            self.leaf_at([0, 1, 2].map(|k| i64::from(corner[k]) - i64::from(octant >> k & 1 == 0)))
        })
    }

    /// Splits leaves until `asks` asks for no more, and balances them; each leaf is queried once.
    ///
    /// # Errors
    /// The number of leaves, before there are more than `most`, and that of `asks`, at once.
    pub fn refine(
        &mut self,
        most: u64,
        asks: &mut dyn FnMut(&Self, Leaf) -> Result<bool, u64>,
    ) -> Result<(), u64> {
        let mut is_new = vec![true; self.leaves.len()];
        loop {
            let mut is_split = vec![false; self.leaves.len()];
            for (i, leaf) in self.leaves.iter().enumerate() {
                is_split[i] = is_new[i] && leaf.level < self.depth && asks(self, *leaf)?;
            }
            self.balance(&mut is_split);
            let splits = is_split.iter().filter(|is_split| **is_split).count();
            let count = self.leaves.len() + 7 * splits;
            if count as u64 > most {
                return Err(count as u64);
            }
            if splits == 0 {
                return Ok(());
            }
            let mut leaves = Vec::with_capacity(count);
            is_new.clear();
            for (leaf, is_split) in self.leaves.iter().zip(is_split) {
                if is_split {
                    let half = self.size(leaf.level + 1);
                    let child = |octant: u32| Leaf {
                        at: [0, 1, 2].map(|k| leaf.at[k] + half * (octant >> k & 1)),
                        level: leaf.level + 1,
                    };
                    leaves.extend((0..8).map(child));
                } else {
                    leaves.push(*leaf);
                }
                is_new.resize(leaves.len(), is_split);
            }
            self.leaves = leaves;
            self.make_index();
        }
    }

    /// Also splits coarser leaves that touch one that is split.
    fn balance(&self, is_split: &mut [bool]) {
        let mut open: Vec<usize> = (0..is_split.len()).filter(|i| is_split[*i]).collect();
        while let Some(i) = open.pop() {
            let Leaf { at, level } = self.leaves[i];
            let size = i64::from(self.size(level));
            for side in 0..27_i64 {
                let step = [side % 3 - 1, side / 3 % 3 - 1, side / 9 - 1];
                // The centre of the neighbour of the same size; a coarser one has it, too.
                let cell = [0, 1, 2].map(|k| i64::from(at[k]) + size / 2 + step[k] * size);
                let other = self.leaf_at(cell).filter(|other| self.leaves[*other].level < level);
                if let Some(other) = other.filter(|other| !is_split[*other]) {
                    is_split[other] = true;
                    open.push(other);
                }
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    #[test]
    fn leaves_fill_the_box_and_touch_only_the_next_size() {
        let mut tree = Octree::new([3, 2, 2], &Vec3::new(3.0, 2.0, 2.0), 4);
        let point = Vec3::new(1.1, 0.4, 1.0);
        let is_there = |tree: &Octree, leaf: Leaf| {
            let [low, high] = tree.bounds(leaf);
            (0..3).all(|k| low[k] <= point[k] && point[k] <= high[k])
        };
        tree.refine(10_000, &mut |tree, leaf| Ok(is_there(tree, leaf))).unwrap();
        let volume = |leaf: &Leaf| f64::from(tree.size(leaf.level)).powi(3) * tree.unit.product();
        assert!((tree.leaves.iter().map(volume).sum::<f64>() - 12.0).abs() < 1e-12);
        assert_eq!(tree.leaves.iter().map(|leaf| leaf.level).max(), Some(4));
        for leaf in &tree.leaves {
            let size = tree.size(leaf.level);
            for corner in 0..8 {
                let corner = [0, 1, 2].map(|k| leaf.at[k] + size * (corner >> k & 1));
                for other in tree.around(corner).into_iter().flatten() {
                    assert!(tree.leaves[other].level.abs_diff(leaf.level) <= 1);
                }
            }
        }
        let mut tree = Octree::new([4, 4, 4], &Vec3::new(1.0, 1.0, 1.0), 6);
        assert_eq!(tree.refine(1000, &mut |_, _| Ok(true)), Err(4096));
        assert_eq!(tree.leaves.len(), 512, "none are made beyond the limit");
    }
}
