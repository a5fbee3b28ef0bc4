//! The history of the points of the whole from that of the points that they mirror.

use super::images::Images;
use super::point_history::PointHistory;
use crate::mechanics::force::ElementBlock;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;

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
