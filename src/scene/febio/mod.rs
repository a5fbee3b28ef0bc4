//! A first scene of a FEBio file, with its materials, conditions, loads and contact. Everything that a scene has no counterpart of
//! is a problem, with its line: nothing is omitted without notice but output and parameters of FEBio's solvers.

mod axes;
mod conditions;
mod contact;
mod curves;
mod deck;
mod item;
mod materials;
mod node;
mod rigid;
mod rigid_body;
mod units;

#[cfg(test)]
mod tests;

pub use units::UnitSystem;

use self::curves::curves;
use self::deck::{Body, Deck};
use self::item::Item;
use self::node::{elements, text, title};
use super::document::PartDocument;
use super::file_problem::{mesh_problem, source_problem};
use super::first_scene::first_scene;
use super::problem::{Pointer, Problem, ProblemList, Problems};
use super::source::MeshSource;
use crate::mesh::read::febio::{Found, is_axes, materials, materials_of_parts, mesh_section, read_xml};
use crate::mesh::read::xml::Xml;
use crate::mesh::{Mesh, MeshError};
use roxmltree::Node;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Sections without effect on the physical problem, or that others refer to.
const REFERRED: [&str; 8] =
    ["Module", "Globals", "Output", "LoadData", "Mesh", "Geometry", "Material", "MeshDomains"];

/// Sections without a counterpart, which say nothing where they are empty.
const OFTEN_EMPTY: [&str; 2] = ["Constraints", "Discrete"];

/// Code of the problem of a file that does not name its units.
pub const NO_UNITS: &str = "febio_without_units";

/// The mesh of a FEBio file of a source, of at most `limit` bytes, and a scene of it, or what of the file has no counterpart in a scene.
/// `units` are those of the file's numbers; it or the file has to name them.
///
/// # Errors
/// Why it cannot be read, or has no mesh.
pub fn read_febio(
    source: &dyn MeshSource,
    (name, limit): (&str, u64),
    units: Option<UnitSystem>,
) -> Result<(Mesh, Result<Value, Problems>), Problem> {
    let here = Pointer::root();
    let found = source.read(name, limit).map_err(|error| source_problem(&error, &here).value(name))?;
    scene_of_febio(&found.bytes, name, units).map_err(|error| mesh_problem(&error, &here).value(name))
}

/// Mesh and scene of a FEBio file, from its bytes.
///
/// # Errors
/// Why it cannot be read, or has no mesh.
pub fn scene_of_febio(
    bytes: &[u8],
    file_name: &str,
    units: Option<UnitSystem>,
) -> Result<(Mesh, Result<Value, Problems>), MeshError> {
    let text = String::from_utf8_lossy(bytes);
    let xml = Xml::new(&text)?;
    let Found { mesh, sets, has_axes } = read_xml(&xml)?;
    let mut scene = first_scene(&mesh, file_name);
    let mut deck = Deck {
        xml: &xml,
        mesh: &mesh,
        mesh_section: mesh_section(&xml)?,
        sets: &sets,
        has_axes: &has_axes,
        materials: materials(xml.root()),
        rigid: BTreeMap::new(),
        units: UnitSystem::Si.units(),
        curves: curves(xml.root()),
        end_time: None,
        bodies: bodies(&scene, &mesh),
        pairs: Vec::new(),
        gravity: None,
        integrator: None,
        problems: ProblemList::default(),
    };
    deck.module(units);
    deck.sections(xml.root());
    let parts = deck.parts();
    deck.rigid_bodies();
    if deck.problems.is_empty() {
        deck.write(&mut scene, &parts);
        deck.roles(&mut scene);
        return Ok((mesh, Ok(scene)));
    }
    let problems = Problems(deck.problems.into_vec());
    Ok((mesh, Err(problems)))
}

/// The bodies of a first scene.
fn bodies(scene: &Value, mesh: &Mesh) -> Vec<Body> {
    let strings = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let body = |body: &Value| {
        let own = body["parts"].as_array().into_iter().flatten();
        let parts: Vec<String> = own.map(|part| strings(&part["part"])).collect();
        let mut has = vec![false; mesh.nodes.len()];
        for (element, cell) in mesh.cells.iter().enumerate() {
            if parts.contains(&mesh.parts[mesh.part_of[element] as usize]) {
                cell.nodes.iter().for_each(|&node| has[node as usize] = true);
            }
        }
        Body {
            name: strings(&body["name"]),
            parts,
            has,
            fixed: Vec::new(),
            prescribed: Vec::new(),
            face_loads: Vec::new(),
            velocity: None,
        }
    };
    scene["bodies"].as_array().into_iter().flatten().map(body).collect()
}

impl<'x> Deck<'x> {
    /// The kind of problem, and the units.
    fn module(&mut self, asked: Option<UnitSystem>) {
        let root = self.xml.root();
        let module = elements(root).find(|node| node.has_tag_name("Module"));
        let kind = module.and_then(|node| node.attribute("type")).unwrap_or("solid");
        let place = module.unwrap_or(root);
        if kind != "solid" {
            self.refuse(
                place,
                "a problem with other physics",
                "only those of type \"solid\" have a counterpart",
            );
        }
        let named = module.and_then(|node| elements(node).find(|child| child.has_tag_name("units")));
        let own = named.map(|node| text(node).parse::<UnitSystem>());
        match (own, asked) {
            (Some(Err(limit)), _) => self.refuse(place, limit, "correct <units>"),
            (Some(Ok(own)), Some(asked)) if own != asked => {
                self.refuse(place, "units other than those of --units", "omit --units, or correct <units>");
            }
            (Some(Ok(system)), _) | (None, Some(system)) => self.units = system.units(),
            (None, None) => {
                let line = self.xml.place(place.range().start);
                let message = format!(
                    "{line}: {} has no <units>, and FEBio's numbers have none of their own",
                    title(place)
                );
                let remedy = format!("give those of the file with --units: {}", UnitSystem::names());
                self.problems.push(Problem::error(NO_UNITS, &Pointer::root(), message).remedy(remedy));
            }
        }
    }

    /// What the sections of a file, or of a step, say.
    fn sections(&mut self, parent: Node<'x, 'x>) {
        // The end of the run first, which load curves have to reach.
        for control in elements(parent).filter(|section| section.has_tag_name("Control")) {
            self.control(control);
        }
        for section in elements(parent) {
            let name = section.tag_name().name();
            match name {
                "Control" => {}
                _ if REFERRED.contains(&name) => {}
                "Step" => self.step(section),
                "Boundary" => elements(section).for_each(|node| self.boundary_condition(node)),
                "Contact" => elements(section).for_each(|node| self.contact(node)),
                "Rigid" => elements(section).for_each(|node| self.rigid_condition(node)),
                "MeshData" => {
                    elements(section).filter(|node| !is_axes(*node)).for_each(|node| self.unknown(node));
                }
                "Initial" => elements(section).for_each(|node| self.initial_condition(node)),
                "Loads" => {
                    for node in elements(section) {
                        match node.tag_name().name() {
                            "surface_load" => self.surface_load(node),
                            "body_load" => self.body_load(node),
                            _ => self.unknown(node),
                        }
                    }
                }
                _ if OFTEN_EMPTY.contains(&name) => elements(section).for_each(|node| self.unknown(node)),
                _ => self.unknown(section),
            }
        }
    }

    /// The one step of a file.
    fn step(&mut self, section: Node<'x, 'x>) {
        let steps: Vec<Node> = elements(section).filter(|node| node.has_tag_name("step")).collect();
        let is_alone = elements(self.xml.root()).filter(|node| node.has_tag_name("Step")).count() == 1;
        match steps[..] {
            [] if is_alone => self.sections(section),
            [step] if is_alone => self.sections(step),
            _ => self.refuse(section, "several steps", "a scene has one: remove the others"),
        }
    }

    /// Times, and whether inertia counts.
    fn control(&mut self, node: Node<'x, 'x>) {
        let mut item = Item::new(node);
        let (steps, size) = (item.required("time_steps", self), item.required("step_size", self));
        let (Some(steps), Some(step_s)) = (steps, size) else { return };
        self.end_time = Some(steps * step_s);
        let named = item.take("analysis");
        let kind = named.map_or("static", |node| node.attribute("type").unwrap_or_else(|| text(node)));
        self.integrator = match kind.to_ascii_lowercase().as_str() {
            "static" | "0" => Some(json!({"kind": "quasi_static", "step_s": step_s})),
            "dynamic" | "1" => Some(json!({"kind": "auto"})),
            other => return self.refuse(node, format!("the analysis {other:?}"), "choose STATIC or DYNAMIC"),
        };
    }

    /// The material of each part.
    fn parts(&mut self) -> BTreeMap<String, PartDocument> {
        let root = self.xml.root();
        let section = |name: &'static str| {
            elements(root).filter(move |node| node.has_tag_name(name)).flat_map(elements)
        };
        for domain in section("MeshDomains") {
            let kind = domain.attribute("type").unwrap_or("elastic-solid");
            let is_solid = ["elastic-solid", "three-field-solid", "ut4-solid", "rigid-solid"].contains(&kind);
            let is_assigned = domain.has_attribute("name") && domain.has_attribute("mat");
            if !(domain.has_tag_name("SolidDomain") && is_solid && is_assigned) {
                self.unknown(domain);
            }
        }
        let assigned = materials_of_parts(root, self.mesh_section);
        let mut found = BTreeMap::new();
        let mesh = self.mesh;
        for part in &mesh.parts {
            let material = assigned.get(part.as_str()).and_then(|named| self.materials.get(named));
            if let Some(node) = material.copied() {
                found.extend(self.material(node, part).map(|document| (part.clone(), document)));
            } else {
                let what = format!("no material for the part {part:?}");
                self.refuse(self.mesh_section, what, "assign it one in FEBio Studio");
            }
        }
        found
    }

    /// Writes what was found into the first scene.
    fn write(&self, scene: &mut Value, parts: &BTreeMap<String, PartDocument>) {
        scene["description"] = json!("From a FEBio file: roles are guessed.");
        scene["end_time_s"] = json!(self.end_time);
        scene["contact"] = json!({"pairs": self.pairs});
        if self.pairs.iter().all(|pair| pair.between[0] != pair.between[1]) {
            scene["contact"]["self_contact"] = json!("none");
        }
        if let Some((acceleration, ramp)) = &self.gravity {
            scene["gravity_m_per_s2"] = json!(acceleration);
            scene["gravity_ramp"] = json!(ramp);
        }
        if let Some(integrator) = &self.integrator {
            scene["integrator"] = integrator.clone();
            let relaxes = parts.values().any(|part| part.prony_series.is_some());
            if integrator["kind"] == "quasi_static" && relaxes {
                scene["integrator"]["real_time"] = json!(true);
            }
        }
        for (index, body) in self.bodies.iter().enumerate() {
            let document = &mut scene["bodies"][index];
            let own: Vec<&PartDocument> = body.parts.iter().filter_map(|part| parts.get(part)).collect();
            document["parts"] = json!(own);
            document["placement"] = json!({"scale": self.units.length});
            if let Some(members) = document.as_object_mut() {
                members.remove("fixed");
                members.remove("velocity_m_per_s");
            }
            for (key, value, is_there) in [
                ("fixed", json!(body.fixed), !body.fixed.is_empty()),
                ("prescribed", json!(body.prescribed), !body.prescribed.is_empty()),
                ("face_loads", json!(body.face_loads), !body.face_loads.is_empty()),
                ("velocity_m_per_s", json!(body.velocity), body.velocity.is_some()),
            ] {
                if is_there {
                    document[key] = value;
                }
            }
        }
    }
}
