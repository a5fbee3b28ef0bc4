//! From the numbers of a file to labels.

use super::error::malformed;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::MeshError;
use crate::mesh::segmentation::volume::{LabelVolume, MOST_LABELS};
use std::collections::BTreeMap;

/// Largest whole number that a label may be: those up to 2⁵³ are exact in every format.
const LARGEST_LABEL: f64 = 9_007_199_254_740_992.0;

/// Type of the numbers of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sample {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Sample {
    /// Bytes of one number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The number in these bytes, of which there are [`Self::size`]; the first is the least significant.
    fn number(self, bytes: [u8; 8]) -> f64 {
        let low = |n: usize| {
            let mut kept = [0; 8];
            kept[..n].copy_from_slice(&bytes[..n]);
            u64::from_le_bytes(kept)
        };
        #[allow(clippy::cast_possible_wrap)] // the bits of a signed number
        match self {
            Self::U8 => low(1) as f64,
            Self::I8 => f64::from(low(1) as u8 as i8),
            Self::U16 => low(2) as f64,
            Self::I16 => f64::from(low(2) as u16 as i16),
            Self::U32 => low(4) as f64,
            Self::I32 => f64::from(low(4) as u32 as i32),
            Self::U64 => low(8) as f64,
            Self::I64 => low(8) as i64 as f64,
            Self::F32 => f64::from(f32::from_bits(low(4) as u32)),
            Self::F64 => f64::from_bits(low(8)),
        }
    }
}

/// Edges of voxels that a scan of a body can have [m].
const VOXEL_LENGTHS: std::ops::RangeInclusive<f64> = 1e-9..=10.0;
/// Largest distance of a scan from the origin of its space [m].
const FARTHEST: f64 = 1e3;
/// Volume of a voxel over that of a box with its edges, below which it is flat [-].
const FLATTEST: f64 = 1e-9;

/// What a header says of the voxels that follow it.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// Number of voxels along each axis.
    pub(super) dims: [u64; 3],
    /// Type of the numbers, and whether the most significant byte is first.
    pub(super) sample: Sample,
    pub(super) is_big_endian: bool,
    /// Label = slope · number + intercept.
    pub(super) scaling: [f64; 2],
    /// Centre of the first voxel [m], and the step along each axis.
    pub(super) origin: Vec3,
    pub(super) steps: [Vec3; 3],
    /// Names of labels.
    pub(super) names: BTreeMap<i64, String>,
    /// Where in the file the header says so, for errors.
    pub(super) place: usize,
    /// Remarks on what was assumed.
    pub(super) notes: Vec<String>,
}

impl Layout {
    /// Number of bytes of all voxels.
    ///
    /// # Errors
    /// `Malformed` for an axis without voxels or a grid without volume; `Unsupported` for more than `limit` bytes.
    pub(super) fn bytes(&self, limit: u64) -> Result<u64, MeshError> {
        let [a, b, c] = self.dims;
        if a.min(b).min(c) == 0 {
            return Err(malformed(self.place, format!("{a} × {b} × {c} voxels: an axis has none")));
        }
        let lengths = self.steps.map(|step| step.norm());
        if let Some(length) = lengths.iter().find(|length| !VOXEL_LENGTHS.contains(length)) {
            let [least, most] = [VOXEL_LENGTHS.start(), VOXEL_LENGTHS.end()];
            let message = format!(
                "a voxel has an edge of {length:e} m, expected {least:e} to {most} m: check the unit"
            );
            return Err(malformed(self.place, message));
        }
        if !(self.origin.norm() <= FARTHEST) {
            let [x, y, z] = self.origin.into();
            let message = format!(
                "the first voxel is at ({x:e}, {y:e}, {z:e}) m, expected at most {FARTHEST} m from 0"
            );
            return Err(malformed(self.place, message));
        }
        let volume = Mat3::from_columns(&self.steps).determinant().abs();
        if !(volume > FLATTEST * lengths.iter().product::<f64>()) {
            return Err(malformed(
                self.place,
                format!("a voxel has the volume {volume} m³: its axes lie in a plane"),
            ));
        }
        let voxels = a.checked_mul(b).and_then(|n| n.checked_mul(c));
        let bytes = voxels.and_then(|n| n.checked_mul(self.sample.size() as u64));
        bytes.filter(|bytes| *bytes <= limit).ok_or_else(|| MeshError::Unsupported {
            what: format!(
                "{a} × {b} × {c} voxels of {} bytes, more than the {limit} bytes that are allowed",
                self.sample.size()
            ),
            remedy: "crop the scan around the impact, or save the labels with one byte for each voxel".into(),
        })
    }

    /// The label volume of these voxels; `offset` is the place of the first in the file, for errors (in its content, if that is
    /// compressed).
    ///
    /// # Errors
    /// `Malformed` for a number that is not whole; `Unsupported` for too many labels.
    pub(super) fn labels(self, data: &[u8], offset: usize) -> Result<LabelVolume, MeshError> {
        let size = self.sample.size();
        let mut seen: BTreeMap<i64, u16> = BTreeMap::from([(0, 0)]);
        let mut labels = Vec::with_capacity(data.len() / size);
        let mut last: Option<([u8; 8], u16)> = None;
        for (voxel, found) in data.chunks_exact(size).enumerate() {
            let mut bytes = [0; 8];
            bytes[..size].copy_from_slice(found);
            if self.is_big_endian {
                bytes[..size].reverse();
            }
            // Neighbours mostly have the same label.
            if let Some((_, index)) = last.filter(|(known, _)| *known == bytes) {
                labels.push(index);
                continue;
            }
            let place = offset + voxel * size;
            let label = self.whole(bytes, place)?;
            let next = seen.len() as u16;
            let index = *seen.entry(label).or_insert(next);
            if seen.len() > MOST_LABELS {
                return Err(MeshError::Unsupported {
                    what: format!("more than {MOST_LABELS} different labels (the last at byte {place})"),
                    remedy: "this looks like an image: segment it, and save the labels".into(),
                });
            }
            last = Some((bytes, index));
            labels.push(index);
        }
        // In ascending order.
        let mut rank = vec![0_u16; seen.len()];
        (0..).zip(seen.values()).for_each(|(r, index)| rank[usize::from(*index)] = r);
        for index in &mut labels {
            *index = rank[usize::from(*index)];
        }
        Ok(LabelVolume {
            dims: self.dims.map(|n| n as usize),
            labels,
            values: seen.into_keys().collect(),
            names: self.names,
            origin: self.origin,
            steps: self.steps,
            notes: self.notes,
        })
    }

    fn whole(&self, bytes: [u8; 8], place: usize) -> Result<i64, MeshError> {
        let number = self.scaling[0] * self.sample.number(bytes) + self.scaling[1];
        let is_whole = number.abs() <= LARGEST_LABEL && number.fract() == 0.0;
        is_whole.then_some(number as i64).ok_or_else(|| {
            malformed(place, format!("the voxel is {number}: labels are whole numbers up to {LARGEST_LABEL}"))
        })
    }
}
