//! `contuse convert`: a mesh file, the elements of a scan, or the mesh of a body of a scene, in another format.

use super::mesh_file::{is_scan, read_mesh_and_fields, read_scan_file};
use super::output_file::{MESH, check_distinct, check_output, write_file};
use super::{CliError, Exit};
use crate::mechanics::tensor::Vec3;
use crate::mesh::read::FieldNames;
use crate::mesh::segmentation::{self, Options};
use crate::mesh::write::gmsh::{Encoding, Version, write_gmsh};
use crate::mesh::{ElementField, Mesh};
use crate::record::vtk::write_vtu;
use crate::scene::document::SceneDocument;
use crate::scene::{Budget, SceneBody, load_file};
use clap::{Args, ValueEnum};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `contuse convert`.
#[derive(Args, Debug)]
pub struct ConvertArgs {
    /// Mesh file to read: .msh, .inp, .vtk, .vtu, .k, .feb or .bdf; a scan with labels: .nii, .nii.gz, .nrrd or .mha; or a scene: .json.
    pub input: PathBuf,
    /// Mesh file to write: .msh; or .vtu with the cell arrays of VTK files, or the fibre axes and stiffness factors of a scene's body.
    pub output: PathBuf,
    /// Largest edge of the elements that fill a scan [m].
    #[arg(long)]
    pub size_m: Option<f64>,
    /// Body of a scene whose mesh is written; by default the only one with a mesh.
    #[arg(long)]
    pub body: Option<String>,
    /// Version of the Gmsh format.
    #[arg(long, value_enum, default_value = "4.1")]
    pub gmsh: GmshVersion,
    /// Write binary numbers instead of text in a Gmsh file.
    #[arg(long)]
    pub binary: bool,
}

/// Versions of the Gmsh format.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum GmshVersion {
    /// Version 2.2.
    #[value(name = "2.2")]
    V2_2,
    /// Version 4.1.
    #[value(name = "4.1")]
    V4_1,
}

/// Fields of the elements that are written beside a mesh.
type Fields = BTreeMap<String, ElementField>;

/// Reads a mesh and writes it in another format; notes of the reader go to standard error.
///
/// # Errors
/// Why a file cannot be read or written.
pub fn convert(args: &ConvertArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    let has = |extension: &str| has_extension(&args.output, extension);
    if !has("msh") && !has("vtu") {
        let output = args.output.display();
        let message =
            format!("{output}: meshes are written to files whose names end in .msh (Gmsh) or .vtu (VTK)");
        return Err(CliError::Usage(message));
    }
    check_distinct([&args.input, &args.output])?;
    check_output(&args.output, &MESH, "OUTPUT")?;
    let (mesh, fields) = if has_extension(&args.input, "json") {
        body_of_scene(args)?
    } else if is_scan(&args.input) {
        (mesh_of_scan(args)?, Fields::new())
    } else {
        let (mut mesh, _) = read_mesh_and_fields(&args.input, &FieldNames::All)?;
        let fields = std::mem::take(&mut mesh.fields).into_map();
        (mesh, fields)
    };
    mesh.notes.iter().for_each(|note| eprintln!("note: {note}"));
    if has("vtu") {
        write_file(&args.output, |file| write_vtu(&mesh, &fields, file))?;
    } else {
        let version = match args.gmsh {
            GmshVersion::V2_2 => Version::V2_2,
            GmshVersion::V4_1 => Version::V4_1,
        };
        let encoding = if args.binary { Encoding::LittleEndian } else { Encoding::Ascii };
        let bytes = write_gmsh(&mesh, version, encoding);
        write_file(&args.output, |file| file.write_all(&bytes))?;
        for name in fields.keys() {
            eprintln!("note: {name} is not written: name a .vtu file for it");
        }
    }
    if !mesh.hanging.is_empty() {
        let hanging = mesh.hanging.len();
        eprintln!(
            "note: {hanging} nodes hang between elements of two sizes; a scene that reads this file recognises them"
        );
    }
    writeln!(out, "{}: {} elements, {} nodes", args.output.display(), mesh.cells.len(), mesh.nodes.len())?;
    Ok(Exit::Success)
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension))
}

/// A scan filled with elements of one size, each label as a part.
fn mesh_of_scan(args: &ConvertArgs) -> Result<Mesh, CliError> {
    let size_m = args.size_m.filter(|size| *size > 0.0 && size.is_finite()).ok_or_else(|| {
        CliError::Usage("a scan is filled with elements of a size: add --size-m, such as --size-m 0.005; for holes, layers and small elements around a point, \
                         write a scene and name that".into())
    })?;
    let (volume, name) = read_scan_file(&args.input)?;
    let options = Options {
        labels: Vec::new(),
        volumes_m3: Vec::new(),
        size_m,
        near: Vec::new(),
        thin_size_m: None,
        crop: None,
        skin: None,
        noise_m3: None,
        max_elements: Budget::COMMAND_LINE.elements,
    };
    segmentation::mesh(&volume, &options).map_err(|error| CliError::Usage(format!("{name}: {error}")))
}

/// The mesh of a body of a scene, in its place, with what the scene gives its elements.
fn body_of_scene(args: &ConvertArgs) -> Result<(Mesh, Fields), CliError> {
    let loaded = load_file(&args.input, &Budget::COMMAND_LINE)?;
    let document = &loaded.scene.document;
    let meshed = || document.bodies.iter().enumerate().filter(|(_, body)| body.rigid.is_none());
    let names = || meshed().map(|(_, body)| body.name.as_str()).collect::<Vec<_>>().join(", ");
    let found = match &args.body {
        Some(name) => meshed().find(|(_, body)| body.name == *name),
        None => meshed().next().filter(|_| meshed().count() == 1),
    };
    let (index, _) = found.ok_or_else(|| {
        CliError::Usage(format!(
            "{}: name one of its bodies with a mesh by --body: {}",
            args.input.display(),
            names()
        ))
    })?;
    let body = &loaded.scene.bodies[index];
    Ok((body.mesh.clone(), fields_of(document, index, body)))
}

/// Unit directions of the fibre families, `fibre_1` and so on, zero where an element has no such family; `stiffness_factor`.
fn fields_of(document: &SceneDocument, index: usize, body: &SceneBody) -> Fields {
    let law = |element: usize| &body.materials[body.law_of[element] as usize];
    let elements = 0..body.mesh.cells.len();
    let families = body.materials.iter().map(|law| law.fibre_directions().len()).max().unwrap_or(0);
    let direction = |element: usize, family: usize| {
        let of_law = law(element).fibre_directions().get(family);
        let axes = body.axes.get(element);
        of_law.zip(axes).map_or_else(Vec3::zeros, |(of_law, axes)| axes * Vec3::from(*of_law))
    };
    let of_family = |family: usize| {
        let vectors = elements.clone().map(|element| direction(element, family)).collect();
        (format!("fibre_{}", family + 1), ElementField::Vectors(vectors))
    };
    let mut fields: Fields = (0..families).map(of_family).collect();
    if document.bodies[index].parts.iter().any(|part| part.stiffness_factor.is_some()) {
        let of_part = |element: usize| &body.materials[body.part_entry[element] as usize];
        let ratio = |e: usize| law(e).moduli_at_rest().0 / of_part(e).moduli_at_rest().0;
        fields.insert("stiffness_factor".into(), ElementField::Scalars(elements.map(ratio).collect()));
    }
    fields
}
