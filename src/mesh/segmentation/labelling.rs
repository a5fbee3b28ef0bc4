//! The class of each leaf of an octree, and its repair where single leaves would make a surface that touches itself.

use super::grid::ClassGrid;
use super::octree::{Leaf, Octree};
use crate::mechanics::tensor::Vec3;

/// Beyond the box that is meshed.
pub const BEYOND: u8 = u8::MAX;

/// Samples along an edge of a leaf, at least and at most.
const SAMPLES: [f64; 2] = [2.0, 6.0];

/// Passes of the repairs.
const PASSES: usize = 6;

/// Fraction of the volume of a piece of a class that is left, below which it is not outvoted [-].
const LEAST_LEFT: f64 = 0.75;

/// Number of the six faces of a leaf behind which another class begins, from which it takes that class.
const OUTVOTED: f64 = 3.5;

/// Fraction of the volume of a leaf that each class has, by samples at the centres of equal boxes.
pub fn fractions(grid: &ClassGrid, [low, high]: [Vec3; 2], out: &mut Vec<f64>) {
    out.clear();
    out.resize(grid.count, 0.0);
    let size = high - low;
    let counts = [0, 1, 2].map(|k| (size[k] / grid.spacing[k]).ceil().clamp(SAMPLES[0], SAMPLES[1]));
    let part = 1.0 / (counts[0] * counts[1] * counts[2]);
    let [nx, ny, nz] = counts.map(|n| n as usize);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let place = [i, j, k].map(|n| n as f64 + 0.5);
                let p = Vec3::from_fn(|a, _| low[a] + size[a] * place[a] / counts[a]);
                out[usize::from(grid.class_at(&p))] += part;
            }
        }
    }
}

/// The class of each leaf: the one with most of its volume; of leaves near the size of voxels, by the smooth indicators.
pub fn classes(grid: &ClassGrid, tree: &Octree) -> Vec<u8> {
    let (mut fraction, mut indicators) = (Vec::new(), Vec::new());
    let class_of = |leaf: &Leaf| {
        let [low, high] = tree.bounds(*leaf);
        fractions(grid, [low, high], &mut fraction);
        let is_mixed = fraction.iter().filter(|f| **f > 0.0).count() > 1;
        if is_mixed && (high - low).min() < 4.0 * grid.coarsest() {
            fraction.fill(0.0);
            for octant in 0..8_u32 {
                let at = Vec3::from_fn(|k, _| 0.25 + 0.5 * f64::from(octant >> k & 1));
                grid.indicators(&(low + (high - low).component_mul(&at)), 0.0, &mut indicators);
                fraction.iter_mut().zip(&indicators).for_each(|(sum, found)| *sum += found.value);
            }
        }
        // Of equal ones, the first.
        (0..grid.count).rev().max_by(|a, b| fraction[*a].total_cmp(&fraction[*b])).unwrap_or(0) as u8
    };
    tree.leaves.iter().map(class_of).collect()
}

/// Classes without leaves that most of their neighbours outvote, and without a surface of the parts that touches itself at an
/// edge or a node, or ends on a coarse face. `is_part` is false for what will be void. Returns the number of leaves that changed.
pub fn repair(tree: &Octree, classes: &mut [u8], is_part: &[bool]) -> usize {
    let before = classes.to_vec();
    (0..2).for_each(|_| outvote(tree, classes));
    restore(tree, &before, classes);
    for _ in 0..PASSES {
        let has_filled = fill_behind_coarse(tree, classes, is_part);
        if !separate(tree, classes, is_part) && !has_filled {
            break;
        }
    }
    before.iter().zip(&*classes).filter(|(a, b)| a != b).count()
}

/// Gives a leaf the class that begins behind most of its faces.
fn outvote(tree: &Octree, classes: &mut [u8]) {
    let before = classes.to_vec();
    for (i, leaf) in tree.leaves.iter().enumerate() {
        let mut votes: Vec<(u8, f64)> = Vec::new();
        for side in 0..6 {
            let behind = behind(tree, *leaf, side);
            for other in &behind {
                let class = other.map_or(before[i], |other| before[other]);
                let vote = 1.0 / behind.len() as f64;
                match votes.iter_mut().find(|(known, _)| *known == class) {
                    Some((_, sum)) => *sum += vote,
                    None => votes.push((class, vote)),
                }
            }
        }
        if let Some((class, _)) = votes.iter().find(|(class, sum)| *class != before[i] && *sum > OUTVOTED) {
            classes[i] = *class;
        }
    }
}

/// Gives pieces of a class, connected over faces, their leaves of `before` back, if those that outvoted some would take too much: of a
/// region of three leaves across, the neighbours outvote one layer after the other. Single leaves stay outvoted.
fn restore(tree: &Octree, before: &[u8], classes: &mut [u8]) {
    let mut is_seen = vec![false; before.len()];
    for start in 0..before.len() {
        let class = before[start];
        if class == classes[start] || std::mem::replace(&mut is_seen[start], true) {
            continue;
        }
        let mut piece = vec![start];
        let mut next = 0;
        while let Some(&leaf) = piece.get(next) {
            next += 1;
            for other in (0..6).flat_map(|side| behind(tree, tree.leaves[leaf], side)).flatten() {
                if before[other] == class && !std::mem::replace(&mut is_seen[other], true) {
                    piece.push(other);
                }
            }
        }
        let volume = |leaf: &usize| f64::from(tree.size(tree.leaves[*leaf].level)).powi(3);
        let whole: f64 = piece.iter().map(volume).sum();
        let left: f64 = piece.iter().filter(|leaf| classes[**leaf] == class).map(volume).sum();
        if piece.len() > 1 && left < LEAST_LEFT * whole {
            for leaf in piece {
                classes[leaf] = class;
            }
        }
    }
}

/// The leaves behind a face (2 axis + 1 where it is the high one): one, or the four finer ones; `None` beyond the box.
pub fn behind(tree: &Octree, leaf: Leaf, side: usize) -> Vec<Option<usize>> {
    let size = i64::from(tree.size(leaf.level));
    let (axis, is_high) = (side / 2, side % 2 == 1);
    let mut cell = leaf.at.map(i64::from);
    cell[axis] += if is_high { size } else { -1 };
    let first = tree.leaf_at(cell);
    if first.is_none_or(|other| tree.leaves[other].level <= leaf.level) {
        return vec![first];
    }
    let half = |quarter: i64, k: usize| if k == (axis + 1) % 3 { quarter % 2 } else { quarter / 2 };
    let at =
        |quarter: i64| [0, 1, 2].map(|k| cell[k] + if k == axis { 0 } else { size / 2 * half(quarter, k) });
    (0..4).map(|quarter| tree.leaf_at(at(quarter))).collect()
}

/// Gives the class of a coarse leaf of a part to the finer voids behind its face or edge, if there are other parts behind it: the
/// middle hangs, so that it could not be moved onto a surface. Returns whether there were any.
fn fill_behind_coarse(tree: &Octree, classes: &mut [u8], is_part: &[bool]) -> bool {
    let mut has_changed = false;
    for (i, leaf) in tree.leaves.iter().enumerate() {
        if !is_part[usize::from(classes[i])] {
            continue;
        }
        for side in 0..18 {
            let finer = if side < 6 {
                behind(tree, *leaf, side).into_iter().flatten().collect()
            } else {
                behind_edge(tree, *leaf, side - 6)
            };
            let is_void = |other: &usize| !is_part[usize::from(classes[*other])];
            let voids: Vec<usize> = finer.iter().copied().filter(is_void).collect();
            if finer.len() > 1 && (1..finer.len()).contains(&voids.len()) {
                has_changed = true;
                let class = classes[i];
                for other in voids {
                    classes[other] = class;
                }
            }
        }
    }
    has_changed
}

/// The two finer leaves behind an edge (4 axis + 2 where it is high along the next axis + 1 along the one after it); none where
/// there is one that is not finer.
fn behind_edge(tree: &Octree, leaf: Leaf, edge: usize) -> Vec<usize> {
    let size = i64::from(tree.size(leaf.level));
    let (axis, highs) = (edge / 4, [edge / 2 % 2, edge % 2]);
    let mut cell = leaf.at.map(i64::from);
    for (k, high) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().zip(highs) {
        cell[k] += if high == 1 { size } else { -1 };
    }
    let mut other = cell;
    other[axis] += size / 2;
    let finer = [cell, other].map(|cell| tree.leaf_at(cell).filter(|i| tree.leaves[*i].level > leaf.level));
    finer.into_iter().flatten().collect()
}

/// Fills octants around nodes where the parts, or the voids, are not connected over faces. Returns whether any was.
fn separate(tree: &Octree, classes: &mut [u8], is_part: &[bool]) -> bool {
    let mut has_changed = false;
    for i in 0..tree.leaves.len() {
        let leaf = tree.leaves[i];
        let size = tree.size(leaf.level);
        for corner in 0..8 {
            let around = tree.around([0, 1, 2].map(|k| leaf.at[k] + size * (corner >> k & 1)));
            let class = |octant: usize| around[octant].map_or(BEYOND, |leaf| classes[leaf]);
            let kinds: [u8; 8] = std::array::from_fn(|octant| match class(octant) {
                BEYOND => 2,
                class => u8::from(is_part[usize::from(class)]),
            });
            if pieces(kinds, 1) <= 1 && pieces(kinds, 0) <= 1 {
                continue;
            }
            // The void octants next to one of a part take its class.
            let next = |octant: usize| {
                let inside = [1, 2, 4].map(|step| octant ^ step);
                inside.into_iter().find(|other| kinds[*other] == 1).map(class)
            };
            let filled: Vec<(usize, u8)> = (0..8)
                .filter(|octant| kinds[*octant] == 0)
                .filter_map(|octant| Some((around[octant]?, next(octant)?)))
                .collect();
            has_changed |= !filled.is_empty();
            for (leaf, class) in filled {
                classes[leaf] = class;
            }
        }
    }
    has_changed
}

/// Number of pieces, connected over faces, of the octants of a kind; octants beyond the box connect as if they were of it.
fn pieces(kinds: [u8; 8], kind: u8) -> usize {
    let belongs = |octant: usize| kinds[octant] == kind || kinds[octant] == 2;
    let (mut seen, mut count) = ([false; 8], 0);
    for start in 0..8 {
        if kinds[start] != kind || seen[start] {
            continue;
        }
        count += 1;
        let mut open = vec![start];
        seen[start] = true;
        while let Some(octant) = open.pop() {
            for other in [1, 2, 4].map(|step| octant ^ step) {
                if belongs(other) && !seen[other] {
                    seen[other] = true;
                    open.push(other);
                }
            }
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::super::grid::OUTSIDE;
    use super::*;

    #[test]
    fn octants_that_touch_at_an_edge_are_two_pieces() {
        assert_eq!(pieces([1, 0, 0, 1, 0, 0, 0, 0], 1), 2);
        assert_eq!(pieces([1, 1, 0, 1, 0, 0, 0, 0], 1), 1);
        assert_eq!(pieces([1, 0, 0, 0, 0, 0, 0, 1], 0), 1);
        assert_eq!(pieces([1, 2, 2, 1, 0, 0, 0, 0], 1), 1);
    }

    #[test]
    fn an_edge_that_two_leaves_touch_is_filled_and_a_spike_goes() {
        let tree = Octree::new([4, 4, 4], &Vec3::new(1.0, 1.0, 1.0), 0);
        let at = |i: usize, j: usize, k: usize| i + 4 * (j + 4 * k);
        // Two layers of which one has a diagonal gap, and a single leaf on top.
        let mut classes = vec![OUTSIDE; 64];
        for j in 0..4 {
            for i in 0..4 {
                classes[at(i, j, 0)] = 1;
                if (i < 2) == (j < 2) {
                    classes[at(i, j, 1)] = 1;
                }
            }
        }
        classes[at(0, 0, 2)] = 1;
        repair(&tree, &mut classes, &[false, true]);
        assert!(!separate(&tree, &mut classes, &[false, true]));
        assert_eq!(classes[at(3, 0, 2)], OUTSIDE);
        assert_eq!(classes[at(0, 0, 1)], 1);
    }
}
