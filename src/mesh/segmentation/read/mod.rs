//! Label volumes: NIfTI-1 and -2 (`.nii`, `.nii.gz`), NRRD (`.nrrd`), MetaImage (`.mha`, `.mhd`).
//!
//! The readers accept arbitrary bytes and trust none of them. The size that a header announces is compared with the limit
//! and with the length of the data before anything of that size is allocated. Positions are in the axes of NIfTI (x to the
//! right, y to the front, z up); files in those of DICOM are turned into them.

mod error;
mod gzip;
mod header;
mod metaimage;
mod nifti;
mod nrrd;
mod samples;
#[cfg(test)]
pub(super) mod tests;

use super::volume::LabelVolume;
use crate::mesh::MeshError;

/// Formats of label volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VolumeFormat {
    /// NIfTI-1 or -2 in one file, compressed or not.
    Nifti,
    /// NRRD with its data in the same file.
    Nrrd,
    /// MetaImage with its data in the same file.
    MetaImage,
}

impl VolumeFormat {
    /// All formats of scans that are read.
    pub const ALL: [Self; 3] = [Self::Nifti, Self::Nrrd, Self::MetaImage];

    /// The format from the first bytes of a file.
    pub fn sniff(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(b"NRRD000") {
            Some(Self::Nrrd)
        } else if bytes.starts_with(b"ObjectType") || bytes.starts_with(b"NDims") {
            Some(Self::MetaImage)
        } else if gzip::begins(bytes) || nifti::begins(bytes) {
            Some(Self::Nifti)
        } else {
            None
        }
    }
}

/// Reads a label volume, of at most `limit` bytes after decompression.
///
/// # Errors
/// `Malformed`, with the byte or line, for a violation of the format and for voxels that are no whole numbers;
/// `Unsupported` for versions, encodings and data that are not read, for grids with shear, and for more bytes than allowed.
pub fn read_labels(bytes: &[u8], format: VolumeFormat, limit: u64) -> Result<LabelVolume, MeshError> {
    let volume = match format {
        VolumeFormat::Nifti => nifti::read(bytes, limit),
        VolumeFormat::Nrrd => nrrd::read(bytes, limit),
        VolumeFormat::MetaImage => metaimage::read(bytes, limit),
    }?;
    if volume.labels.iter().all(|label| volume.values[usize::from(*label)] == 0) {
        return Err(MeshError::Unsupported {
            what: "the scan has no label but 0, which is what is outside".into(),
            remedy: "save the segmentation rather than the image, with a number from 1 on for each tissue"
                .into(),
        });
    }
    // A grid that cannot be meshed is no use.
    volume.frame()?;
    Ok(volume)
}
