//! NRRD (<https://teem.sourceforge.net/nrrd/format.html>) with its data in the same file, raw or compressed by gzip.

use super::gzip::Compressed;
use super::header::{TextHeader, counts, exactly, in_line, numbers, spacings as spacings_of};
use super::samples::{Layout, Sample};
use crate::mechanics::tensor::Vec3;
use crate::mesh::MeshError;
use crate::mesh::names::fault;
use crate::mesh::segmentation::volume::LabelVolume;
use std::collections::BTreeMap;

/// Reads a volume of at most `limit` bytes.
///
/// # Errors
/// As [`read_labels`](super::read_labels).
pub(super) fn read(bytes: &[u8], limit: u64) -> Result<LabelVolume, MeshError> {
    let header = TextHeader::read(bytes, ":", str::is_empty)?;
    let in_one_file = "save it as one file .nrrd";
    if let Some((line, _)) = header.get(&["data file", "datafile"]) {
        return Err(MeshError::Unsupported {
            what: format!("voxels in another file (line {line})"),
            remedy: in_one_file.into(),
        });
    }
    header.allow(&["line skip", "lineskip", "byte skip", "byteskip"], &["0"], in_one_file)?;
    header.allow(&["dimension"], &["3"], "save one volume of labels, with one number for each voxel")?;
    header.allow(&["endian"], &["little", "big"], "save it with the endian of a machine")?;
    let encodings = ["raw", "gzip", "gz"];
    header.allow(&["encoding"], &encodings, "save it raw, or compressed by gzip")?;
    let layout = layout(&header)?;
    let size = layout.bytes(limit)?;
    let start = header.end;
    if header.need(&["encoding"])?.1.eq_ignore_ascii_case("raw") {
        return layout.labels(exactly(bytes, start as u64, size)?, start);
    }
    let content = Compressed::gzip(bytes, start)?.all(size)?;
    layout.labels(&content, 0)
}

fn layout(header: &TextHeader) -> Result<Layout, MeshError> {
    // Type of the voxels, with all its spellings.
    let (line, word) = header.need(&["type"])?;
    let sample = match word.to_ascii_lowercase().as_str() {
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Sample::U8,
        "signed char" | "int8" | "int8_t" => Sample::I8,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Sample::U16,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Sample::I16,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Sample::U32,
        "int" | "signed int" | "int32" | "int32_t" => Sample::I32,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Sample::U64,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Sample::I64,
        "float" => Sample::F32,
        "double" => Sample::F64,
        other => return Err(in_line(line, format!("there is no type {other:?} of voxels"))),
    };
    let mut notes = Vec::new();
    // Unit of length, in metres.
    let unit = match header.get(&["space units"]) {
        None => {
            notes.push("the scan does not say its unit of length: millimetres are assumed".into());
            1e-3
        }
        Some((line, words)) => match words.split_whitespace().next().map(|word| word.trim_matches('"')) {
            Some("mm" | "millimeter" | "millimetre") => 1e-3,
            Some("m" | "meter" | "metre") => 1.0,
            Some("um" | "µm" | "micrometer" | "micrometre") => 1e-6,
            _ => return Err(in_line(line, "the unit of length is none of \"mm\", \"m\", \"um\"")),
        },
    };
    // Grid: a vector per axis where the file is oriented, else spacings along x, y, z.
    let signs = signs(header, &mut notes)?;
    let steps: [Vec3; 3] = match (header.get(&["space directions"]), header.get(&["spacings"])) {
        (Some(directions), _) => {
            let found = numbers::<9>(directions)?;
            [0, 3, 6].map(|i| Vec3::new(found[i], found[i + 1], found[i + 2]))
        }
        (None, Some(spacings)) => {
            let [a, b, c] = spacings_of(spacings, "space directions")?;
            [Vec3::x() * a, Vec3::y() * b, Vec3::z() * c]
        }
        (None, None) => {
            return Err(in_line(1, "the header has neither \"space directions\" nor \"spacings\""));
        }
    };
    let origin = header.get(&["space origin"]).map_or(Ok([0.0; 3]), numbers::<3>)?;
    // Byte order, which only single bytes do without.
    let is_big_endian = header.get(&["endian"]).is_some_and(|(_, word)| word.eq_ignore_ascii_case("big"));
    if sample.size() > 1 && header.get(&["endian"]).is_none() {
        return Err(in_line(1, "the header has no \"endian\""));
    }
    Ok(Layout {
        dims: counts(header.need(&["sizes"])?)?,
        sample,
        is_big_endian,
        scaling: [1.0, 0.0],
        origin: Vec3::from(origin).component_mul(&signs) * unit,
        steps: steps.map(|step| step.component_mul(&signs) * unit),
        names: segment_names(header),
        place: 0,
        notes,
    })
}

/// Names of labels as 3D Slicer writes them: `Segment0_LabelValue:=1`, `Segment0_Name:=muscle`.
fn segment_names(header: &TextHeader) -> BTreeMap<i64, String> {
    let named = |(key, label): (&str, &str)| {
        let name = header.of_user(&format!("{key}_name"))?;
        Some((label.parse().ok()?, name.to_owned())).filter(|_| fault(name).is_none())
    };
    header.of_users_ending("_labelvalue").filter_map(named).collect()
}

/// Signs that turn the space of the file into that of NIfTI: right, front, up.
fn signs(header: &TextHeader, notes: &mut Vec<String>) -> Result<Vec3, MeshError> {
    let Some((line, space)) = header.get(&["space"]) else {
        notes.push("the scan does not say in which space it lies: its axes are x, y, z".into());
        return Ok(Vec3::new(1.0, 1.0, 1.0));
    };
    match space.to_ascii_lowercase().as_str() {
        "right-anterior-superior" | "ras" | "3d-right-handed" | "scanner-xyz" => Ok(Vec3::new(1.0, 1.0, 1.0)),
        "left-anterior-superior" | "las" => Ok(Vec3::new(-1.0, 1.0, 1.0)),
        "left-posterior-superior" | "lps" => Ok(Vec3::new(-1.0, -1.0, 1.0)),
        other => Err(MeshError::Unsupported {
            what: format!("the space {other:?} (line {line})"),
            remedy: "save it in the space left-posterior-superior or right-anterior-superior".into(),
        }),
    }
}
