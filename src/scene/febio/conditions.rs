//! Boundary conditions, loads and initial velocities of FEBio files.

use super::deck::Deck;
use super::item::Item;
use super::node::{elements, numbers};
use crate::mesh::read::febio::Origin;
use crate::mesh::surface::{boundary, faces_within};
use crate::scene::document::{Axis, FaceLoadDocument, FixedDocument, PrescribedDocument, RampDocument};
use roxmltree::Node;

pub(super) const AXES: [(&str, Axis); 3] = [("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)];

/// A node set that a condition names.
pub(super) struct Set {
    /// Its name in the mesh.
    pub(super) name: String,
    pub(super) nodes: Vec<u32>,
}

impl<'x> Deck<'x> {
    /// The set that an attribute names, of this origin unless it says another (`@surface:top`).
    pub(super) fn set(&mut self, node: Node<'x, 'x>, attribute: &str, origin: Origin) -> Option<Set> {
        let named = node.attribute(attribute).unwrap_or_default();
        let (origin, own) = match named.split_once(':') {
            Some(("@surface", own)) => (Origin::Surface, own),
            Some(("@edge", own)) => (Origin::Edge, own),
            Some(("@elem_set", own)) => (Origin::Elements, own),
            _ => (origin, named),
        };
        let name = self.sets.get(&(origin, own.to_owned())).cloned();
        let found = name.and_then(|name| Some((self.mesh.node_sets.get(&name)?.clone(), name)));
        let Some((nodes, name)) = found else {
            let remedy = "name one in the mesh; those of shells and lines alone are not read";
            self.refuse(node, format!("no {attribute} {named:?} with nodes of volume elements"), remedy);
            return None;
        };
        Some(Set { name, nodes })
    }

    /// A boundary condition.
    pub(super) fn boundary_condition(&mut self, node: Node<'x, 'x>) {
        let mut item = Item::new(node);
        let kind = node.attribute("type");
        match (node.tag_name().name(), kind) {
            ("bc", Some("zero displacement")) => {
                let axes = [("x_dof", Axis::X), ("y_dof", Axis::Y), ("z_dof", Axis::Z)];
                let axes = axes
                    .into_iter()
                    .filter(|(name, _)| item.flag(name))
                    .map(|(_, axis)| axis)
                    .collect::<Vec<_>>();
                self.fixed(item, &axes);
            }
            ("bc", Some("fix")) | ("fix", None) => {
                let dofs = if kind.is_some() { item.text("dofs") } else { node.attribute("bc") };
                if let Some(axes) = self.axes(node, dofs.unwrap_or_default()) {
                    self.fixed(item, &axes);
                }
            }
            ("bc", Some("prescribed displacement" | "prescribe")) | ("prescribe", None) => {
                let dof = if kind.is_some() { item.text("dof") } else { node.attribute("bc") };
                if let Some(axes) = self.axes(node, dof.unwrap_or_default()) {
                    self.prescribed(item, &axes);
                }
            }
            ("bc", Some("rigid")) | ("rigid", None) => self.attached_to_rigid(item),
            ("rigid_body", None) => self.rigid_body(node),
            _ => self.unknown(node),
        }
    }

    /// The axes of displacements `x,y,z`; `None` for other degrees of freedom, which are refused.
    fn axes(&mut self, node: Node<'x, 'x>, dofs: &str) -> Option<Vec<Axis>> {
        let axis = |dof: &str| AXES.iter().find(|(name, _)| *name == dof.trim()).map(|(_, axis)| *axis);
        let axes: Option<Vec<Axis>> = dofs.split(',').map(axis).collect();
        if axes.is_none() {
            self.refuse(node, format!("the degree of freedom {dofs:?}"), "only x, y, z have counterparts");
        }
        axes
    }

    fn fixed(&mut self, item: Item<'x>, axes: &[Axis]) {
        let set = self.set(item.node, "node_set", Origin::Nodes);
        item.finish(&[], self);
        let Some(set) = set.filter(|_| !axes.is_empty()) else { return };
        for body in self.bodies.iter_mut().filter(|body| body.has_any(&set.nodes)) {
            body.fixed.push(FixedDocument { set: set.name.clone(), axes: axes.to_vec() });
        }
    }

    fn prescribed(&mut self, mut item: Item<'x>, axes: &[Axis]) {
        let set = self.set(item.node, "node_set", Origin::Nodes);
        if item.flag("relative") {
            self.refuse(
                item.node,
                "a displacement relative to that at the start of its step",
                "set <relative> to 0",
            );
        }
        let value = item.take("value").or_else(|| item.take("scale"));
        let load = self.load(item.node, value);
        item.finish(&[], self);
        let (Some(set), Some((value, ramp))) = (set, load) else { return };
        let mut displacement_m = [0.0; 3];
        for &axis in axes {
            displacement_m[axis as usize] = value * self.units.length;
        }
        for body in self.bodies.iter_mut().filter(|body| body.has_any(&set.nodes)) {
            let ramp = Some(ramp.clone());
            body.prescribed.push(PrescribedDocument {
                set: set.name.clone(),
                displacement_m,
                axes: axes.to_vec(),
                ramp,
            });
        }
    }

    /// The value of a load, 1 where it has none, and its load curve.
    pub(super) fn load(
        &mut self,
        node: Node<'x, 'x>,
        value: Option<Node<'x, 'x>>,
    ) -> Option<(f64, RampDocument)> {
        let Some(value) = value else {
            self.refuse(node, "no value", "give it one in FEBio Studio");
            return None;
        };
        let ramp = self.ramp(value)?;
        Some((self.constant(value)?, ramp))
    }

    /// A load of a surface.
    pub(super) fn surface_load(&mut self, node: Node<'x, 'x>) {
        let mut item = Item::new(node);
        let kind = node.attribute("type").unwrap_or_default();
        // FEBio's pressure follows the surface, unless it is linear; its traction is one per deformed area, unless it is.
        let (parameter, follows) = match kind {
            "pressure" => ("pressure", true),
            "traction" => ("traction", false),
            _ => return self.unknown(node),
        };
        let [is_linear, is_of_shell] = ["linear", "shell_bottom"].map(|name| item.flag(name));
        if is_linear == follows || is_of_shell {
            let what = if follows {
                "a pressure that does not follow its surface"
            } else {
                "a traction per deformed area"
            };
            self.refuse(
                node,
                what,
                if follows { "set <linear> to 0" } else { "set <linear> to 1: per area at rest" },
            );
        }
        let (value, scale) = (item.take(parameter), item.take("scale"));
        item.finish(&["symmetric_stiffness"], self);
        let Some(set) = self.surface(node) else { return };
        let load = if follows {
            self.load(node, value).map(|(pressure, ramp)| FaceLoadDocument::Pressure {
                set: set.name.clone(),
                pressure_pa: pressure * self.units.stress,
                ramp: Some(ramp),
            })
        } else {
            self.traction(node, value, scale).map(|(traction_pa, ramp)| FaceLoadDocument::Traction {
                set: set.name.clone(),
                traction_pa,
                ramp: Some(ramp),
            })
        };
        let Some(load) = load else { return };
        for body in self.bodies.iter_mut().filter(|body| body.has_any(&set.nodes)) {
            body.face_loads.push(load.clone());
        }
    }

    /// A traction [Pa] with its load curve.
    fn traction(
        &mut self,
        node: Node<'x, 'x>,
        value: Option<Node<'x, 'x>>,
        scale: Option<Node<'x, 'x>>,
    ) -> Option<([f64; 3], RampDocument)> {
        let (factor, ramp) = match scale {
            Some(scale) => self.load(node, Some(scale))?,
            None => (1.0, self.ramp(value?)?),
        };
        let stress = self.units.stress;
        let vector = value
            .and_then(|value| self.constants(value))
            .and_then(|vector| <[f64; 3]>::try_from(vector).ok());
        if vector.is_none() {
            self.refuse(node, "no traction of three numbers", "give it one in FEBio Studio");
        }
        Some((vector?.map(|t| t * factor * stress), ramp))
    }

    /// The set of a surface, if no other face has all its corners in it: a scene loads the faces of a set.
    fn surface(&mut self, node: Node<'x, 'x>) -> Option<Set> {
        let set = self.set(node, "surface", Origin::Surface)?;
        let own = node.attribute("surface").unwrap_or_default();
        let sections = elements(self.mesh_section);
        let surface =
            sections.filter(|s| s.has_tag_name("Surface")).find(|s| s.attribute("name") == Some(own));
        let facets = surface.map_or(0, |surface| elements(surface).count());
        let faces = faces_within(&boundary(&self.mesh.cells), &set.nodes).len();
        if facets != faces {
            let what = format!(
                "a surface of {facets} facets, in whose nodes {faces} boundary faces have all their corners"
            );
            self.refuse(node, what, "load a surface that ends at edges of the body, with all its faces");
            return None;
        }
        Some(set)
    }

    /// A body force: the opposite of an acceleration, as FEBio subtracts it.
    pub(super) fn body_load(&mut self, node: Node<'x, 'x>) {
        let mut item = Item::new(node);
        let components: Vec<Option<Node>> = match node.attribute("type") {
            Some("const" | "non-const") => AXES.map(|(name, _)| item.take(name)).to_vec(),
            Some("body force") => vec![item.take("force")],
            _ => return self.unknown(node),
        };
        item.finish(&[], self);
        if node.has_attribute("elem_set") || node.has_attribute("part") {
            return self.refuse(
                node,
                "a body force of some elements",
                "gravity acts on all bodies: remove elem_set",
            );
        }
        let (mut gravity, mut ramps) = ([0.0; 3], Vec::new());
        for (i, component) in components.iter().enumerate() {
            let Some(component) = *component else { continue };
            let (Some(values), Some(ramp)) = (self.constants(component), self.ramp(component)) else {
                return;
            };
            for (k, value) in values.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                let Some(component) = gravity.get_mut(i + k) else {
                    return self.refuse(node, "more than three numbers", "give it one for each axis");
                };
                *component = -value * self.units.length;
                ramps.push(ramp.clone());
            }
        }
        let Some(ramp) = ramps.first().cloned() else { return };
        if ramps.iter().any(|other| *other != ramp) {
            return self.refuse(
                node,
                "components with different load curves",
                "give all components one load curve",
            );
        }
        if self.gravity.is_some() {
            return self.refuse(node, "a second body force", "add both to one");
        }
        self.gravity = Some((gravity, ramp));
    }

    /// An initial velocity, of whole bodies.
    pub(super) fn initial_condition(&mut self, node: Node<'x, 'x>) {
        let mut item = Item::new(node);
        if node.attribute("type") != Some("velocity") {
            return self.unknown(node);
        }
        let vector =
            item.text("value").and_then(numbers).and_then(|vector| <[f64; 3]>::try_from(vector).ok());
        item.finish(&[], self);
        let Some(vector) = vector else {
            return self.refuse(node, "no <value> of three numbers", "give it one in FEBio Studio");
        };
        let Some(set) = self.set(node, "node_set", Origin::Nodes) else { return };
        if self.bodies.iter().any(|body| body.has_any(&set.nodes) && !body.is_within(&set.nodes)) {
            let remedy = "give it to all nodes of the body, parts that share nodes included";
            return self.refuse(node, "an initial velocity of a part of a body", remedy);
        }
        let length = self.units.length;
        for body in self.bodies.iter_mut().filter(|body| body.has_any(&set.nodes)) {
            body.velocity = Some(vector.map(|v| v * length));
        }
    }
}
