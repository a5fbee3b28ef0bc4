//! A FEBio file on its way to a scene: what was found, and the problems.

use super::curves::{Curve, Curves};
use super::node::{elements, numbers, text, title};
use super::rigid_body::RigidBody;
use super::units::Units;
use crate::mesh::Mesh;
use crate::mesh::read::febio::SetNames;
use crate::mesh::read::xml::Xml;
use crate::scene::document::{
    FaceLoadDocument, FixedDocument, PairDocument, PrescribedDocument, RampDocument,
};
use crate::scene::problem::{Pointer, Problem, ProblemList};
use roxmltree::Node;
use serde_json::Value;
use std::collections::BTreeMap;

/// A body of the scene, and what the file says of it.
pub(super) struct Body {
    pub name: String,
    pub parts: Vec<String>,
    /// Whether each node of the mesh belongs to it.
    pub has: Vec<bool>,
    pub fixed: Vec<FixedDocument>,
    pub prescribed: Vec<PrescribedDocument>,
    pub face_loads: Vec<FaceLoadDocument>,
    /// Initial velocity [m/s].
    pub velocity: Option<[f64; 3]>,
}

impl Body {
    pub(super) fn has_any(&self, nodes: &[u32]) -> bool {
        nodes.iter().any(|&node| self.has[node as usize])
    }

    /// Whether all its nodes are in a sorted set.
    pub(super) fn is_within(&self, nodes: &[u32]) -> bool {
        let count = nodes.iter().filter(|&&node| self.has[node as usize]).count();
        count == self.has.iter().filter(|has| **has).count()
    }
}

/// A file on its way to a scene.
pub(super) struct Deck<'x> {
    pub xml: &'x Xml<'x>,
    pub mesh: &'x Mesh,
    pub mesh_section: Node<'x, 'x>,
    pub sets: &'x SetNames,
    /// Whether each element has material axes of its own; empty where none has.
    pub has_axes: &'x [bool],
    /// Materials by name and number.
    pub materials: BTreeMap<&'x str, Node<'x, 'x>>,
    /// Rigid bodies by the byte offsets of their materials.
    pub rigid: BTreeMap<usize, RigidBody>,
    pub units: Units,
    pub curves: Curves,
    /// End of the run [s].
    pub end_time: Option<f64>,
    pub bodies: Vec<Body>,
    pub pairs: Vec<PairDocument>,
    /// Acceleration [m/s²] with its load curve.
    pub gravity: Option<([f64; 3], RampDocument)>,
    pub integrator: Option<Value>,
    pub problems: ProblemList,
}

impl Deck<'_> {
    /// A problem of an element.
    pub(super) fn refuse(&mut self, node: Node, what: impl AsRef<str>, remedy: &str) {
        self.refuse_as(node, format!("{}: {}", title(node), what.as_ref()), remedy);
    }

    /// A problem at an element.
    pub(super) fn refuse_as(&mut self, node: Node, what: impl AsRef<str>, remedy: &str) {
        let message = format!("{}: {}", self.xml.place(node.range().start), what.as_ref());
        // A material may belong to several parts.
        if self.problems.iter().all(|problem| problem.message != message) {
            let problem = Problem::error("febio_without_counterpart", &Pointer::root(), message);
            self.problems.push(problem.remedy(remedy));
        }
    }

    /// The load curve that a parameter names, constant where it names none; `None` where a scene has no such curve.
    pub(super) fn ramp(&mut self, parameter: Node) -> Option<RampDocument> {
        let Some(id) = parameter.attribute("lc") else { return Some(RampDocument::Constant {}) };
        let remedy = "give it a load curve with linear interpolation, with more points where it is curved, over the whole run";
        let fault = match self.curves.get(id) {
            None => format!("there is no load curve {id}"),
            Some(Err(fault)) => fault.clone(),
            Some(Ok(Curve { points, .. })) if points.len() == 1 => {
                return Some(RampDocument::Table { times_s: vec![0.0], factors: vec![points[0][1]] });
            }
            Some(Ok(curve)) => {
                let covers = self.end_time.is_none_or(|end| {
                    curve.points[0][0] <= 0.0 && curve.points.last().is_some_and(|last| last[0] >= end)
                });
                if curve.is_constant_beyond || covers {
                    let [times_s, factors] =
                        [0, 1].map(|i| curve.points.iter().map(|point| point[i]).collect());
                    return Some(RampDocument::Table { times_s, factors });
                }
                "a load curve that is repeated or extrapolated within the run".into()
            }
        };
        self.refuse(parameter, fault, remedy);
        None
    }

    /// Refuses what has no counterpart in a scene.
    pub(super) fn unknown(&mut self, node: Node) {
        let what = title(node);
        self.refuse_as(node, what, "has no counterpart in a scene: remove it in the file");
    }

    /// The one number of a parameter that is the same everywhere; `None` for others, which are refused.
    pub(super) fn constant<'y>(&mut self, parameter: Node<'y, 'y>) -> Option<f64> {
        let values = self.constants(parameter)?;
        if let [value] = values[..] {
            return Some(value);
        }
        self.refuse(parameter, format!("{} numbers for one", values.len()), "give one number");
        None
    }

    /// The numbers of a parameter that is the same everywhere; `None` for others, which are refused.
    pub(super) fn constants<'y>(&mut self, parameter: Node<'y, 'y>) -> Option<Vec<f64>> {
        let is_constant = parameter.attribute("type").is_none_or(|kind| ["const", "vector"].contains(&kind));
        let values = numbers(text(parameter)).filter(|_| is_constant && elements(parameter).next().is_none());
        if values.is_none() {
            self.refuse(parameter, "a parameter that is not a constant number", "give it a constant value");
        }
        values
    }
}
