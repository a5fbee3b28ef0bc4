//! NIfTI-1 and NIfTI-2 in one file (<https://nifti.nimh.nih.gov/nifti-1>, nifti1.h; nifti2.h).

use super::error::malformed;
use super::gzip::{self, Compressed};
use super::header::exactly;
use super::samples::{Layout, Sample};
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::MeshError;
use crate::mesh::segmentation::volume::LabelVolume;
use std::collections::BTreeMap;

/// Sizes of the headers of the two versions, which are their first numbers.
const HEADERS: [usize; 2] = [348, 540];

/// Whether the file begins with a header, of either byte order.
pub(super) fn begins(bytes: &[u8]) -> bool {
    version(bytes).is_some()
}

/// Version and byte order from the first four bytes.
fn version(bytes: &[u8]) -> Option<(usize, bool)> {
    let first: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
    let sizes = [(i32::from_le_bytes(first), false), (i32::from_be_bytes(first), true)];
    let is_header = |(size, is_big): (i32, bool)| {
        HEADERS.iter().position(|header| i32::try_from(*header) == Ok(size)).map(|v| (v, is_big))
    };
    sizes.into_iter().find_map(is_header)
}

/// Reads a volume of at most `limit` bytes.
///
/// # Errors
/// As [`read_labels`](super::read_labels).
pub(super) fn read(bytes: &[u8], limit: u64) -> Result<LabelVolume, MeshError> {
    if !gzip::begins(bytes) {
        let (layout, start) = header(bytes)?;
        let size = layout.bytes(limit)?;
        return layout.labels(exactly(bytes, start, size)?, start as usize);
    }
    let stream = Compressed::gzip(bytes, 0)?;
    let (layout, start) = header(&stream.first(HEADERS[1])?)?;
    let size = layout.bytes(limit)?;
    if start > limit {
        return Err(malformed(108, format!("the voxels begin at byte {start} of the content")));
    }
    let content = stream.all(start + size)?;
    layout.labels(&content[start as usize..], start as usize)
}

/// A header, of known byte order.
struct Fields<'a> {
    bytes: &'a [u8],
    is_big_endian: bool,
}

impl Fields<'_> {
    /// `N` bytes, the least significant first. The header is long enough for every field of its version.
    fn take<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut found = [0; N];
        found.copy_from_slice(&self.bytes[at..at + N]);
        if self.is_big_endian {
            found.reverse();
        }
        found
    }

    fn i16(&self, at: usize) -> i64 {
        i64::from(i16::from_le_bytes(self.take(at)))
    }

    fn i32(&self, at: usize) -> i64 {
        i64::from(i32::from_le_bytes(self.take(at)))
    }

    fn i64(&self, at: usize) -> i64 {
        i64::from_le_bytes(self.take(at))
    }

    fn f32(&self, at: usize) -> f64 {
        f64::from(f32::from_le_bytes(self.take(at)))
    }

    fn f64(&self, at: usize) -> f64 {
        f64::from_le_bytes(self.take(at))
    }
}

/// The numbers of a header, of either version.
struct Header {
    /// Places of the dimensions, the type and the grid, for errors.
    places: [usize; 3],
    magic: [u8; 3],
    dim: [i64; 8],
    datatype: i64,
    pixdim: [f64; 8],
    start: f64,
    scaling: [f64; 2],
    units: i64,
    /// Codes of qform and sform.
    codes: [i64; 2],
    quaternion: [f64; 3],
    offset: [f64; 3],
    rows: [[f64; 4]; 3],
}

impl Header {
    fn version_1(h: &Fields) -> Self {
        Self {
            places: [40, 70, 252],
            magic: [h.bytes[344], h.bytes[345], h.bytes[346]],
            dim: std::array::from_fn(|i| h.i16(40 + 2 * i)),
            datatype: h.i16(70),
            pixdim: std::array::from_fn(|i| h.f32(76 + 4 * i)),
            start: h.f32(108),
            scaling: [h.f32(112), h.f32(116)],
            units: i64::from(h.bytes[123]),
            codes: [h.i16(252), h.i16(254)],
            quaternion: [h.f32(256), h.f32(260), h.f32(264)],
            offset: [h.f32(268), h.f32(272), h.f32(276)],
            rows: std::array::from_fn(|i| std::array::from_fn(|j| h.f32(280 + 16 * i + 4 * j))),
        }
    }

    fn version_2(h: &Fields) -> Self {
        Self {
            places: [16, 12, 344],
            magic: [h.bytes[4], h.bytes[5], h.bytes[6]],
            dim: std::array::from_fn(|i| h.i64(16 + 8 * i)),
            datatype: h.i16(12),
            pixdim: std::array::from_fn(|i| h.f64(104 + 8 * i)),
            start: h.i64(168) as f64,
            scaling: [h.f64(176), h.f64(184)],
            units: h.i32(500),
            codes: [h.i32(344), h.i32(348)],
            quaternion: [h.f64(352), h.f64(360), h.f64(368)],
            offset: [h.f64(376), h.f64(384), h.f64(392)],
            rows: std::array::from_fn(|i| std::array::from_fn(|j| h.f64(400 + 32 * i + 8 * j))),
        }
    }

    /// Numbers of voxels along the three axes; a file with several volumes is refused.
    fn dims(&self) -> Result<[u64; 3], MeshError> {
        let place = self.places[0];
        let count = usize::try_from(self.dim[0]).ok().filter(|n| (1..=7).contains(n));
        let count = count.ok_or_else(|| malformed(place, format!("{} dimensions", self.dim[0])))?;
        if let Some(more) = (4..=count).find(|&i| self.dim[i] > 1) {
            return Err(MeshError::Unsupported {
                what: format!("{} volumes along dimension {more} in one file", self.dim[more]),
                remedy: "save one volume of labels".into(),
            });
        }
        let mut dims = [1; 3];
        for (i, n) in dims.iter_mut().enumerate().take(count) {
            let found = self.dim[i + 1];
            *n = u64::try_from(found)
                .map_err(|_| malformed(place, format!("{found} voxels along an axis")))?;
        }
        Ok(dims)
    }

    fn sample(&self) -> Result<Sample, MeshError> {
        Ok(match self.datatype {
            2 => Sample::U8,
            256 => Sample::I8,
            512 => Sample::U16,
            4 => Sample::I16,
            768 => Sample::U32,
            8 => Sample::I32,
            1280 => Sample::U64,
            1024 => Sample::I64,
            16 => Sample::F32,
            64 => Sample::F64,
            other => {
                return Err(MeshError::Unsupported {
                    what: format!("voxels of NIfTI type {other} (byte {})", self.places[1]),
                    remedy: "save the labels as whole numbers of 8 or 16 bits".into(),
                });
            }
        })
    }

    /// Origin and steps, in the unit of the file: sform, else qform, else the distances alone.
    fn grid(&self, notes: &mut Vec<String>) -> Result<(Vec3, [Vec3; 3]), MeshError> {
        let [qform, sform] = self.codes;
        if sform > 0 {
            let column = |j: usize| Vec3::new(self.rows[0][j], self.rows[1][j], self.rows[2][j]);
            return Ok((column(3), [column(0), column(1), column(2)]));
        }
        let sizes = [1, 2, 3].map(|i| self.pixdim[i].abs());
        if qform > 0 {
            let [b, c, d] = self.quaternion;
            let rest = 1.0 - (b * b + c * c + d * d);
            if !(rest > -1e-4) {
                return Err(malformed(
                    self.places[2],
                    format!("the quaternion ({b}, {c}, {d}) is not a rotation"),
                ));
            }
            let a = rest.max(0.0).sqrt();
            #[rustfmt::skip]
            let rotation = Mat3::new(
                a * a + b * b - c * c - d * d, 2.0 * (b * c - a * d), 2.0 * (b * d + a * c),
                2.0 * (b * c + a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d - a * b),
                2.0 * (b * d - a * c), 2.0 * (c * d + a * b), a * a + d * d - c * c - b * b,
            );
            let sign = if self.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
            let column = |j: usize, s: f64| rotation.column(j) * (sizes[j] * s);
            return Ok((Vec3::from(self.offset), [column(0, 1.0), column(1, 1.0), column(2, sign)]));
        }
        notes.push("the scan has no position: its first voxel is at the origin, its axes are x, y, z".into());
        Ok((Vec3::zeros(), [Vec3::x() * sizes[0], Vec3::y() * sizes[1], Vec3::z() * sizes[2]]))
    }
}

/// The layout that a header describes, and the place of the first voxel.
fn header(bytes: &[u8]) -> Result<(Layout, u64), MeshError> {
    // Version and byte order, from the size that the header gives of itself.
    let found = version(bytes)
        .ok_or_else(|| malformed(0, "expected a NIfTI header (348 or 540 as its first number)"))?;
    let (version, is_big_endian) = found;
    let size = HEADERS[version];
    if bytes.len() < size {
        return Err(malformed(bytes.len(), format!("the header has {size} bytes, but the file ends here")));
    }
    let fields = Fields { bytes, is_big_endian };
    let header = if version == 0 { Header::version_1(&fields) } else { Header::version_2(&fields) };
    // Voxels in the same file, behind the header.
    if &header.magic[..2] == b"ni" {
        return Err(MeshError::Unsupported {
            what: "a NIfTI header with its voxels in another file".into(),
            remedy: "save it as one file .nii or .nii.gz".into(),
        });
    }
    if &header.magic[..2] != b"n+" {
        return Err(malformed(if version == 0 { 344 } else { 4 }, "expected the mark n+1 or n+2 of NIfTI"));
    }
    if !(header.start >= size as f64 && header.start < 1e9) {
        return Err(malformed(
            108,
            format!("the voxels begin at byte {}, inside the header of {size}", header.start),
        ));
    }
    let mut notes = Vec::new();
    // Unit of length, in metres (xyzt_units).
    let unit = match header.units & 7 {
        1 => 1.0,
        2 => 1e-3,
        3 => 1e-6,
        _ => {
            notes.push("the scan does not say its unit of length: millimetres are assumed".into());
            1e-3
        }
    };
    // Grid, and the scaling of the values; a slope of 0 stands for none.
    let (origin, steps) = header.grid(&mut notes)?;
    let [slope, intercept] = header.scaling;
    let layout = Layout {
        dims: header.dims()?,
        sample: header.sample()?,
        is_big_endian,
        scaling: if slope == 0.0 || !slope.is_finite() { [1.0, 0.0] } else { [slope, intercept] },
        origin: origin * unit,
        steps: steps.map(|step| step * unit),
        place: header.places[0],
        names: BTreeMap::new(),
        notes,
    };
    Ok((layout, header.start as u64))
}
