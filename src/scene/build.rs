//! A body of the document → its mesh, in place, with a part entry and material axes for every element.

use super::budget::Budget;
use super::document::{
    BodyDocument, MeshDocument, MeshFileDocument, PartDocument, PlacementDocument, RigidDocument,
    SceneDocument, ShapeDocument,
};
use super::file_problem::{mesh_problem, scan_problem, source_problem, table_not_found};
use super::generator_problem::generator_problem;
use super::problem::{Pointer, Problem, suggest};
use super::refinement::Meshes;
use super::rigid_surface;
use super::scene_body::RigidSceneBody;
use super::segmentation_document::SegmentationDocument;
use super::segmentation_source::{read_scan, read_surfaces};
use super::source::{MeshBytes, MeshSource};
use super::validate::Findings;
use super::validate::rigid::check_of_shape;
use super::validate::segmentation::{check_effect, check_label_volumes, check_noise, check_scan};
use crate::mechanics::rigid::Shape;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::mesh::cracks::{Cracks, recognise_hanging};
use crate::mesh::generate::Generator;
use crate::mesh::read::table::add_table;
use crate::mesh::read::{FieldNames, MeshFormat, read_mesh_with};
use crate::mesh::refine::refined;
use crate::mesh::segmentation;
use nalgebra::{Rotation3, Unit};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A mesh after local refinement.
pub struct Refined {
    /// The mesh with its elements split.
    pub mesh: Mesh,
    /// Number of elements before, and how many of them were split; `None` where nothing was to be refined.
    pub refined: Option<[usize; 2]>,
}

/// Makes the meshes of a scene; a file named by several bodies is read once.
pub struct Builder<'a> {
    source: &'a dyn MeshSource,
    budget: &'a Budget,
    files: BTreeMap<(String, Option<String>), Result<Mesh, Problem>>,
    /// Arrays of elements that any body of the scene names.
    fields: FieldNames,
    /// SHA-256 of each file, by its name in the scene.
    pub file_hashes: BTreeMap<String, [u8; 32]>,
    /// Scans and surfaces, by their names in the scene.
    pub kept_files: BTreeMap<String, MeshBytes>,
    /// Elements that the budget still allows.
    elements_left: u64,
}

impl<'a> Builder<'a> {
    /// A builder for one scene, with the whole budget left.
    pub fn new(document: &SceneDocument, source: &'a dyn MeshSource, budget: &'a Budget) -> Self {
        let parts = document.bodies.iter().flat_map(|body| &body.parts);
        Self {
            source,
            budget,
            files: BTreeMap::new(),
            fields: FieldNames::Named(parts.flat_map(PartDocument::array_names).cloned().collect()),
            file_hashes: BTreeMap::new(),
            kept_files: BTreeMap::new(),
            elements_left: budget.elements,
        }
    }

    /// The mesh of a body, in place; `None` when problems were found.
    pub fn body_mesh(&mut self, index: usize, body: &BodyDocument, out: &mut Findings) -> Option<Mesh> {
        let here = Pointer::root().key("bodies").index(index);
        let mesh = match body.mesh.as_ref()? {
            MeshDocument::Generator(generator) => {
                self.generated(generator, &here.key("mesh").key("generator"), out)?
            }
            MeshDocument::File(file) => {
                let mesh = self.read_from_file(file, &here.key("mesh").key("file"), out)?;
                check_hanging(body, &mesh, &here, out);
                mesh
            }
            MeshDocument::Segmentation(scan) => {
                self.of_scan(scan, &here.key("mesh").key("segmentation"), out)?
            }
        };
        match &body.placement {
            Some(placement) => placed(&mesh, placement, &here.key("placement"), out),
            None => Some(mesh),
        }
    }

    /// The locally refined mesh of a body, given the placed meshes of all bodies.
    pub fn refined(
        &mut self,
        (document, placed): (&SceneDocument, &[Option<Mesh>]),
        index: usize,
        out: &mut Findings,
    ) -> Option<Refined> {
        let mesh = placed[index].as_ref()?;
        let meshes = Meshes { document, placed };
        let (fine, split) = meshes.refined(index, self.elements_left, out)?;
        let before = mesh.cells.len();
        self.elements_left -= (fine.cells.len() - before) as u64;
        Some(Refined { mesh: fine, refined: Some([before, split]) })
    }

    /// A rigid body from its document; `None` where problems were found, or the checks of the document report why not.
    pub fn rigid_body(
        &mut self,
        index: usize,
        (body, rigid): (&BodyDocument, &RigidDocument),
        out: &mut Findings,
    ) -> Option<RigidSceneBody> {
        let here = Pointer::root().key("bodies").index(index).key("rigid");
        let mut pose = rigid.pose()?;
        let shape = match &rigid.shape {
            ShapeDocument::Stl { name, scale, convex_hull } => {
                let place = here.key("shape");
                let read = rigid_surface::read(self.source, (name, self.budget.mesh_bytes), *scale, &place);
                let (solid, file) = read.map_err(|problem| out.push(problem)).ok()?;
                self.keep(name, file);
                rigid_surface::check_hull(&solid, *convex_hull, &place.key("convex_hull"), out)?;
                pose.orientation *= solid.axes;
                Shape::Polyhedron(Arc::new(solid.hull))
            }
            shape => shape.shape()?,
        };
        let mass = rigid.mass(&shape)?;
        let held = [[false; 3]; 2];
        let made = RigidSceneBody { inertia: rigid.inertia(&shape, mass), shape, mass, pose, held };
        // The checks of the document know all other shapes.
        let before = out.0.error_count();
        if rigid.shape.shape().is_none() {
            check_of_shape(index, body, rigid, &made.shape, out);
        }
        (out.0.error_count() == before).then_some(made)
    }

    fn generated(&mut self, generator: &Generator, here: &Pointer, out: &mut Findings) -> Option<Mesh> {
        // The number of elements is known before anything is allocated.
        self.spend(generator.element_count(), here, out)?;
        let problems = generator.problems();
        if !problems.is_empty() {
            out.0.extend(problems.iter().map(|found| generator_problem(found, here)));
            return None;
        }
        generator.generate().map_err(|error| out.push(mesh_problem(&error, here))).ok()
    }

    fn read_from_file(
        &mut self,
        file: &MeshFileDocument,
        here: &Pointer,
        out: &mut Findings,
    ) -> Option<Mesh> {
        let key = (file.name.clone(), file.table.clone());
        if !self.files.contains_key(&key) {
            let mesh = self.read(file, here);
            self.files.insert(key.clone(), mesh);
        }
        let mesh = match self.files.get(&key)? {
            Ok(mesh) => mesh.clone(),
            // Reported for each body that names the file.
            Err(problem) => {
                let of_table = problem.pointer.ends_with("/table");
                let place = here.key(if of_table { "table" } else { "name" });
                out.push(Problem { pointer: place.as_str().to_owned(), ..problem.clone() });
                return None;
            }
        };
        let mesh = match &file.parts {
            None => mesh,
            Some(parts) => selected(&mesh, parts, &here.key("parts"), out)?,
        };
        let mesh = with_hanging(mesh, here, out)?;
        let children = 8_u64.checked_pow(file.refine).unwrap_or(u64::MAX);
        let refine = here.key("refine");
        let place = if file.refine > 0 { refine.clone() } else { here.clone() };
        self.spend((mesh.cells.len() as u64).saturating_mul(children), &place, out)?;
        let finer = (0..file.refine).try_fold(mesh, |mesh, _| refined(&mesh));
        finer.map_err(|error| out.push(mesh_problem(&error, &refine))).ok()
    }

    /// The mesh of the labels of a scan, or of surfaces.
    fn of_scan(&mut self, scan: &SegmentationDocument, here: &Pointer, out: &mut Findings) -> Option<Mesh> {
        // Reported by the checks of the document; the mesh is made of these numbers.
        if !(scan.is_sound()) {
            return None;
        }
        let limit = self.budget.mesh_bytes;
        let (volume, volumes_m3) = if let Some(name) = &scan.name {
            let read = read_scan(self.source, name, limit, &here.key("name"));
            let (volume, file) = read.map_err(|problem| out.push(problem)).ok()?;
            self.keep(name, file);
            (volume, Vec::new())
        } else {
            let read = read_surfaces(self.source, scan, limit, &here.key("surfaces"));
            let (filled, files) = read.map_err(|problem| out.push(problem)).ok()?;
            for (name, file) in files {
                self.keep(&name, file);
            }
            (filled.volume, filled.volumes_m3)
        };
        check_scan(scan, &volume, here, out);
        let made = segmentation::mesh(&volume, &scan.options(self.elements_left, volumes_m3));
        let mesh = made.map_err(|error| out.push(scan_problem(&error, here))).ok()?;
        check_effect(scan, &volume, &mesh, here, out);
        check_label_volumes(&mesh, here, out);
        check_noise(&mesh, here, out);
        self.spend(mesh.cells.len() as u64, here, out)?;
        Some(mesh)
    }

    fn keep(&mut self, name: &str, file: MeshBytes) {
        self.file_hashes.insert(name.to_owned(), Sha256::digest(&file.bytes).into());
        self.kept_files.insert(name.to_owned(), file);
    }

    /// The mesh of a file, with the arrays of its elements that bodies name, and with its table.
    fn read(&mut self, file: &MeshFileDocument, here: &Pointer) -> Result<Mesh, Problem> {
        let limit = self.budget.mesh_bytes;
        let requested = (&file.name[..], &self.fields);
        let (mut mesh, file_hashes) = read_file(self.source, requested, limit, &here.key("name"))?;
        self.file_hashes.extend(file_hashes);
        if let Some(name) = &file.table {
            let place = here.key("table");
            let found = self.source.read(name, limit);
            let found = found.map_err(|error| table_not_found(&error, &place).value(name.as_str()))?;
            self.file_hashes.insert(name.clone(), Sha256::digest(&found.bytes).into());
            add_table(&mut mesh, &found.bytes).map_err(|error| {
                Problem::error("bad_table", &place, error.to_string())
                    .value(name.as_str())
                    .limit("CSV with a header: element or part, then names of columns")
                    .remedy(
                        "correct this line; `contuse mesh info` shows the parts and the number of elements",
                    )
            })?;
        }
        Ok(mesh)
    }

    /// Takes elements from the budget; reports a problem when too few are left.
    fn spend(&mut self, elements: u64, here: &Pointer, out: &mut Findings) -> Option<()> {
        let left = self.elements_left.checked_sub(elements);
        if let Some(left) = left {
            self.elements_left = left;
        } else {
            out.push(
                Problem::error("budget_elements", here, format!("this mesh has {elements} elements"))
                    .value(elements)
                    .limit(format!(
                        "at most {} elements in all bodies, of which {} are left",
                        self.budget.elements, self.elements_left
                    ))
                    .remedy("use a coarser mesh"),
            );
        }
        left.map(|_| ())
    }
}

/// The mesh of a file of a source with the arrays of its elements that are named, and the SHA-256 of that file and of those that it includes, by name. Together they have at
/// most `limit` bytes.
///
/// # Errors
/// Why it cannot be read, as a problem at `place`.
pub fn read_file(
    source: &dyn MeshSource,
    (name, fields): (&str, &FieldNames),
    limit: u64,
    place: &Pointer,
) -> Result<(Mesh, BTreeMap<String, [u8; 32]>), Problem> {
    let found = source.read(name, limit).map_err(|error| source_problem(&error, place).value(name))?;
    // The format of a file without a known extension (an uploaded mesh) is detected from its first bytes.
    let format = MeshFormat::from_name(&found.file_name).or_else(|| MeshFormat::sniff(&found.bytes));
    let format = format.ok_or_else(|| {
        Problem::error("unknown_mesh_format", place, "the format of the mesh is not known")
            .value(name)
            .limit(format!("a file name ending in {}", MeshFormat::extensions_in_words()))
            .remedy("save the mesh in one of these formats")
    })?;
    let mut file_hashes = BTreeMap::from([(name.to_owned(), Sha256::digest(&found.bytes).into())]);
    let mut left = limit.saturating_sub(found.bytes.len() as u64);
    let mut include = |included: &str| {
        let other = source.read_included(name, included, left).map_err(|error| error.to_string())?;
        left = left.saturating_sub(other.bytes.len() as u64);
        file_hashes.insert(other.file_name, Sha256::digest(&other.bytes).into());
        Ok(other.bytes)
    };
    let mesh = read_mesh_with(&found.bytes, format, fields, &mut include);
    Ok((mesh.map_err(|error| mesh_problem(&error, place).value(name))?, file_hashes))
}

/// Refuses to split elements of a file with hanging nodes: their neighbours may be two levels coarser.
fn check_hanging(body: &BodyDocument, mesh: &Mesh, here: &Pointer, out: &mut Findings) {
    out.require(mesh.hanging.is_empty() || body.refinement.is_empty(), || {
        let message = "the file already has hanging nodes, next to which elements cannot be split again";
        Problem::error("refinement_of_hanging", &here.key("refinement"), message)
            .limit("no refinement of a file with hanging nodes")
            .remedy("name the file of the coarse mesh, or remove the refinement")
    });
}

/// The mesh with its hanging nodes, of which files say nothing.
fn with_hanging(mut mesh: Mesh, here: &Pointer, out: &mut Findings) -> Option<Mesh> {
    match recognise_hanging(&mut mesh) {
        Ok(0) => {}
        Ok(count) => {
            // A set has a hanging node only with all that it hangs on.
            for set in mesh.node_sets.values_mut() {
                mesh.hanging.complete(set);
            }
            mesh.notes
                .push(format!("{count} nodes hang in the middles of edges and faces of coarser elements"));
        }
        Err(Cracks { count, example: (node, x) }) => {
            let message = format!(
                "{count} nodes lie on a face or an edge of an element that does not contain them, such as node {node} at ({}, {}, {}): the mesh would open there",
                x.x, x.y, x.z
            );
            out.push(
                Problem::error("cracks", here, message)
                    .value(count)
                    .limit("elements that share their nodes, or hexahedra with nodes in the middles of edges and faces of coarser ones")
                    .remedy("make a mesh whose elements share their nodes, or a coarse one with \"refinement\" of the body"),
            );
            return None;
        }
    }
    Some(mesh)
}

/// Only some parts of a mesh; every unknown name is a problem.
fn selected(mesh: &Mesh, parts: &[String], here: &Pointer, out: &mut Findings) -> Option<Mesh> {
    let known = || mesh.parts.iter().map(String::as_str);
    let mut sound = !parts.is_empty();
    out.require(sound, || {
        Problem::error("no_parts", here, "no part is selected")
            .value(Vec::<f64>::new())
            .limit("at least one part")
            .remedy(format!("omit \"parts\" to take all; {}", suggest("", known())))
    });
    for (i, name) in parts.iter().enumerate() {
        if !known().any(|k| k == name) {
            sound = false;
            out.push(
                Problem::error("unknown_part", &here.index(i), format!("the mesh has no part {name:?}"))
                    .value(name.as_str())
                    .limit("a part of the mesh")
                    .remedy(suggest(name, known())),
            );
        }
    }
    if !sound {
        return None;
    }
    let names: Vec<&str> = parts.iter().map(String::as_str).collect();
    mesh.select_parts(&names).map_err(|error| out.push(mesh_problem(&error, here))).ok()
}

/// The mesh scaled, rotated and translated. Invalid numbers are reported by the checks of the document.
fn placed(mesh: &Mesh, placement: &PlacementDocument, here: &Pointer, out: &mut Findings) -> Option<Mesh> {
    let rotation = match &placement.rotation {
        None => Rotation3::identity(),
        Some(rotation) => {
            let axis = Unit::try_new(Vec3::from(rotation.axis), 0.0)?;
            Rotation3::from_axis_angle(&axis, rotation.angle_deg.to_radians())
        }
    };
    if placement.scale.is_nan() || placement.scale <= 0.0 {
        return None;
    }
    let moved = mesh.transformed(&rotation, &Vec3::from(placement.translation_m), placement.scale);
    moved.map_err(|error| out.push(mesh_problem(&error, here))).ok()
}
