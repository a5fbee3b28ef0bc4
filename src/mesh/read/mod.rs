//! Mesh files: Gmsh `.msh` (2.2 and 4.1, ASCII and binary), Abaqus `.inp`, VTK `.vtk`
//! and `.vtu`, LS-DYNA `.k`, FEBio `.feb`, Nastran `.bdf`. Label volumes have formats here, too, and are read by `segmentation`.
//!
//! The readers accept arbitrary bytes, trust none of them, and report the line or byte of an error. Volumes may be of any
//! [`CellKind`](super::CellKind), mixed in one file. Named groups of volume elements become parts, groups of other elements
//! node sets.

mod abaqus;
mod assembly;
mod cursor;
mod entries;
pub(crate) mod febio;
mod gmsh;
mod include;
mod lsdyna;
mod nastran;
pub mod stl;
mod stl_shells;
pub mod table;
mod vtk;
pub(crate) mod xml;

#[cfg(test)]
mod tests;

pub use include::{FieldNames, Include};

use super::segmentation::read::VolumeFormat;
use super::{Mesh, MeshError};
use serde::{Deserialize, Serialize};

/// A supported file format; serialised as its file extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(
    feature = "service",
    derive(utoipa::ToSchema),
    schema(description = "The formats that can be uploaded.")
)]
pub enum MeshFormat {
    /// Gmsh `.msh`, version 2.2 or 4.1, ASCII or binary of either byte order.
    #[serde(rename = "msh")]
    Gmsh,
    /// Abaqus or CalculiX `.inp`.
    #[serde(rename = "inp")]
    Abaqus,
    /// Legacy VTK `.vtk` of an unstructured grid, ASCII or binary.
    #[serde(rename = "vtk")]
    Vtk,
    /// XML VTK `.vtu` of an unstructured grid.
    #[serde(rename = "vtu")]
    Vtu,
    /// LS-DYNA keyword file `.k`.
    #[serde(rename = "k")]
    LsDyna,
    /// The mesh of a FEBio file `.feb`.
    #[serde(rename = "feb")]
    Febio,
    /// Nastran bulk data `.bdf`.
    #[serde(rename = "bdf")]
    Nastran,
    /// Label volume in NIfTI `.nii`, `.nii.gz`.
    #[serde(rename = "nii")]
    Nifti,
    /// Label volume in NRRD `.nrrd`.
    #[serde(rename = "nrrd")]
    Nrrd,
    /// Label volume in MetaImage `.mha`, or `.mhd` with its data in the same file.
    #[serde(rename = "mha")]
    MetaImage,
    /// Closed surface of a rigid body or of a tissue in STL `.stl`, ASCII or binary.
    #[serde(rename = "stl")]
    Stl,
}

impl MeshFormat {
    /// All formats of meshes, label volumes and surfaces that are read.
    pub const ALL: [Self; 11] = [
        Self::Gmsh,
        Self::Abaqus,
        Self::Vtk,
        Self::Vtu,
        Self::LsDyna,
        Self::Febio,
        Self::Nastran,
        Self::Nifti,
        Self::Nrrd,
        Self::MetaImage,
        Self::Stl,
    ];

    /// The usual file extension of the format.
    pub fn extension(self) -> &'static str {
        self.extensions()[0]
    }

    /// File extensions of the format, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Gmsh => &["msh"],
            Self::Abaqus => &["inp"],
            Self::Vtk => &["vtk"],
            Self::Vtu => &["vtu"],
            Self::LsDyna => &["k", "key", "dyn"],
            Self::Febio => &["feb"],
            Self::Nastran => &["bdf", "nas"],
            Self::Nifti => &["nii", "nii.gz"],
            Self::Nrrd => &["nrrd"],
            Self::MetaImage => &["mha", "mhd"],
            Self::Stl => &["stl"],
        }
    }

    /// The extensions of all formats, for messages (".msh, .inp").
    pub fn extensions_in_words() -> String {
        let all = Self::ALL.into_iter().flat_map(Self::extensions);
        all.map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(", ")
    }

    /// The format from the extension of a file name (not case-sensitive).
    pub fn from_name(name: &str) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        let ends = |own: &&str| name.strip_suffix(*own).is_some_and(|stem| stem.ends_with('.'));
        Self::ALL.into_iter().find(|format| format.extensions().iter().any(&ends))
    }

    /// The format from the first bytes of a file; Nastran's has no certain beginning.
    pub fn sniff(bytes: &[u8]) -> Option<Self> {
        let start = bytes.trim_ascii_start();
        let begins = |words: &[&[u8]]| words.iter().any(|word| start.starts_with(word));
        let names =
            |root: &[u8]| start[..start.len().min(2000)].windows(root.len()).any(|found| found == root);
        if begins(&[b"$MeshFormat", b"$Comments"]) {
            Some(Self::Gmsh)
        } else if lsdyna::begins(start) {
            Some(Self::LsDyna)
        } else if begins(&[b"*"]) {
            Some(Self::Abaqus)
        } else if begins(&[b"# vtk"]) {
            Some(Self::Vtk)
        } else if begins(&[b"<"]) && names(b"<VTKFile") {
            Some(Self::Vtu)
        } else if begins(&[b"<"]) && names(b"<febio_spec") {
            Some(Self::Febio)
        } else if let Some(volume) = VolumeFormat::sniff(bytes) {
            Self::ALL.into_iter().find(|format| format.volume() == Some(volume))
        } else {
            stl::begins(bytes).then_some(Self::Stl)
        }
    }

    /// The format of label volumes that this is; `None` for those of meshes.
    pub fn volume(self) -> Option<VolumeFormat> {
        match self {
            Self::Nifti => Some(VolumeFormat::Nifti),
            Self::Nrrd => Some(VolumeFormat::Nrrd),
            Self::MetaImage => Some(VolumeFormat::MetaImage),
            _ => None,
        }
    }
}

/// Reads a mesh from one file; coordinates are in metres ([`Mesh::transformed`] scales others).
///
/// Nodes without a volume element are omitted, with a note.
///
/// # Errors
/// `Malformed`, with the place, for a violation of the format, a reference to a missing node, or a number that is not
/// finite; `UnsupportedElements` for volume elements of other kinds; `Unsupported` for versions, encodings and keywords
/// that are not supported; `Empty` for a file without volume elements.
pub fn read_mesh(bytes: &[u8], format: MeshFormat) -> Result<Mesh, MeshError> {
    let mut include = |_: &str| Err("included files are not available here".into());
    read_mesh_with(bytes, format, &FieldNames::NONE, &mut include)
}

/// Reads a mesh from a file and those that it includes (LS-DYNA), which `include` reads, with the arrays of elements (VTK) named
/// by `fields`, as far as the file has them.
///
/// # Errors
/// As [`read_mesh`], and `Unsupported` for a file that cannot be included.
pub fn read_mesh_with(
    bytes: &[u8],
    format: MeshFormat,
    fields: &FieldNames,
    include: Include,
) -> Result<Mesh, MeshError> {
    // The byte order mark, which no other content begins with.
    if let [0xff, 0xfe, ..] | [0xfe, 0xff, ..] = bytes {
        return Err(MeshError::Unsupported {
            what: "a text file in UTF-16".into(),
            remedy: "save it in UTF-8, as `iconv -f UTF-16 -t UTF-8 FILE` does".into(),
        });
    }
    let mut mesh = read_format(bytes, format, fields, include)?;
    // Programs end the last line of a text; where it has no end, a number may have been cut.
    let is_of_lines = matches!(format, MeshFormat::Abaqus | MeshFormat::LsDyna | MeshFormat::Nastran)
        || format == MeshFormat::Vtk && vtk::is_text(bytes);
    if is_of_lines && !bytes.ends_with(b"\n") {
        mesh.notes.push(
            "the last line of the file has no line break: the file may be truncated, and its last number wrong"
                .into(),
        );
    }
    Ok(mesh)
}

fn read_format(
    bytes: &[u8],
    format: MeshFormat,
    fields: &FieldNames,
    include: Include,
) -> Result<Mesh, MeshError> {
    match format {
        MeshFormat::Gmsh => gmsh::read(bytes),
        MeshFormat::Abaqus => abaqus::read(bytes),
        MeshFormat::Vtk => vtk::read_legacy(bytes, fields),
        MeshFormat::Vtu => vtk::read_unstructured(bytes, fields),
        MeshFormat::LsDyna => lsdyna::read(bytes, include),
        MeshFormat::Febio => febio::read(bytes),
        MeshFormat::Nastran => nastran::read(bytes),
        MeshFormat::Nifti | MeshFormat::Nrrd | MeshFormat::MetaImage => Err(MeshError::Unsupported {
            what: "a scan with labels, which has no elements".into(),
            remedy: "name it in \"mesh\": {\"segmentation\": {\"name\": …, \"size_m\": …}} of the body"
                .into(),
        }),
        MeshFormat::Stl => Err(MeshError::Unsupported {
            what: "a surface, which has no elements".into(),
            remedy: "name it in \"mesh\": {\"segmentation\": {\"surfaces\": [{\"name\": …, \"part\": …}], \"size_m\": …}} to fill it with elements, \
                     or in \"rigid\": {\"shape\": {\"kind\": \"stl\", \"name\": …}} of a rigid body"
                .into(),
        }),
    }
}
