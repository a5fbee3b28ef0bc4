//! Bytes → [`Scene`], or all problems of the document.

use super::budget::Budget;
use super::build::{Builder, Refined};
use super::checked_scene::Scene;
use super::document::{BodyDocument, IntegratorDocument, PartDocument, RigidDocument, SceneDocument};
use super::element_values::{Laws, body_axes, laws};
use super::elements;
use super::integrator_choice::{self, IntegratorChoice};
use super::problem::{Pointer, Problem, Problems};
use super::read::read;
use super::scene_body::SceneBody;
use super::source::{FolderSource, KeptFiles, MeshSource};
use super::summary::BodySummary;
use super::validate::estimate::{self, Estimate};
use super::validate::{
    Findings, approach, bodies, check_document, loads, meshes, overlap, segmentation, side,
};
use super::{json, named_materials, schema};
use crate::blobs::hexadecimal;
use crate::mechanics::tensor::Vec3;
use crate::mesh::{ElementFields, Mesh};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;

/// A valid scene with its warnings and its estimated cost.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene, ready to be compiled.
    pub scene: Scene,
    /// Warnings: what may not be intended.
    pub warnings: Vec<Problem>,
    /// Estimated cost of the run.
    pub estimate: Estimate,
    /// Counts, mass and mesh quality of each body.
    pub bodies: Vec<BodySummary>,
}

/// Loads a scene from the bytes of its document; mesh files come from `source`.
///
/// # Errors
/// All problems at once, warnings included. Where the structure is invalid, the valid rest is still checked.
pub fn load(document_json: &[u8], source: &dyn MeshSource, budget: &Budget) -> Result<Loaded, Problems> {
    let size = document_json.len() as u64;
    if size > budget.document_bytes {
        let problem = Problem::error("budget_document_bytes", &Pointer::root(), "the document is too large");
        return Err(problem
            .value(size)
            .limit(format!("at most {} bytes", budget.document_bytes))
            .remedy("put meshes into separate files")
            .alone());
    }
    load_parsed(&json::parse(document_json)?, source, budget)
}

/// As [`load`], for a document that is already parsed.
///
/// # Errors
/// As [`load`].
pub fn load_parsed(
    parsed: &json::Parsed,
    source: &dyn MeshSource,
    budget: &Budget,
) -> Result<Loaded, Problems> {
    let (document, checked) = read::<SceneDocument>(parsed, &schema::SCENE, named_materials::resolve_scene)?;
    let whole = checked.placeholders.is_empty();
    let (found, parts) = examine(&document, whole, source, budget);
    complete(document, checked.merged_with(found), parts)
}

/// As [`load`], for a document derived from a loaded one: its structure is valid.
///
/// # Errors
/// All problems at once, warnings included.
pub fn load_document(
    document: SceneDocument,
    source: &dyn MeshSource,
    budget: &Budget,
) -> Result<Loaded, Problems> {
    // Computed numbers need not be finite; JSON writes those as null, which the schema reports.
    let written = serde_json::to_value(&document).unwrap_or_default();
    if holds_null(&written) {
        return load_parsed(&written.into(), source, budget);
    }
    let (found, parts) = examine(&document, true, source, budget);
    complete(document, found.0.into_vec(), parts)
}

fn holds_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(items) => items.iter().any(holds_null),
        Value::Object(members) => members.values().any(holds_null),
        _ => false,
    }
}

/// The scene of a document, unless a problem is an error.
fn complete(
    mut document: SceneDocument,
    problems: Vec<Problem>,
    parts: Option<Parts>,
) -> Result<Loaded, Problems> {
    match parts {
        Some(parts) if problems.iter().all(|p| !p.is_error()) => {
            document.integrator = parts.integrator;
            let Parts { content_hash, choice, bodies, mesh_files, kept_files, .. } = parts;
            let warnings = problems.iter().map(Problem::in_words).collect();
            Ok(Loaded {
                scene: Scene { document, choice, bodies, warnings, content_hash, mesh_files, kept_files },
                warnings: problems,
                estimate: parts.estimate,
                bodies: parts.summaries,
            })
        }
        parts => {
            let mut problems = problems;
            // A body is only missing for a reason; should there be none, saying so is better than an empty list.
            if parts.is_none() && problems.iter().all(|p| !p.is_error()) {
                let message = "the scene could not be built, and no check says why";
                problems
                    .push(Problem::error("internal", &Pointer::root(), message).remedy("report this scene"));
            }
            Err(Problems(problems))
        }
    }
}

/// Loads a scene from a file; its meshes are in the same folder.
///
/// # Errors
/// As [`load`]; an unreadable file is a problem too.
pub fn load_file(path: &Path, budget: &Budget) -> Result<Loaded, Problems> {
    let bytes = std::fs::read(path).map_err(|error| {
        let message = format!("{} cannot be read: {error}", path.display());
        Problem::error("unreadable", &Pointer::root(), message).remedy("check the path of the scene").alone()
    })?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    load(&bytes, &FolderSource::new(folder), budget)
}

/// The scene of a document that differs from that of a loaded scene in its motion only
/// ([`SceneDocument::differs_in_motion_only`]), with the meshes of that scene; `None` for any other document.
///
/// # Errors
/// All problems of the document at once. Meshes, overlaps and costs are those of the loaded scene.
pub fn with_motion(
    scene: &Scene,
    document: &SceneDocument,
    budget: &Budget,
) -> Option<Result<Scene, Problems>> {
    if !scene.document.differs_in_motion_only(document) {
        return None;
    }
    let found = check_document(document, budget);
    if found.0.has_errors() {
        return Some(Err(found.0.into()));
    }
    Some(Ok(with_bodies(scene, document, scene.bodies.clone())))
}

/// The scene of a document whose bodies have the meshes of a loaded scene, which are reused; `None` where a mesh, its
/// placement or a part differs.
///
/// # Errors
/// All problems of the document at once. Overlaps and warnings are those of the loaded scene.
pub fn on_meshes_of(
    scene: &Scene,
    document: &SceneDocument,
    budget: &Budget,
) -> Option<Result<Scene, Problems>> {
    let known = &scene.document.bodies;
    let has_same_mesh = |(a, b): (&BodyDocument, &BodyDocument)| {
        let parts = |body: &BodyDocument| -> Vec<_> {
            body.parts
                .iter()
                .map(|p| (p.part.clone(), p.fibre_frame.clone(), p.material.family_count()))
                .collect()
        };
        (&a.rigid, &a.mesh, &a.placement, &a.sets) == (&b.rigid, &b.mesh, &b.placement, &b.sets)
            && (&a.initial_deformation, &a.fixed, &a.prescribed)
                == (&b.initial_deformation, &b.fixed, &b.prescribed)
            && (&a.face_loads, &a.refinement) == (&b.face_loads, &b.refinement)
            && (!document.is_refined_around_impact()
                || Vec3::from(a.velocity_m_per_s) == Vec3::from(b.velocity_m_per_s))
            && parts(a) == parts(b)
    };
    // Numbers of the elements are not kept: axes and laws made of them are made again.
    let has_arrays = |body: &BodyDocument| body.parts.iter().any(|part| part.array_names().next().is_some());
    let is_same = known.len() == document.bodies.len()
        && !known.iter().chain(&document.bodies).any(has_arrays)
        && scene.document.planes == document.planes
        && known.iter().zip(&document.bodies).all(has_same_mesh);
    if !is_same {
        return None;
    }
    // Other laws and settings: the document's own checks, the laws, and the cost again.
    let mut out = check_document(document, budget);
    if out.0.has_errors() {
        return Some(Err(out.0.into()));
    }
    let mut bodies = scene.bodies.clone();
    for (body, written) in bodies.iter_mut().zip(&document.bodies) {
        body.materials = written.parts.iter().map(PartDocument::law).collect::<Option<_>>()?;
    }
    estimate::check(document, &document.integrator, &bodies, budget, &mut out);
    if out.0.has_errors() {
        return Some(Err(out.0.into()));
    }
    Some(Ok(with_bodies(scene, document, bodies)))
}

/// The scene of another, checked document, with the mesh files of a loaded scene.
fn with_bodies(scene: &Scene, document: &SceneDocument, bodies: Vec<SceneBody>) -> Scene {
    Scene {
        content_hash: content_hash(document, &scene.mesh_files),
        document: document.clone(),
        choice: scene.choice.clone(),
        bodies,
        warnings: scene.warnings.clone(),
        mesh_files: scene.mesh_files.clone(),
        kept_files: scene.kept_files.clone(),
    }
}

/// Everything that a valid document is loaded into.
struct Parts {
    bodies: Vec<SceneBody>,
    summaries: Vec<BodySummary>,
    /// The document's integrator, or the one chosen in its place.
    integrator: IntegratorDocument,
    choice: Option<IntegratorChoice>,
    estimate: Estimate,
    content_hash: String,
    mesh_files: BTreeMap<String, [u8; 32]>,
    kept_files: KeptFiles,
}

/// Checks the document, makes the meshes and checks them. Returns the parts if all bodies could be made and the document is
/// `whole`, that is without placeholders.
fn examine(
    document: &SceneDocument,
    whole: bool,
    source: &dyn MeshSource,
    budget: &Budget,
) -> (Findings, Option<Parts>) {
    let _span = tracing::debug_span!("load").entered();
    let mut out = check_document(document, budget);
    let mut builder = Builder::new(document, source, budget);
    let meshes = make_meshes(document, &mut builder);
    let mut made: Vec<Option<(SceneBody, BodySummary)>> = Vec::new();
    for (i, (mesh, found)) in meshes.into_iter().enumerate() {
        out.0.extend(found.0.into_vec());
        made.push(match &document.bodies[i].rigid {
            Some(rigid) => make_rigid(i, (&document.bodies[i], rigid), &mut builder, &mut out),
            None => make_body(i, document, mesh, &mut out),
        });
    }
    let Some(made) = made.into_iter().collect::<Option<Vec<_>>>() else { return (out, None) };
    // What follows computes with these numbers, so they must be valid.
    if !whole || out.0.has_errors() {
        return (out, None);
    }
    // Checks of the whole scene.
    let (bodies, summaries): (Vec<_>, Vec<_>) = made.into_iter().unzip();
    overlap::check(document, &bodies, &mut out);
    approach::check(document, &bodies, &mut out);
    side::check(document, &bodies, &mut out);
    let edges = summaries.iter().filter_map(|body| body.quality.as_ref()).map(|quality| quality.min_edge_m);
    let chosen = integrator_choice::choose(document, &bodies, edges.fold(f64::INFINITY, f64::min), budget);
    let (integrator, choice) =
        chosen.map_or_else(|| (document.integrator.clone(), None), |(i, c)| (i, Some(c)));
    let estimate = estimate::check(document, &integrator, &bodies, budget, &mut out);
    let content_hash = content_hash(document, &builder.file_hashes);
    let (mesh_files, kept_files) = (builder.file_hashes, KeptFiles::new(builder.kept_files));
    let parts =
        Parts { bodies, summaries, integrator, choice, estimate, content_hash, mesh_files, kept_files };
    (out, Some(parts))
}

/// The meshes of all bodies, placed and locally refined, with the problems found; none for rigid bodies.
fn make_meshes(document: &SceneDocument, builder: &mut Builder) -> Vec<(Option<Refined>, Findings)> {
    let mut found: Vec<Findings> = document.bodies.iter().map(|_| Findings::default()).collect();
    let bodies = (0..).zip(&document.bodies).zip(&mut found);
    let mut placed: Vec<Option<Mesh>> = bodies
        .map(|((i, body), out)| body.rigid.is_none().then(|| builder.body_mesh(i, body, out)).flatten())
        .collect();
    // Refinement around the impact needs all bodies in place.
    let asks = |i: usize| !document.bodies[i].refinement.is_empty();
    let mut fine: Vec<Option<Refined>> = (0..placed.len())
        .map(|i| asks(i).then(|| builder.refined((document, &placed), i, &mut found[i])).flatten())
        .collect();
    let take = |(i, out)| {
        let whole = |mesh| Refined { mesh, refined: None };
        let mesh: Option<Refined> = if asks(i) { fine[i].take() } else { placed[i].take().map(whole) };
        (mesh, out)
    };
    found.into_iter().enumerate().map(take).collect()
}

fn make_rigid(
    index: usize,
    (body, rigid): (&BodyDocument, &RigidDocument),
    builder: &mut Builder,
    out: &mut Findings,
) -> Option<(SceneBody, BodySummary)> {
    let made = builder.rigid_body(index, (body, rigid), out)?;
    let summary = BodySummary::rigid(body, &made);
    Some((SceneBody { rigid: Some(made), ..SceneBody::default() }, summary))
}

fn make_body(
    index: usize,
    document: &SceneDocument,
    mesh: Option<Refined>,
    out: &mut Findings,
) -> Option<(SceneBody, BodySummary)> {
    let body = &document.bodies[index];
    let Refined { mut mesh, refined } = mesh?;
    meshes::add_sets(index, body, &mut mesh, out);
    meshes::check_sets(index, body, &mesh, &document.measures, out);
    loads::check_mesh(index, body, &mesh, out);
    segmentation::check_mesh_of_file(index, document, &mesh, out);
    meshes::check_deformation(index, body, &mesh, out);
    let quality = meshes::check_elements(index, &mesh, out);
    let part_entry = meshes::part_entries(index, body, &mesh, out)?;
    bodies::check_memories(index, body, &mesh, &part_entry, out);
    let axes = body_axes(index, body, &mesh, &part_entry, out);
    let laws = laws(index, body, &mesh, &part_entry, out);
    // The body has what they say.
    (mesh.fields, mesh.axes) = (ElementFields::default(), Vec::new());
    let (axes, Laws { materials, law_of }) = (axes?, laws?);
    let summary = BodySummary::new(body, &mesh, &part_entry, &quality?);
    let made = SceneBody { mesh, refined, materials, law_of, part_entry, axes, ..SceneBody::default() };
    elements::check(index, document, &made, out);
    Some((made, summary))
}

/// SHA-256 of the document (as written by its types, so that spelling does not matter) and of the mesh files.
fn content_hash(document: &SceneDocument, file_hashes: &BTreeMap<String, [u8; 32]>) -> String {
    let mut hash = Sha256::new();
    // A document that was read can be written; if not, the hash would be that of the meshes alone.
    hash.update(serde_json::to_vec(document).unwrap_or_default());
    for (name, of_file) in file_hashes {
        hash.update((name.len() as u64).to_le_bytes());
        hash.update(name);
        hash.update(of_file);
    }
    hexadecimal(&hash.finalize())
}
