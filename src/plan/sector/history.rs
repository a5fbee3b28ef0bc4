//! The history of the points of the whole from that of the points that they mirror.

use super::images::Images;
use crate::mechanics::force::ElementBlock;
use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;

/// Planes of the components xy, yz, xz of a symmetric tensor, of which a reflection changes the sign of two.
const SHEARS: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// Where the numbers that a point of the whole remembers come from.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointHistory {
    /// Chunk, first row and lane, in the whole and in the sector.
    to: (usize, usize, usize),
    from: (usize, usize, usize),
    /// Number of symmetric tensors that they begin with, and of all numbers.
    tensors: usize,
    count: usize,
    /// Image that the point belongs to.
    pub image: u8,
}

impl PointHistory {
    /// Copies the numbers of a point; `signs` are those of the components of a vector.
    pub fn copy(&self, signs: &Vec3, of_sector: &[Vec<Row>], whole: &mut [Vec<Row>]) {
        let Self { to: (chunk, row, lane), from: (from_chunk, from_row, from_lane), .. } = *self;
        for number in 0..self.count {
            let is_shear = number < 6 * self.tensors && number % 6 >= 3;
            let sign =
                if is_shear { SHEARS[number % 6 - 3].map(|axis| signs[axis]).iter().product() } else { 1.0 };
            whole[chunk][row + number].0[lane] = sign * of_sector[from_chunk][from_row + number].0[from_lane];
        }
    }
}

/// The points of all elements that remember; `None` if one has no counterpart.
pub(super) fn histories(
    whole: &Plan,
    sector: &Plan,
    elements: &[Vec<u32>],
    images: &Images,
) -> Option<Vec<PointHistory>> {
    let (of_whole, of_sector) = (slots(whole), slots(sector));
    let mut points = Vec::new();
    for (element, in_images) in elements.iter().enumerate() {
        let (source, slot) = of_sector[element];
        let remembers = source.parameters.has_memory();
        for (image, mirrored) in in_images.iter().enumerate().filter(|_| remembers) {
            let (block, place) = of_whole[*mirrored as usize];
            if block.parameters != source.parameters {
                return None;
            }
            for point in 0..block.memory_points() {
                let of_source = if block.memory_points() == 1 {
                    0
                } else {
                    {
                        let x = block.point_position(place, point, &whole.X);
                        nearest_point(source, slot, &sector.X, &images.image_of_point(x, image))?
                    }
                };
                points.push(PointHistory {
                    to: block.place_of_history(place, point),
                    from: source.place_of_history(slot, of_source),
                    tensors: block.parameters.memory.tensor_count(),
                    count: block.parameters.history_len(),
                    image: image as u8,
                });
            }
        }
    }
    Some(points)
}

/// Block and slot of every element.
fn slots(plan: &Plan) -> Vec<(&ElementBlock, usize)> {
    let in_block = |block| ElementBlock::numbered(block).map(move |(slot, element)| (element, (block, slot)));
    let mut all: Vec<(u32, (&ElementBlock, usize))> = plan.blocks.iter().flat_map(in_block).collect();
    all.sort_unstable_by_key(|(element, _)| *element);
    all.into_iter().map(|(_, place)| place).collect()
}

/// The point of an element nearest to a place [m], at reference positions `X` [m].
fn nearest_point(block: &ElementBlock, slot: usize, X: &[Vec3], place: &Vec3) -> Option<usize> {
    let distance = |point: usize| (block.point_position(slot, point, X) - place).norm_squared();
    (0..block.memory_points()).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
}
