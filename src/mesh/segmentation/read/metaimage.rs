//! MetaImage `.mha`, `.mhd` (<https://itk.org/Wiki/MetaIO/Documentation>): its data are in the same file, raw or compressed by zlib.

use super::gzip::Compressed;
use super::header::{TextHeader, counts, exactly, in_line, numbers, spacings};
use super::samples::{Layout, Sample};
use crate::mechanics::tensor::Vec3;
use crate::mesh::MeshError;
use crate::mesh::segmentation::volume::LabelVolume;
use std::collections::BTreeMap;

/// Reads a volume of at most `limit` bytes.
///
/// # Errors
/// As [`read_labels`](super::read_labels).
pub(super) fn read(bytes: &[u8], limit: u64) -> Result<LabelVolume, MeshError> {
    let is_last = |line: &str| line.to_ascii_lowercase().starts_with("elementdatafile");
    let header = TextHeader::read(bytes, "=", is_last)?;
    header.allow(&["elementdatafile"], &["local"], "save it as one file .mha")?;
    header.allow(&["ndims"], &["3"], "save one volume of labels")?;
    header.allow(&["elementnumberofchannels"], &["1"], "save one number for each voxel")?;
    header.allow(&["binarydata"], &["true"], "save it with binary data")?;
    let layout = layout(&header)?;
    let size = layout.bytes(limit)?;
    if header.get(&["compresseddata"]).is_some_and(|(_, word)| word.eq_ignore_ascii_case("true")) {
        let content = Compressed::zlib(bytes, header.end).all(size)?;
        return layout.labels(&content, 0);
    }
    layout.labels(exactly(bytes, header.end as u64, size)?, header.end)
}

fn layout(header: &TextHeader) -> Result<Layout, MeshError> {
    let (line, word) = header.need(&["elementtype"])?;
    let sample = match word.to_ascii_uppercase().as_str() {
        "MET_UCHAR" => Sample::U8,
        "MET_CHAR" => Sample::I8,
        "MET_USHORT" => Sample::U16,
        "MET_SHORT" => Sample::I16,
        "MET_UINT" => Sample::U32,
        "MET_INT" => Sample::I32,
        "MET_ULONG_LONG" => Sample::U64,
        "MET_LONG_LONG" => Sample::I64,
        "MET_FLOAT" => Sample::F32,
        "MET_DOUBLE" => Sample::F64,
        other => return Err(in_line(line, format!("voxels of the type {other:?} are not read"))),
    };
    let order = ["binarydatabyteordermsb", "elementbyteordermsb"];
    let is_big_endian = header.get(&order).is_some_and(|(_, word)| word.eq_ignore_ascii_case("true"));
    let spacing = spacings(header.need(&["elementspacing", "elementsize"])?, "TransformMatrix")?;
    let turned = header.get(&["transformmatrix", "rotation", "orientation"]);
    let matrix = turned.map_or(Ok([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]), numbers::<9>)?;
    let origin = header.get(&["offset", "position", "origin"]).map_or(Ok([0.0; 3]), numbers::<3>)?;
    // From the space of DICOM (left, back, up, in millimetres) to that of NIfTI.
    let in_space = |x: f64, y: f64, z: f64| Vec3::new(-x, -y, z) * 1e-3;
    let step = |i: usize| in_space(matrix[3 * i], matrix[3 * i + 1], matrix[3 * i + 2]) * spacing[i];
    Ok(Layout {
        dims: counts(header.need(&["dimsize"])?)?,
        sample,
        is_big_endian,
        scaling: [1.0, 0.0],
        origin: in_space(origin[0], origin[1], origin[2]),
        steps: [step(0), step(1), step(2)],
        place: 0,
        names: BTreeMap::new(),
        notes: Vec::new(),
    })
}
