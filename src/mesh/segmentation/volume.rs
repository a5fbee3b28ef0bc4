//! A label volume: one label for each voxel of a regular grid, and where the grid lies.

use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::MeshError;
use serde::Serialize;
use std::collections::BTreeMap;

/// Largest number of different labels: more are the grey values of an image.
pub const MOST_LABELS: usize = 1000;

/// Largest cosine of the angle between two axes of a voxel grid: 0.06° off a right angle, more than rounding of a header.
const LARGEST_COSINE: f64 = 1e-3;

/// A scan whose voxels are labelled.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelVolume {
    /// Number of voxels along each axis of the file; the first index varies fastest.
    pub dims: [usize; 3],
    /// Label of each voxel, as an index into `values`.
    pub labels: Vec<u16>,
    /// The labels, ascending; 0, which is the outside, is always there.
    pub values: Vec<i64>,
    /// Names of labels, where the file has them.
    pub names: BTreeMap<i64, String>,
    /// Centre of the first voxel [m].
    pub origin: Vec3,
    /// Step from one voxel to the next along each axis of the file [m].
    pub steps: [Vec3; 3],
    /// Remarks on what was assumed.
    pub notes: Vec<String>,
}

/// A label of a volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LabelCount {
    /// The label, as the file has it; 0 is outside.
    pub label: i64,
    /// Its name, where the file has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Number of voxels with this label.
    pub voxels: u64,
    /// Volume of these voxels [m³].
    pub volume_m3: f64,
    /// Lower and upper corner of the bounding box of these voxels [m].
    pub bounding_box_m: [[f64; 3]; 2],
    /// Mean of their centres [m].
    pub centre_m: [f64; 3],
}

impl LabelCount {
    /// Name of its part: that of the file, else `label_<n>`.
    pub fn part(&self) -> String {
        self.name.clone().unwrap_or_else(|| format!("label_{}", self.label))
    }
}

/// The axes of a volume, renamed and turned round so that they are right-handed and as near to x, y, z as they can be.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Number of voxels along each axis.
    pub dims: [usize; 3],
    /// Distance of voxels along each axis [m].
    pub spacing: [f64; 3],
    /// Index of the voxel at the low corner, and its change along each axis.
    pub first: usize,
    /// Change of the index along each axis.
    pub strides: [isize; 3],
    /// Unit vectors along the axes, as columns.
    pub rotation: Mat3,
    /// Low corner of the grid: of its first voxel, not the centre of that [m].
    pub corner: Vec3,
}

impl LabelVolume {
    /// Volume of a voxel [m³].
    pub fn voxel_m3(&self) -> f64 {
        Mat3::from_columns(&self.steps).determinant().abs()
    }

    /// Distances of neighbouring voxels along the axes of the file [m].
    pub fn spacing_m(&self) -> [f64; 3] {
        self.steps.map(|step| step.norm())
    }

    /// The labels that occur, ascending, with the number of voxels of each and where they are.
    pub fn counts(&self) -> Vec<LabelCount> {
        /// Number, and along each axis sum, smallest and largest of the indices.
        #[derive(Clone, Default)]
        struct Found(u64, [u64; 3], Option<[[usize; 3]; 2]>);
        let mut found = vec![Found::default(); self.values.len()];
        let [nx, ny, _] = self.dims;
        for (row, labels) in self.labels.chunks_exact(nx.max(1)).enumerate() {
            let [j, k] = [row % ny, row / ny];
            for (i, label) in labels.iter().enumerate() {
                let Found(count, sums, range) = &mut found[usize::from(*label)];
                let [low, high] = range.get_or_insert([[i, j, k]; 2]);
                *count += 1;
                for (axis, index) in [i, j, k].into_iter().enumerate() {
                    sums[axis] += index as u64;
                    low[axis] = low[axis].min(index);
                    high[axis] = high[axis].max(index);
                }
            }
        }
        let of_label = |(label, Found(voxels, sums, range)): (&i64, Found)| {
            range.map(|[low, high]| LabelCount {
                label: *label,
                name: self.names.get(label).cloned(),
                voxels,
                volume_m3: voxels as f64 * self.voxel_m3(),
                bounding_box_m: self.box_m(low, high),
                centre_m: self.place(sums.map(|sum| sum as f64 / voxels as f64)).into(),
            })
        };
        self.values.iter().zip(found).filter_map(of_label).collect()
    }

    /// The position of a voxel, or between voxels, by its indices along the axes of the file [m].
    fn place(&self, indices: [f64; 3]) -> Vec3 {
        self.origin + self.steps.iter().zip(indices).map(|(step, n)| step * n).sum::<Vec3>()
    }

    /// Lower and upper corner of the box along x, y, z around the voxels between two, which count [m].
    fn box_m(&self, low: [usize; 3], high: [usize; 3]) -> [[f64; 3]; 2] {
        let corner = |i: usize| {
            let end = |k: usize| if i >> k & 1 == 1 { high[k] as f64 + 0.5 } else { low[k] as f64 - 0.5 };
            self.place([end(0), end(1), end(2)])
        };
        let fold = |f: fn(&Vec3, &Vec3) -> Vec3| (1..8).map(corner).fold(corner(0), |a, b| f(&a, &b));
        [fold(Vec3::inf).into(), fold(Vec3::sup).into()]
    }

    /// The axes nearest to x, y, z.
    ///
    /// # Errors
    /// `Unsupported` where the axes of the file are not at right angles.
    pub fn frame(&self) -> Result<Frame, MeshError> {
        let spacing = self.spacing_m();
        let unit: Vec<Vec3> = self.steps.iter().zip(spacing).map(|(step, length)| step / length).collect();
        let skew = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| unit[i].dot(&unit[j]).abs());
        if !skew.iter().all(|cosine| *cosine <= LARGEST_COSINE) {
            return Err(MeshError::Unsupported {
                what: format!(
                    "a voxel grid whose axes are not at right angles (cosines {skew:.4?}, at most {LARGEST_COSINE})"
                ),
                remedy: "resample the labels on a grid without shear".into(),
            });
        }
        let order = nearest_axes(&unit);
        let mut frame = Frame {
            dims: order.map(|axis| self.dims[axis]),
            spacing: order.map(|axis| spacing[axis]),
            first: 0,
            strides: [0; 3],
            rotation: Mat3::identity(),
            corner: self.origin,
        };
        let file_strides = [1, self.dims[0], self.dims[0] * self.dims[1]];
        let mut columns = [Vec3::zeros(); 3];
        for (k, &axis) in order.iter().enumerate() {
            let is_reversed = unit[axis][k] < 0.0;
            let stride = file_strides[axis] as isize;
            columns[k] = if is_reversed { -unit[axis] } else { unit[axis] };
            frame.strides[k] = if is_reversed { -stride } else { stride };
            if is_reversed {
                frame.first += file_strides[axis] * (self.dims[axis] - 1);
                frame.corner += self.steps[axis] * (self.dims[axis] - 1) as f64;
            }
        }
        // Exactly orthonormal and right-handed: the third axis follows from the first two.
        columns[0] = columns[0].normalize();
        columns[1] = (columns[1] - columns[0] * columns[0].dot(&columns[1])).normalize();
        columns[2] = columns[0].cross(&columns[1]);
        frame.rotation = Mat3::from_columns(&columns);
        let half = Vec3::from(frame.spacing) * 0.5;
        frame.corner -= frame.rotation * half;
        Ok(frame)
    }
}

/// The permutation of the axes for which the sum of |eᵢ · axisᵢ| is largest.
fn nearest_axes(unit: &[Vec3]) -> [usize; 3] {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let fit =
        |order: &[usize; 3]| order.iter().enumerate().map(|(k, &axis)| unit[axis][k].abs()).sum::<f64>();
    orders.into_iter().max_by(|a, b| fit(a).total_cmp(&fit(b))).unwrap_or([0, 1, 2])
}

/// Contents of a scan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScanInspection {
    /// Number of voxels along each axis of the file.
    pub voxels: [usize; 3],
    /// Distance of voxels along each axis of the file [m].
    pub spacing_m: [f64; 3],
    /// Lower and upper corner of the bounding box of all voxels [m].
    pub bounding_box_m: [[f64; 3]; 2],
    /// The labels that occur.
    pub labels: Vec<LabelCount>,
    /// Notes of the reader.
    pub notes: Vec<String>,
}

impl ScanInspection {
    /// Size, spacing and labels of a volume; the bounding box is that of the voxels, not of their centres.
    pub fn of(volume: &LabelVolume) -> Self {
        Self {
            voxels: volume.dims,
            spacing_m: volume.spacing_m(),
            bounding_box_m: volume.box_m([0; 3], volume.dims.map(|n| n.saturating_sub(1))),
            labels: volume.counts(),
            notes: volume.notes.clone(),
        }
    }
}

impl Frame {
    /// A position of the world [m] along the axes, from the low corner [m].
    pub fn local(&self, world: &Vec3) -> Vec3 {
        self.rotation.transpose() * (world - self.corner)
    }

    /// The position in the world [m] of one along the axes.
    pub fn world(&self, local: &Vec3) -> Vec3 {
        self.corner + self.rotation * local
    }

    /// All voxels, by their indices, the first axis fastest.
    pub fn voxels(&self) -> impl Iterator<Item = [usize; 3]> {
        let [nx, ny, nz] = self.dims;
        (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
    }

    /// Lengths of the whole grid [m].
    pub fn lengths(&self) -> Vec3 {
        Vec3::from_fn(|k, _| self.dims[k] as f64 * self.spacing[k])
    }

    /// Index of a voxel.
    pub fn index(&self, voxel: [usize; 3]) -> usize {
        let along: isize = (0..3).map(|k| voxel[k] as isize * self.strides[k]).sum();
        self.first.wrapping_add_signed(along)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    /// 2 × 3 × 4 voxels whose axes run along −y, z and −x.
    fn turned() -> LabelVolume {
        LabelVolume {
            dims: [2, 3, 4],
            labels: (0..24).collect(),
            values: (0..24).collect(),
            names: BTreeMap::new(),
            origin: Vec3::new(0.5, 0.25, -1.0),
            steps: [Vec3::new(0.0, -0.2, 0.0), Vec3::new(0.0, 0.0, 0.3), Vec3::new(-0.1, 0.0, 0.0)],
            notes: Vec::new(),
        }
    }

    #[test]
    fn the_frame_is_right_handed_and_finds_every_voxel() {
        let volume = turned();
        let frame = volume.frame().unwrap();
        assert_eq!(frame.dims, [4, 2, 3]);
        assert!((frame.rotation - Mat3::identity()).norm() < 1e-15);
        for (i, j, k) in [(0, 0, 0), (3, 1, 2), (1, 0, 2)] {
            let index = frame.index([i, j, k]);
            let file = [index % 2, index / 2 % 3, index / 6];
            let steps = volume.steps.iter().zip(file);
            let centre = volume.origin + steps.map(|(step, n)| step * n as f64).sum::<Vec3>();
            let local = Vec3::new(0.1 * (i as f64 + 0.5), 0.2 * (j as f64 + 0.5), 0.3 * (k as f64 + 0.5));
            assert!((frame.world(&local) - centre).norm() < 1e-14);
            assert!((frame.local(&centre) - local).norm() < 1e-14);
        }
    }

    #[test]
    fn sheared_grids_are_refused() {
        let mut volume = turned();
        volume.steps[0].x = 0.01;
        let error = volume.frame().unwrap_err();
        assert!(error.to_string().contains("resample"), "{error}");
    }

    #[test]
    fn counts_have_the_volume_of_their_voxels() {
        let counts = turned().counts();
        assert_eq!(counts.len(), 24);
        assert!((counts[0].volume_m3 - 0.006).abs() < 1e-15);
    }
}
