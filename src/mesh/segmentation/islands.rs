//! Removal of noise: small groups of voxels that no other of their class touches.

use super::grid::{ClassGrid, OUTSIDE};
use super::volume::{Frame, LabelVolume};

/// Number of voxels below which a group is noise, unless a scene says otherwise.
pub const NOISE_VOXELS: f64 = 30.0;

/// Whether each voxel of a scan belongs to the body, the first axis fastest: it has a label other than 0, groups that are noise
/// apart, unless all are.
pub fn body_of(volume: &LabelVolume, frame: &Frame) -> Vec<bool> {
    let class_of: Vec<u8> = volume.values.iter().map(|value| u8::from(*value != 0)).collect();
    let grid = ClassGrid::new(volume, frame, [[0; 3], frame.dims], &class_of);
    let mut without = grid.clone();
    remove_islands(&mut without, NOISE_VOXELS as usize);
    let has_label = || grid.classes.iter().map(|class| *class != OUTSIDE);
    let kept = has_label().zip(&without.classes).map(|(has_label, class)| has_label && *class != OUTSIDE);
    let kept: Vec<bool> = kept.collect();
    if kept.contains(&true) { kept } else { has_label().collect() }
}

/// Gives every group of fewer than `least` voxels of one class, connected over faces, the class that most of its faces touch.
/// Returns the number of voxels that changed.
pub fn remove_islands(grid: &mut ClassGrid, least: usize) -> usize {
    let mut is_seen = vec![false; grid.classes.len()];
    let (mut island, mut changed) = (Vec::new(), 0);
    for start in 0..grid.classes.len() {
        if is_seen[start] {
            continue;
        }
        let class = grid.classes[start];
        let mut touched = vec![0_usize; grid.count];
        island.clear();
        island.push(start);
        is_seen[start] = true;
        let mut next = 0;
        while let Some(&voxel) = island.get(next) {
            next += 1;
            for other in neighbours(grid.dims, voxel).into_iter().flatten() {
                if grid.classes[other] != class {
                    touched[usize::from(grid.classes[other])] += 1;
                } else if !is_seen[other] {
                    is_seen[other] = true;
                    island.push(other);
                }
            }
        }
        if island.len() >= least {
            continue;
        }
        let most = (0..grid.count).max_by_key(|&c| (touched[c], grid.count - c)).unwrap_or(0);
        if touched[most] > 0 {
            changed += island.len();
            for voxel in &island {
                grid.classes[*voxel] = most as u8;
            }
        }
    }
    changed
}

/// The voxels beyond the six faces of one.
fn neighbours(dims: [usize; 3], voxel: usize) -> [Option<usize>; 6] {
    let [nx, ny, nz] = dims;
    let (i, j, k) = (voxel % nx, voxel / nx % ny, voxel / (nx * ny));
    [
        (i > 0).then(|| voxel - 1),
        (i + 1 < nx).then(|| voxel + 1),
        (j > 0).then(|| voxel - nx),
        (j + 1 < ny).then(|| voxel + nx),
        (k > 0).then(|| voxel - nx * ny),
        (k + 1 < nz).then(|| voxel + nx * ny),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_voxels_take_the_class_around_them_and_large_groups_stay() {
        let mut grid =
            ClassGrid { dims: [6, 6, 6], spacing: [1.0; 3], classes: vec![1; 216], count: 3, first: [0; 3] };
        (0..108).for_each(|i| grid.classes[i] = 0);
        let clean = grid.classes.clone();
        // One inside each half, and two that are connected over an edge only.
        for voxel in [43, 150, 157] {
            grid.classes[voxel] = 2;
        }
        assert_eq!(remove_islands(&mut grid, 2), 3);
        assert_eq!(grid.classes, clean);
    }
}
