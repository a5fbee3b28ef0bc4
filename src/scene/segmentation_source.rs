//! Label volumes of a scene: the scan of a file, or the closed surfaces of several.

use super::file_problem::{mesh_problem, scan_problem, source_problem};
use super::problem::{Pointer, Problem};
use super::segmentation_document::SegmentationDocument;
use super::source::{MeshBytes, MeshSource};
use crate::mesh::read::MeshFormat;
use crate::mesh::read::stl::{ClosedSurface, read_stl};
use crate::mesh::segmentation::read::read_labels;
use crate::mesh::segmentation::{Filled, Filling, LabelVolume, Unfilled};

/// The labels of a file of a source, of at most `limit` bytes after decompression, and the file.
///
/// # Errors
/// Why it cannot be read, as a problem at `place`.
pub fn read_scan(
    source: &dyn MeshSource,
    name: &str,
    limit: u64,
    place: &Pointer,
) -> Result<(LabelVolume, MeshBytes), Problem> {
    let found = source.read(name, limit).map_err(|error| source_problem(&error, place).value(name))?;
    let format = MeshFormat::from_name(&found.file_name).or_else(|| MeshFormat::sniff(&found.bytes));
    let format = format.and_then(MeshFormat::volume).ok_or_else(|| {
        Problem::error("unknown_mesh_format", place, "this is not a scan with labels")
            .value(name)
            .limit("a file name ending in .nii, .nii.gz, .nrrd or .mha")
            .remedy(
                "name a mesh in \"mesh\": {\"file\": …}, a surface in \"surfaces\"; save the labels of a scan in one of these formats",
            )
    })?;
    let volume = read_labels(&found.bytes, format, limit);
    let volume = volume.map_err(|error| scan_problem(&error, place).value(name))?;
    Ok((volume, found))
}

/// The closed surface of a file of a source, of at most `limit` bytes, in the unit of the file; and the file.
///
/// # Errors
/// Why it cannot be read, as a problem at `place`.
pub fn read_surface(
    source: &dyn MeshSource,
    name: &str,
    limit: u64,
    place: &Pointer,
) -> Result<(ClosedSurface, MeshBytes), Problem> {
    let found = source.read(name, limit).map_err(|error| source_problem(&error, place).value(name))?;
    let surface = read_stl(&found.bytes).map_err(|error| mesh_problem(&error, place).value(name))?;
    Ok((surface, found))
}

/// The labels of the surfaces of a document, n of the n-th from 1, and their files by name. Files have together at most `limit` bytes, and there
/// are at most as many voxels.
///
/// # Errors
/// Why one cannot be read, or filled with voxels, as a problem at its place in `here`.
pub fn read_surfaces(
    source: &dyn MeshSource,
    scan: &SegmentationDocument,
    limit: u64,
    here: &Pointer,
) -> Result<(Filled, Vec<(String, MeshBytes)>), Problem> {
    let (mut surfaces, mut files, mut left) = (Vec::new(), Vec::new(), limit);
    for (i, document) in scan.surfaces.iter().enumerate() {
        let (surface, file) = read_surface(source, &document.name, left, &here.index(i).key("name"))?;
        left = left.saturating_sub(file.bytes.len() as u64);
        surfaces.push(surface.scaled(document.scale));
        files.push((document.name.clone(), file));
    }
    let crop = scan.crop();
    let filling =
        Filling { surfaces: &surfaces, voxel_m: scan.voxel_m(), crop: crop.as_ref(), most_voxels: limit };
    let filled = filling.labels().map_err(|Unfilled { surface, error }| {
        let place = surface.map_or_else(|| here.clone(), |i| here.index(i));
        let problem = scan_problem(&error, &place);
        match surface.and_then(|i| scan.surfaces.get(i)) {
            Some(document) => problem.value(document.name.as_str()),
            None => problem.value(scan.voxel_m()),
        }
    })?;
    Ok((filled, files))
}
