//! `contuse convert`: a mesh file in another format.

use super::mesh_file::read_mesh_file;
use super::output_file::write_file;
use super::{CliError, Exit};
use crate::mesh::write::gmsh::{Encoding, Version, write_gmsh};
use clap::{Args, ValueEnum};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `contuse convert`.
#[derive(Args, Debug)]
pub struct ConvertArgs {
    /// Mesh file to read: .msh, .inp, .vtk, .vtu, .k, .feb or .bdf.
    pub input: PathBuf,
    /// Mesh file to write: .msh.
    pub output: PathBuf,
    /// Version of the Gmsh format.
    #[arg(long, value_enum, default_value = "4.1")]
    pub gmsh: GmshVersion,
    /// Write binary numbers instead of text.
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

/// Reads a mesh and writes it in another format; notes of the reader go to standard error.
///
/// # Errors
/// Why a file cannot be read or written.
pub fn convert(args: &ConvertArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    if !args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("msh")) {
        let message =
            format!("{}: meshes are written as Gmsh files, whose names end in .msh", args.output.display());
        return Err(CliError::Usage(message));
    }
    let (mesh, _) = read_mesh_file(&args.input)?;
    mesh.notes.iter().for_each(|note| eprintln!("note: {note}"));
    let version = match args.gmsh {
        GmshVersion::V2_2 => Version::V2_2,
        GmshVersion::V4_1 => Version::V4_1,
    };
    let encoding = if args.binary { Encoding::LittleEndian } else { Encoding::Ascii };
    let bytes = write_gmsh(&mesh, version, encoding);
    write_file(&args.output, |file| file.write_all(&bytes))?;
    writeln!(out, "{}: {} elements, {} nodes", args.output.display(), mesh.cells.len(), mesh.nodes.len())?;
    Ok(Exit::Success)
}
