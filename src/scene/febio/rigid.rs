//! Rigid bodies of FEBio files: parts whose nodes are fixed, or move together without turning. Their elements are kept for the sake of
//! their surfaces, with a law that has no effect, as they are never deformed.

use super::conditions::AXES;
use super::deck::Deck;
use super::item::Item;
use super::node::elements;
use super::rigid_body::{Motion, RigidBody};
use crate::mesh::read::febio::{Origin, RIGID, materials_of_parts};
use crate::scene::document::{MaterialDocument, VolumetricDocument};
use crate::scene::materials::NeoHookeanDocument;
use crate::scene::part_document::PartDocument;
use roxmltree::Node;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Degrees of freedom of a rigid body since version 3: translations, and rotations about the same axes.
const DEGREES: [[&str; 2]; 6] =
    [["Rx", "x"], ["Ry", "y"], ["Rz", "z"], ["Ru", "u"], ["Rv", "v"], ["Rw", "w"]];

/// The same in version 2.5.
const OLD_DEGREES: [&str; 6] = ["x", "y", "z", "Rx", "Ry", "Rz"];

/// Flags of the degrees of freedom that are fixed, since version 4.
const FLAGS: [&str; 6] = ["Rx_dof", "Ry_dof", "Rz_dof", "Ru_dof", "Rv_dof", "Rw_dof"];

/// Parameters of its material, none of which matters where it is held: mass, and stiffness for penalties.
const OF_THE_MATERIAL: [&str; 7] =
    ["density", "center_of_mass", "override_com", "override_moi", "moi", "E", "v"];

/// Constants of a law without effect: soft, so that it does not shorten explicit steps.
const C10_PA: f64 = 1e3;
const BULK_MODULUS_PA: f64 = 1e5;
const DENSITY: f64 = 1e3;

/// Remedy of a rigid body that is not held along all its degrees of freedom.
const HELD: &str = "fix all rotations, and fix or prescribe all displacements; one that moves freely has a shape in a scene and no mesh: remove \
    its elements from the file, and give the scene a body with a \"rigid\" shape in their place";

impl<'x> Deck<'x> {
    /// A part that is, or belongs to, a rigid body.
    pub(super) fn rigid_part(&mut self, node: Node<'x, 'x>, part: &str) -> PartDocument {
        Item::new(node).finish(&OF_THE_MATERIAL, self);
        let law = NeoHookeanDocument {
            c10_pa: C10_PA,
            bulk_modulus_pa: BULK_MODULUS_PA,
            volumetric: VolumetricDocument::LnSquared,
            valid_to: None,
        };
        PartDocument::new(part.to_owned(), DENSITY, MaterialDocument::NeoHookean(law))
    }

    /// A condition of a rigid body, since version 3.
    pub(super) fn rigid_condition(&mut self, node: Node<'x, 'x>) {
        let mut item = Item::new(node);
        match (node.tag_name().name(), node.attribute("type")) {
            ("rigid_bc", Some("rigid_fixed")) => {
                let rigid = self.named(&mut item);
                let fixed: Vec<usize> = (0..6).filter(|i| item.flag(FLAGS[*i])).collect();
                item.finish(&[], self);
                self.set_motions(node, rigid, &fixed, &Motion::Fixed);
            }
            ("rigid_constraint", Some("fix")) => {
                let rigid = self.named(&mut item);
                let dofs = item.text("dofs").unwrap_or_default();
                item.finish(&[], self);
                let fixed = self.degrees(node, dofs.split(','), |i, name| DEGREES[i].contains(&name));
                self.set_motions(node, rigid, &fixed, &Motion::Fixed);
            }
            ("rigid_bc", Some("rigid_displacement")) | ("rigid_constraint", Some("prescribe")) => {
                let rigid = self.named(&mut item);
                let dof = item.text("dof").unwrap_or_default();
                if item.flag("relative") {
                    let what = "a displacement relative to that at the start of its step";
                    self.refuse(node, what, "set <relative> to 0");
                }
                let value = item.take("value");
                item.finish(&[], self);
                let degrees = self.degrees(node, std::iter::once(dof), |i, name| DEGREES[i].contains(&name));
                self.prescribe(node, rigid, &degrees, value);
            }
            _ => self.unknown(node),
        }
    }

    /// The conditions of a rigid body in version 2.5.
    pub(super) fn rigid_body(&mut self, node: Node<'x, 'x>) {
        let rigid = self.rigid_of(node, node.attribute("mat").unwrap_or_default());
        for child in elements(node) {
            let dof = child.attribute("bc").unwrap_or_default();
            let name = child.tag_name().name();
            if !["fixed", "prescribed"].contains(&name) {
                self.unknown(child);
                continue;
            }
            let degrees = self.degrees(child, std::iter::once(dof), |i, name| OLD_DEGREES[i] == name);
            if name == "fixed" {
                self.set_motions(child, rigid, &degrees, &Motion::Fixed);
            } else {
                self.prescribe(child, rigid, &degrees, Some(child));
            }
        }
    }

    /// Nodes that move with a rigid body.
    pub(super) fn attached_to_rigid(&mut self, mut item: Item<'x>) {
        let node = item.node;
        let named = item.text("rb").or_else(|| node.attribute("rb")).unwrap_or_default();
        item.finish(&["clamp_shells"], self);
        let rigid = self.rigid_of(node, named);
        let set = self.set(node, "node_set", Origin::Nodes);
        if let (Some(rigid), Some(set)) = (rigid, set) {
            self.rigid.entry(rigid.range().start).or_default().sets.push(set.name);
        }
    }

    /// The rigid body that a condition names.
    fn named(&mut self, item: &mut Item<'x>) -> Option<Node<'x, 'x>> {
        let named = item.text("rb").unwrap_or_default();
        self.rigid_of(item.node, named)
    }

    /// The material of a rigid body of this name or number.
    fn rigid_of(&mut self, node: Node<'x, 'x>, named: &str) -> Option<Node<'x, 'x>> {
        let found = self.materials.get(named.trim()).copied();
        let found = found.filter(|material| material.attribute("type") == Some(RIGID));
        if found.is_none() {
            let remedy = "name a material of type \"rigid body\"";
            self.refuse(node, format!("there is no rigid body {named:?}"), remedy);
        }
        found
    }

    /// The degrees of freedom of these names.
    fn degrees<'n>(
        &mut self,
        node: Node<'x, 'x>,
        names: impl Iterator<Item = &'n str>,
        is_it: impl Fn(usize, &str) -> bool,
    ) -> Vec<usize> {
        let mut found = Vec::new();
        for name in names.map(str::trim) {
            if let Some(degree) = (0..6).find(|i| is_it(*i, name)) {
                found.push(degree);
            } else {
                let what = format!("the degree of freedom {name:?}");
                self.refuse(node, what, "choose one of a rigid body");
            }
        }
        found
    }

    /// A prescribed displacement along an axis.
    fn prescribe(
        &mut self,
        node: Node<'x, 'x>,
        rigid: Option<Node<'x, 'x>>,
        degrees: &[usize],
        value: Option<Node<'x, 'x>>,
    ) {
        let load = self.load(node, value);
        if degrees.iter().any(|degree| *degree >= AXES.len()) {
            let remedy = "nodes of a scene have prescribed displacements along axes: remove the rotation";
            return self.refuse(node, "a prescribed rotation of a rigid body", remedy);
        }
        if let Some((value, ramp)) = load {
            let motion = Motion::Prescribed(value * self.units.length, ramp);
            self.set_motions(node, rigid, degrees, &motion);
        }
    }

    fn set_motions(
        &mut self,
        node: Node<'x, 'x>,
        rigid: Option<Node<'x, 'x>>,
        degrees: &[usize],
        motion: &Motion,
    ) {
        let Some(rigid) = rigid else { return };
        let body = self.rigid.entry(rigid.range().start).or_default();
        let before: Vec<Option<Motion>> =
            degrees.iter().map(|degree| body.motions[*degree].replace(motion.clone())).collect();
        // To fix what is fixed is the same again.
        let is_new = |before: &Option<Motion>| match (before, motion) {
            (None, _) | (Some(Motion::Fixed), Motion::Fixed) => true,
            (Some(_), _) => false,
        };
        if !before.iter().all(is_new) {
            self.refuse(node, "a second motion of a rigid body along the same axis", "remove one of the two");
        }
    }

    /// Gives the nodes of rigid bodies their motions. Those that may turn, or are free along an axis, are refused.
    pub(super) fn rigid_bodies(&mut self) {
        let assigned = materials_of_parts(self.xml.root(), self.mesh_section);
        let mut bodies: BTreeMap<usize, (Node, RigidBody)> = BTreeMap::new();
        for material in self.materials.values() {
            if let Some(rigid) = self.rigid.get(&material.range().start) {
                bodies.insert(material.range().start, (*material, rigid.clone()));
            }
        }
        for part in &self.mesh.parts {
            let material = assigned.get(part.as_str()).and_then(|named| self.materials.get(named));
            let Some(material) = material.filter(|node| node.attribute("type") == Some(RIGID)) else {
                continue;
            };
            let (_, rigid) =
                bodies.entry(material.range().start).or_insert((*material, RigidBody::default()));
            rigid.sets.extend(self.sets.get(&(Origin::RigidBody, part.clone())).cloned());
        }
        for (material, rigid) in bodies.into_values() {
            let free = (0..6).filter(|i| rigid.motions[*i].is_none()).map(|i| DEGREES[i][0]);
            let free: Vec<&str> = free.collect();
            if !free.is_empty() {
                let free = free.join(", ");
                let what = format!("a rigid body that is free along {free} (Ru, Rv, Rw are rotations)");
                self.refuse(material, what, HELD);
                continue;
            }
            for set in &rigid.sets {
                let nodes = self.mesh.node_sets.get(set).map(Vec::as_slice).unwrap_or_default();
                for body in self.bodies.iter_mut().filter(|body| body.has_any(nodes)) {
                    body.fixed.extend(rigid.fixed(set));
                    body.prescribed.extend(rigid.prescribed(set));
                }
            }
        }
    }

    /// Roles where some bodies are rigid as a whole: the first of them that moves strikes the first of the others.
    pub(super) fn roles(&self, scene: &mut Value) {
        let assigned = materials_of_parts(self.xml.root(), self.mesh_section);
        let material = |part: &String| self.materials.get(assigned.get(part.as_str())?);
        let is_rigid =
            |part: &String| material(part).is_some_and(|node| node.attribute("type") == Some(RIGID));
        let rigid: Vec<bool> = self.bodies.iter().map(|body| body.parts.iter().all(is_rigid)).collect();
        if !rigid.contains(&true) {
            return;
        }
        let moving = (0..rigid.len()).find(|i| rigid[*i] && !self.bodies[*i].prescribed.is_empty());
        let is_tissue = |i: &usize| !rigid[*i] && scene["bodies"][*i]["role"] == "tissue";
        let tissue = (0..rigid.len()).find(is_tissue).or_else(|| rigid.iter().position(|rigid| !rigid));
        for i in 0..rigid.len() {
            let own = scene["bodies"][i]["role"].clone();
            scene["bodies"][i]["role"] = match i {
                _ if Some(i) == tissue => json!("tissue"),
                _ if Some(i) == moving => json!("projectile"),
                _ if rigid[i] || moving.is_some() => json!("other"),
                _ => own,
            };
        }
    }
}
