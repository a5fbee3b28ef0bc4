//! Broad phase over bodies: which of many boxes meet.

use super::broad_phase::to_parry;
use crate::tensor::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

/// Places of every two boxes (low and high corner [m]) that meet, the first smaller than the second, ascending.
pub fn meeting(boxes: &[[Vec3; 2]]) -> Vec<(usize, usize)> {
    let boxes: Vec<Aabb> = boxes.iter().map(|[low, high]| Aabb::new(to_parry(low), to_parry(high))).collect();
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let mut found = Vec::new();
    for (first, around) in boxes.iter().enumerate() {
        let others = tree.intersect_aabb(around).map(|second| second as usize);
        found.extend(others.filter(|second| *second > first).map(|second| (first, second)));
    }
    found.sort_unstable();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_that_meet_are_found_each_once() {
        // Places of a row of boxes of length 1.5 that begin at 0, 1, 2, ...
        let at = |i: u32| [Vec3::x() * f64::from(i), Vec3::new(f64::from(i) + 1.5, 1.0, 1.0)];
        let row: Vec<[Vec3; 2]> = (0..100).map(at).collect();
        let expected: Vec<(usize, usize)> = (0..99).map(|i| (i, i + 1)).collect();
        assert_eq!(meeting(&row), expected);
        assert_eq!((meeting(&[]), meeting(&row[..1])), (Vec::new(), Vec::new()));
    }
}
