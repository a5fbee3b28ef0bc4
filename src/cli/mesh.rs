//! `contuse mesh info`: contents and quality of a mesh file.

use super::json::write_json;
use super::mesh_file::{
    is_febio, is_scan, is_surface, read_febio_file, read_mesh_file, read_scan_file, read_surface_file,
};
use super::mesh_picture::Faces;
use super::picture::{picture_path, write_by_name};
use super::plan::write_table;
use super::{CliError, Exit};
use crate::mechanics::rigid::{MOST_PLANES, NoHull, Solid};
use crate::mesh::MeshError;
use crate::mesh::inspect::{Inspection, PartVolume, inspect};
use crate::mesh::names::shortened;
use crate::mesh::read::stl::ClosedSurface;
use crate::mesh::segmentation::ScanInspection;
use crate::scene::febio::NO_UNITS;
use clap::{Args, Subcommand};
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;

/// Subcommands on mesh files.
#[derive(Debug, Subcommand)]
pub enum MeshCommand {
    /// Show kinds, parts, node sets, bounding box, quality, and the worst elements of a mesh file; spacing and labels of a scan; volume and centre of mass of a surface.
    Info(InfoArgs),
}

/// Arguments of `contuse mesh info`.
#[derive(Args, Debug)]
pub struct InfoArgs {
    /// Mesh file: .msh, .inp, .vtk, .vtu, .k, .feb or .bdf; a scan with labels: .nii, .nii.gz, .nrrd or .mha; or a surface: .stl.
    pub file: PathBuf,
    /// Write a picture: the surface with a colour for each part, the worst elements marked (.svg; .png if built with the feature `png`).
    #[arg(long, value_name = "FILE", value_parser = picture_path)]
    pub picture: Option<PathBuf>,
    /// Print the answer as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Executes a command on a mesh file. Exit code 0 if the mesh can be computed with, 2 if it cannot.
///
/// # Errors
/// Why the file is no mesh.
pub fn mesh(command: &MeshCommand, out: &mut dyn Write) -> Result<Exit, CliError> {
    let MeshCommand::Info(args) = command;
    if is_scan(&args.file) {
        let (volume, name) = read_scan_file(&args.file)?;
        let found = ScanInspection::of(&volume);
        if let Some(path) = &args.picture {
            let faces =
                Faces::of_scan(&volume).map_err(|error| CliError::Usage(format!("{name}: {error}")))?;
            write_by_name(path, || Ok(faces.svg(&name, &[])))?;
        }
        if args.json {
            write_json(&found, out)?;
        } else {
            write_scan(&name, &found, out)?;
        }
        return Ok(Exit::Success);
    }
    if is_surface(&args.file) {
        if args.picture.is_some() {
            let words = "--picture draws meshes and scans, no closed surface: omit it, or write the mesh of a scene by `contuse convert`";
            return Err(CliError::Usage(words.into()));
        }
        let (surface, name) = read_surface_file(&args.file)?;
        let found = SurfaceInspection::of(&surface);
        if args.json {
            write_json(&found, out)?;
        } else {
            write_surface(&name, &found, out)?;
        }
        return Ok(Exit::Success);
    }
    let (mut mesh, name) = read_mesh_file(&args.file)?;
    if is_febio(&args.file) {
        let (_, scene) = read_febio_file(&args.file, None)?;
        let problems = scene.err().into_iter().flat_map(|problems| problems.0);
        let others = problems.filter(|problem| problem.code != NO_UNITS);
        mesh.notes.extend(others.map(|problem| format!("no counterpart in a scene: {}", problem.message)));
    }
    let found = inspect(&mesh).ok_or_else(|| CliError::Usage(format!("{name}: {}", MeshError::Empty)))?;
    if let Some(path) = &args.picture {
        write_by_name(path, || Ok(Faces::of_mesh(&mesh).svg(&name, &found.worst)))?;
    }
    if args.json {
        write_json(&found, out)?;
    } else {
        write_inspection(&name, &found, out)?;
    }
    let is_sound = found.report.quality.is_none_or(|quality| quality.negative_elements == 0);
    Ok(if is_sound { Exit::Success } else { Exit::InvalidInput })
}

/// What a surface encloses, in the unit of the file.
#[derive(Serialize)]
struct SurfaceInspection {
    triangles: usize,
    bounding_box: [[f64; 3]; 2],
    volume: f64,
    /// What a rigid body of it is placed and weighed by; absent where it has none.
    #[serde(flatten)]
    solid: Option<SolidInspection>,
    /// Why there is no rigid body of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    not_rigid: Option<String>,
}

#[derive(Serialize)]
struct SolidInspection {
    centre_of_mass: [f64; 3],
    /// Principal moments of inertia per mass.
    inertia_per_mass: [f64; 3],
    /// Volume of the convex hull over that of the surface.
    hull_ratio: f64,
    hull_planes: usize,
}

impl SurfaceInspection {
    fn of(surface: &ClosedSurface) -> Self {
        let made = Solid::new(&surface.points, &surface.triangles);
        let not_rigid = made.as_ref().err().map(|reason| match reason {
            NoHull::Flat(reason) => reason.clone(),
            NoHull::ManyPlanes => format!("its convex hull has more than {MOST_PLANES} planes"),
        });
        let solid = made.ok().map(|solid| SolidInspection {
            centre_of_mass: solid.centre.into(),
            inertia_per_mass: solid.hull.inertia_per_mass().into(),
            hull_ratio: solid.hull_ratio,
            hull_planes: solid.hull.plane_count(),
        });
        Self {
            triangles: surface.triangles.len(),
            bounding_box: surface.bounding_box().map(Into::into),
            volume: surface.volume(),
            solid,
            not_rigid,
        }
    }
}

fn write_surface(name: &str, found: &SurfaceInspection, out: &mut dyn Write) -> io::Result<()> {
    let words = |numbers: [f64; 3]| numbers.map(|x| format!("{x:.6}")).join(", ");
    let [low, high] = found.bounding_box.map(words);
    writeln!(
        out,
        "{name}: a closed surface of {} triangles; lengths in the unit of the file",
        found.triangles
    )?;
    writeln!(out, "  bounding box    ({low}) to ({high})")?;
    writeln!(out, "  volume          {:.6e}", found.volume)?;
    if let Some(solid) = &found.solid {
        writeln!(out, "  centre of mass  ({}), which a scene puts at center_m", words(solid.centre_of_mass))?;
        writeln!(out, "  inertia / mass  {}", words(solid.inertia_per_mass))?;
        writeln!(
            out,
            "  convex hull     {} planes, {:.3} times the volume, which is 1 for a convex surface",
            solid.hull_planes, solid.hull_ratio
        )?;
    }
    if let Some(reason) = &found.not_rigid {
        writeln!(out, "  rigid body      none: {reason}")?;
    }
    writeln!(
        out,
        "A body that deforms is filled with elements: `contuse scene from {name}` begins a scene of it"
    )
}

fn write_scan(name: &str, found: &ScanInspection, out: &mut dyn Write) -> io::Result<()> {
    let words = |numbers: [f64; 3]| numbers.map(|x| format!("{:.4}", 1e3 * x)).join(", ");
    let [a, b, c] = found.voxels;
    writeln!(out, "{name}: {a} × {b} × {c} voxels with labels")?;
    writeln!(out, "  spacing       {} mm", words(found.spacing_m))?;
    writeln!(
        out,
        "  bounding box  ({}) to ({}) mm",
        words(found.bounding_box_m[0]),
        words(found.bounding_box_m[1])
    )?;
    writeln!(out, "\nLabels (0 is outside)")?;
    let short = |numbers: [f64; 3]| numbers.map(|x| format!("{:.1}", 1e3 * x)).join(", ");
    let rows = found.labels.iter().map(|l| {
        let [low, high] = l.bounding_box_m.map(short);
        let name = l.name.as_deref().map_or_else(|| "-".to_owned(), shortened);
        let volume = format!("{:.6e}", l.volume_m3);
        [
            l.label.to_string(),
            name,
            l.voxels.to_string(),
            volume,
            format!("({low}) to ({high})"),
            short(l.centre_m),
        ]
    });
    let header = ["label", "name", "voxels", "volume, m³", "bounding box, mm", "centre, mm"];
    write_table(&header, &rows.collect::<Vec<_>>(), out)?;
    found.notes.iter().try_for_each(|note| writeln!(out, "note: {note}"))
}

fn write_inspection(name: &str, found: &Inspection, out: &mut dyn Write) -> io::Result<()> {
    let report = &found.report;
    writeln!(
        out,
        "{name}: {} elements, {} nodes; lengths in the unit of the file",
        report.elements, report.nodes
    )?;
    let kinds: Vec<String> = found.kinds.iter().map(|k| format!("{} {}", k.elements, k.kind)).collect();
    writeln!(out, "  kinds         {}", kinds.join(", "))?;
    let [low, high] = [report.bounding_box_min, report.bounding_box_max]
        .map(|corner| corner.map(|x| format!("{x:.6}")).join(", "));
    writeln!(out, "  bounding box  ({low}) to ({high})")?;
    if let Some(quality) = &report.quality {
        writeln!(out, "  volume        {:.6e}", quality.volume)?;
        let (from, to, aspect) = (quality.min_edge, quality.max_edge, ratio(quality.max_aspect_ratio));
        writeln!(out, "  edges         {from:.4e} to {to:.4e}, aspect ratio up to {aspect}")?;
    }

    writeln!(out, "\nParts")?;
    let parts = found.part_volumes.iter().map(|PartVolume { part, volume }| {
        [shortened(part), report.parts[part].to_string(), format!("{volume:.6e}")]
    });
    write_table(&["part", "elements", "volume"], &parts.collect::<Vec<_>>(), out)?;
    if !report.node_sets.is_empty() {
        writeln!(out, "\nNode sets")?;
        let sets = report.node_sets.iter().map(|(name, nodes)| [shortened(name), nodes.to_string()]);
        write_table(&["set", "nodes"], &sets.collect::<Vec<_>>(), out)?;
    }
    write_quality(found, out)?;
    report.notes.iter().try_for_each(|note| writeln!(out, "note: {note}"))
}

/// A ratio of edges, where the shortest may have no length.
fn ratio(aspect: Option<f64>) -> String {
    aspect.map_or_else(|| "infinite".to_owned(), |ratio| format!("{ratio:.1}"))
}

fn write_quality(found: &Inspection, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "\nSmallest scaled Jacobian of each element (1 in the ideal element)")?;
    for bin in found.histogram.iter().filter(|bin| bin.elements > 0) {
        let percentage = 100.0 * bin.elements as f64 / found.report.elements as f64;
        writeln!(out, "  {:4.1} to {:3.1}  {:>9}  {percentage:5.1} %", bin.from, bin.to, bin.elements)?;
    }
    writeln!(out, "\nWorst elements")?;
    let header = ["element", "kind", "part", "scaled Jacobian", "aspect ratio", "centre"];
    let rows = found.worst.iter().map(|element| {
        [
            element.element.to_string(),
            element.kind.to_owned(),
            shortened(&element.part),
            format!("{:.4}", element.scaled_jacobian),
            ratio(element.aspect_ratio),
            element.centre.map(|x| format!("{x:.6}")).join(", "),
        ]
    });
    write_table(&header, &rows.collect::<Vec<_>>(), out)?;
    let Some(quality) = &found.report.quality else { return Ok(()) };
    writeln!(out)?;
    for (count, what) in [
        (
            quality.negative_elements,
            "elements cannot be computed: a Jacobian at a quadrature point is not positive",
        ),
        (quality.folded_elements, "elements are folded at a corner: computed with poor accuracy"),
        (
            quality.coincident_nodes,
            "nodes are at the position of another: intended where bodies touch, else a crack",
        ),
    ] {
        if count > 0 {
            writeln!(out, "{count} {what}")?;
        }
    }
    Ok(())
}
