//! A symmetric matrix over nodal unknowns, by columns of its lower triangle.

use super::Unknowns;
use crate::force::{ElementBlock, StiffnessBatch, corner_pair};
use crate::lanes::BATCH;
use crate::tensor::Vec3;

/// Transpose of a 3×3 block: index of each entry, row by row.
const TRANSPOSED: [usize; 9] = [0, 3, 6, 1, 4, 7, 2, 5, 8];

/// The lower triangle of a symmetric matrix, compressed by columns in the order of elimination.
#[derive(Clone, Debug)]
pub struct SymmetricMatrix {
    /// Start of each column, unknowns + 1.
    pub(super) column_start: Vec<usize>,
    /// Row of each entry, ascending in each column; the first is the diagonal.
    pub(super) row: Vec<usize>,
    /// Values of the entries, in the order of `row`.
    pub(super) value: Vec<f64>,
    /// Row of a block within the part of a column below its node's own block, for each block of the unknowns.
    block_offset: Vec<u32>,
}

impl SymmetricMatrix {
    /// A zero matrix with an entry for every pair of unknowns of nodes with an element in common.
    pub fn new(unknowns: &Unknowns) -> Self {
        let (mut column_start, mut row) = (vec![0], Vec::new());
        let mut block_offset = Vec::with_capacity(unknowns.block_row.len());
        for place in 0..unknowns.order().len() as u32 {
            let below = blocks_below(unknowns, place);
            let mut offset = 0;
            for other in below {
                block_offset.push(offset);
                offset += unknowns.axes(*other).count() as u32;
            }
            let (first, own) = (unknowns.first(place), unknowns.axes(place).count());
            for k in 0..own {
                row.extend(first + k..first + own);
                for other in below {
                    let first = unknowns.first(*other);
                    row.extend(first..first + unknowns.axes(*other).count());
                }
                column_start.push(row.len());
            }
        }
        let value = vec![0.0; row.len()];
        Self { column_start, row, value, block_offset }
    }

    /// Number of unknowns, rows and columns.
    pub fn size(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Number of entries of the lower triangle.
    pub fn entries(&self) -> usize {
        self.row.len()
    }

    /// Memory of pattern and values [bytes].
    pub fn memory(&self) -> usize {
        8 * (self.column_start.len() + self.row.len() + self.value.len()) + 4 * self.block_offset.len()
    }

    /// Sets the diagonal, and all other entries to zero.
    pub fn set_diagonal(&mut self, diagonal: &[f64]) {
        self.value.fill(0.0);
        for (start, d) in self.column_start.iter().zip(diagonal) {
            self.value[*start] = *d;
        }
    }

    /// Adds `factor` times the stiffness of the elements of a batch of a block.
    pub fn add_batch(
        &mut self,
        unknowns: &Unknowns,
        block: &ElementBlock,
        batch: usize,
        stiffness: &StiffnessBatch,
        factor: f64,
    ) {
        for slot in batch * BATCH..((batch + 1) * BATCH).min(block.elements.len()) {
            let nodes = block.nodes_of(slot);
            for a in 0..nodes.len() {
                for b in 0..=a {
                    let entries = &stiffness.0[corner_pair(a, b)];
                    let pair = std::array::from_fn(|i| factor * entries[i].0[slot % BATCH]);
                    self.add_pair(unknowns, (nodes[a], nodes[b]), &pair);
                }
            }
        }
    }

    /// Adds `factor · g gᵀ` of a nodal field g that is zero but for these nodes, each listed once.
    pub fn add_square(&mut self, unknowns: &Unknowns, factor: f64, g: &[(u32, Vec3)]) {
        for (i, (a, row)) in g.iter().enumerate() {
            for (b, column) in &g[..=i] {
                let pair = std::array::from_fn(|k| factor * row[k / 3] * column[k % 3]);
                self.add_pair(unknowns, (*a, *b), &pair);
            }
        }
    }

    /// Adds the 3×3 block (row by row) of the forces on one node due to displacements of another (or the same), and
    /// its transpose at the transposed position. Contributions of followers go to their masters: `Tᵀ K T`.
    pub fn add_pair(&mut self, unknowns: &Unknowns, (a, b): (u32, u32), pair: &[f64; 9]) {
        let followers = unknowns.followers();
        if ![a, b].iter().any(|node| followers.contains(*node as usize)) {
            return self.add_free_pair(unknowns, (a, b), pair);
        }
        for (i, (m, v)) in followers.movers(a).enumerate() {
            // For a node with itself, each pair of movers once, with both orders in it.
            let count = if a == b { i + 1 } else { usize::MAX };
            for (n, w) in followers.movers(b).take(count) {
                let mut block = pair.map(|entry| v * w * entry);
                if a != b && m == n {
                    block = std::array::from_fn(|k| block[k] + block[TRANSPOSED[k]]);
                }
                self.add_free_pair(unknowns, (m, n), &block);
            }
        }
    }

    /// As [`Self::add_pair`], for nodes that are no followers.
    fn add_free_pair(&mut self, unknowns: &Unknowns, (a, b): (u32, u32), pair: &[f64; 9]) {
        let (Some(row), Some(column)) = (unknowns.position(a), unknowns.position(b)) else { return };
        if row < column {
            let transposed = TRANSPOSED.map(|i| pair[i]);
            return self.add_below(unknowns, column, row, &transposed);
        }
        self.add_below(unknowns, row, column, pair);
    }

    fn add_below(&mut self, unknowns: &Unknowns, row: u32, column: u32, pair: &[f64; 9]) {
        let own = unknowns.axes(column).count();
        let offset = if row == column { None } else { Some(self.offset(unknowns, row, column)) };
        for (k, j) in unknowns.axes(column).enumerate() {
            let start = self.column_start[unknowns.first(column) + k];
            match offset {
                // On and below the diagonal of the node's own block.
                None => {
                    for (i, axis) in unknowns.axes(row).skip(k).enumerate() {
                        self.value[start + i] += pair[3 * axis + j];
                    }
                }
                Some(offset) => {
                    let start = start + (own - k) + offset;
                    for (i, axis) in unknowns.axes(row).enumerate() {
                        self.value[start + i] += pair[3 * axis + j];
                    }
                }
            }
        }
    }

    /// Number of rows between a column's own block and that of another node below it.
    fn offset(&self, unknowns: &Unknowns, row: u32, column: u32) -> usize {
        let start = unknowns.block_start[column as usize] as usize;
        let index = blocks_below(unknowns, column).partition_point(|other| *other < row);
        self.block_offset[start + index] as usize
    }

    /// Product `y = A x` with the full symmetric matrix.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for column in 0..self.size() {
            let range = self.column_start[column]..self.column_start[column + 1];
            let mut sum = self.value[range.start] * x[column];
            for i in range.start + 1..range.end {
                let (row, value) = (self.row[i], self.value[i]);
                y[row] += value * x[column];
                sum += value * x[row];
            }
            y[column] += sum;
        }
    }
}

/// Positions in the order of the blocks below the diagonal in the columns of `place`.
fn blocks_below(unknowns: &Unknowns, place: u32) -> &[u32] {
    let range =
        unknowns.block_start[place as usize] as usize..unknowns.block_start[place as usize + 1] as usize;
    &unknowns.block_row[range]
}
