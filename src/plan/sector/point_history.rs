//! Where the numbers that a point of the whole remembers come from.

use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;

/// Planes of the components xy, yz, xz of a symmetric tensor, of which a reflection changes the sign of two.
const SHEARS: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// Where the numbers that a point of the whole remembers come from.
#[derive(Clone, Copy, Debug)]
pub(in crate::plan) struct PointHistory {
    /// Chunk, first row and lane, in what is copied to, the whole, and in what is copied from, the sector.
    pub to: (usize, usize, usize),
    pub from: (usize, usize, usize),
    /// Number of symmetric tensors that they begin with, and of all numbers.
    pub tensors: usize,
    pub count: usize,
    /// Image that the point belongs to.
    pub image: u8,
}

impl PointHistory {
    /// Copies the numbers of a point; `signs` are those of the components of a vector.
    pub fn copy(&self, signs: &Vec3, from_all: &[Vec<Row>], to_all: &mut [Vec<Row>]) {
        let Self { to: (chunk, row, lane), from: (from_chunk, from_row, from_lane), .. } = *self;
        for number in 0..self.count {
            let is_shear = number < 6 * self.tensors && number % 6 >= 3;
            let sign =
                if is_shear { SHEARS[number % 6 - 3].map(|axis| signs[axis]).iter().product() } else { 1.0 };
            to_all[chunk][row + number].0[lane] = sign * from_all[from_chunk][from_row + number].0[from_lane];
        }
    }
}
