//! Removal of noise: small groups of voxels that no other of their class touches.

use super::grid::ClassGrid;

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
