//! The part of a label volume that is meshed: the class of each voxel, along the axes of the scan.

use super::volume::{Frame, LabelVolume};
use crate::mechanics::tensor::Vec3;

/// What lies outside of the mesh.
pub const OUTSIDE: u8 = 0;

/// Classes of the voxels of a box. Positions are in metres from its low corner, along the axes of the scan.
#[derive(Clone, Debug)]
pub struct ClassGrid {
    /// Number of voxels along each axis.
    pub dims: [usize; 3],
    /// Distance of voxels along each axis [m].
    pub spacing: [f64; 3],
    /// Class of each voxel, the first axis fastest; [`OUTSIDE`] or larger.
    pub classes: Vec<u8>,
    /// Number of classes, with the outside.
    pub count: usize,
    /// Voxel of the scan at the low corner; negative where the box begins before the scan.
    pub first: [i64; 3],
}

impl ClassGrid {
    /// The voxels `low..high` of a volume along the axes of its frame; `class_of` has the class of each index of its labels.
    pub fn new(volume: &LabelVolume, frame: &Frame, [low, high]: [[usize; 3]; 2], class_of: &[u8]) -> Self {
        let dims = [0, 1, 2].map(|k| high[k] - low[k]);
        let mut classes = Vec::with_capacity(dims.iter().product());
        for k in low[2]..high[2] {
            for j in low[1]..high[1] {
                let row = (low[0]..high[0]).map(|i| volume.labels[frame.index([i, j, k])]);
                classes.extend(row.map(|label| class_of[usize::from(label)]));
            }
        }
        let count = 1 + class_of.iter().copied().max().map_or(0, usize::from);
        Self { dims, spacing: frame.spacing, classes, count, first: low.map(|n| n as i64) }
    }

    /// The voxels `low..high` of this grid; those beyond it are outside.
    #[must_use]
    pub fn resized(&self, [low, high]: [[i64; 3]; 2]) -> Self {
        let dims = [0, 1, 2].map(|k| (high[k] - low[k]).max(0) as usize);
        let mut classes = Vec::with_capacity(dims.iter().product());
        let is_in = |n: i64, k: usize| (0..self.dims[k] as i64).contains(&n);
        for k in low[2]..high[2] {
            for j in low[1]..high[1] {
                let has_row = is_in(k, 2) && is_in(j, 1);
                let voxel = |i: i64| if has_row && is_in(i, 0) { self.class([i, j, k]) } else { OUTSIDE };
                classes.extend((low[0]..high[0]).map(voxel));
            }
        }
        let first = [0, 1, 2].map(|k| self.first[k] + low[k]);
        Self { dims, classes, first, ..*self }
    }

    /// Fraction of the faces between two voxels, not both outside, on which their classes differ [-]: small where regions are
    /// larger than voxels, and near 1 in noise.
    pub fn roughness(&self) -> f64 {
        let [mut faces, mut different] = [0_u64; 2];
        for [class, other] in self.faces() {
            faces += u64::from(class != OUTSIDE || other != OUTSIDE);
            different += u64::from(class != other);
        }
        different as f64 / faces.max(1) as f64
    }

    /// The same of each class: the fraction of the faces of its voxels that are to others; 0 for a class without voxels.
    pub fn roughness_of_classes(&self) -> Vec<f64> {
        let mut counts = vec![[0_u64; 2]; self.count];
        for pair in self.faces() {
            for class in pair {
                let [faces, different] = &mut counts[usize::from(class)];
                *faces += 1;
                *different += u64::from(pair[0] != pair[1]);
            }
        }
        let fraction = |[faces, n]: [u64; 2]| n as f64 / faces.max(1) as f64;
        counts.into_iter().map(fraction).collect()
    }

    /// The classes on both sides of each face between two voxels.
    fn faces(&self) -> impl Iterator<Item = [u8; 2]> {
        let strides = [1, self.dims[0], self.dims[0] * self.dims[1]];
        self.classes.iter().enumerate().flat_map(move |(index, class)| {
            let voxel = [index % strides[1], index / strides[1] % self.dims[1], index / strides[2]];
            let beside = (0..3).filter(move |axis| voxel[*axis] + 1 < self.dims[*axis]);
            beside.map(move |axis| [*class, self.classes[index + strides[axis]]])
        })
    }

    /// Lengths of the box [m].
    pub fn lengths(&self) -> Vec3 {
        Vec3::from_fn(|k, _| self.dims[k] as f64 * self.spacing[k])
    }

    /// Largest distance of voxels along an axis [m].
    pub fn coarsest(&self) -> f64 {
        self.spacing.into_iter().fold(0.0, f64::max)
    }

    /// Class of a voxel; beyond the box, that of the nearest voxel.
    pub fn class(&self, voxel: [i64; 3]) -> u8 {
        let [i, j, k] = [0, 1, 2].map(|a| voxel[a].clamp(0, self.dims[a] as i64 - 1) as usize);
        self.classes[i + self.dims[0] * (j + self.dims[1] * k)]
    }

    /// Class at a position [m].
    pub fn class_at(&self, p: &Vec3) -> u8 {
        self.class([0, 1, 2].map(|k| (p[k] / self.spacing[k]).floor() as i64))
    }

    /// Volume of the voxels of each class [m³].
    pub fn volumes_m3(&self) -> Vec<f64> {
        let mut counts = vec![0_u64; self.count];
        self.classes.iter().for_each(|class| counts[usize::from(*class)] += 1);
        let voxel: f64 = self.spacing.iter().product();
        counts.into_iter().map(|count| count as f64 * voxel).collect()
    }

    /// Voxels `low..high` of the smallest box with everything that is not outside; `None` if there is nothing.
    pub fn occupied(&self) -> Option<[[usize; 3]; 2]> {
        let mut bounds: Option<[[usize; 3]; 2]> = None;
        for (row, classes) in self.classes.chunks(self.dims[0]).enumerate() {
            let is_inside = |class: &u8| *class != OUTSIDE;
            let Some(first) = classes.iter().position(is_inside) else { continue };
            let last = classes.iter().rposition(is_inside).unwrap_or(first);
            let (j, k) = (row % self.dims[1], row / self.dims[1]);
            let [low, high] = bounds.get_or_insert([[first, j, k], [last + 1, j + 1, k + 1]]);
            for (a, (from, to)) in [(first, last), (j, j), (k, k)].into_iter().enumerate() {
                low[a] = low[a].min(from);
                high[a] = high[a].max(to + 1);
            }
        }
        bounds
    }
}
