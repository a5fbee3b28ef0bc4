//! Tissue squeezed against its base: how thin it becomes between what strikes it and where it is held or rests.
//!
//! Each node that is struck has a column of tissue below it, to the nearest face of its body that looks the other way. Its thickness is the
//! distance of the node from the plane of that face, so that neither shear nor a turn of the body changes it.

use crate::mechanics::contact::Contact;
use crate::mechanics::contact::detection::closest_point::Patch;
use crate::mechanics::tensor::Vec3;
use crate::plan::{Plan, PlanBody};
use crate::scene::document::Role;
use crate::step::Frame;
use std::collections::{BTreeMap, BTreeSet};

/// Cosine of the angle between the normals of a node and of a face below which they look in opposite directions [-].
const OPPOSITE: f64 = -0.5;
/// The shape functions in the middle of a face.
const MIDDLE: [f64; 4] = [0.25; 4];

/// The thinnest column so far, relative to its thickness at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Squeezed {
    /// Name of the body whose tissue it is.
    pub body: String,
    /// Name of the contact pair that squeezes it.
    pub pair: String,
    /// Whether its base is held; else it rests on another body or a plane.
    pub is_held: bool,
    /// Thickness at the start, and when it was thinnest [m].
    pub thickness: [f64; 2],
    /// Reference position of the struck node [m].
    pub place: Vec3,
    /// Time at which it was thinnest [s].
    pub time: f64,
}

impl Squeezed {
    /// Part of the thickness that was lost [-].
    pub fn lost(&self) -> f64 {
        1.0 - self.thickness[1] / self.thickness[0]
    }
}

/// Thickness of the tissue below the nodes that are struck, at the look times. Bodies with eroded elements are omitted.
#[derive(Clone, Debug, Default)]
pub struct Squeeze {
    /// The column below each node that has been struck; `None` where no face looks the other way.
    columns: BTreeMap<u32, Option<Column>>,
    /// The faces of each body that has been struck, as it starts.
    faces: BTreeMap<usize, Vec<StartFace>>,
    /// The thinnest column so far; `None` before the first.
    pub worst: Option<Squeezed>,
}

/// The tissue below a node.
#[derive(Clone, Copy, Debug)]
struct Column {
    /// The face at its other end.
    face: [u32; 4],
    /// Distance of the node from that face at the start [m].
    thickness: f64,
}

/// The middle of a boundary face at the start [m], and its outward normal there.
#[derive(Clone, Copy, Debug)]
struct StartFace {
    middle: Vec3,
    normal: Vec3,
}

impl Squeeze {
    /// Accumulates a look time, given the numbers of the pairs in which the tissue is struck.
    pub fn accumulate(&mut self, frame: &Frame, strikes: &[usize]) {
        if strikes.is_empty() {
            return;
        }
        let pressed: BTreeSet<u32> =
            pressed_contacts(frame).flat_map(|contact| contact.stencil.nodes().iter().copied()).collect();
        for contact in pressed_contacts(frame).filter(|contact| strikes.contains(&(contact.pair as usize))) {
            for &node in contact.stencil.nodes() {
                if let Some(found) = self.look_below(node, contact, frame, &pressed)
                    && self.worst.as_ref().is_none_or(|worst| found.lost() > worst.lost())
                {
                    self.worst = Some(found);
                }
            }
        }
    }

    /// The column below a node of a contact, if it is tissue with a base: without one it can give way. `pressed`: nodes of all contacts that
    /// press.
    fn look_below(
        &mut self,
        node: u32,
        contact: &Contact,
        frame: &Frame,
        pressed: &BTreeSet<u32>,
    ) -> Option<Squeezed> {
        let plan = frame.plan;
        let index = plan.body_of_node(node);
        let body = &plan.bodies[index];
        let is_torn = || frame.erosion.elements().iter().any(|element| body.elements.contains(element));
        if body.role != Role::Tissue || body.rigid.is_some() || is_torn() {
            return None;
        }
        let Self { columns, faces, .. } = self;
        let column = columns.entry(node).or_insert_with(|| {
            let faces = faces.entry(index).or_insert_with(|| faces_at_start(body, plan));
            Column::below(node, body, plan, faces)
        });
        let Column { face, thickness } = (*column)?;
        let is_held = face.iter().all(|node| (0..3).any(|axis| plan.holds(*node as usize, axis)));
        if !is_held && !face.iter().any(|node| pressed.contains(node)) {
            return None;
        }
        let place = |node: u32| frame.position_in(index, node);
        Some(Squeezed {
            body: body.name.clone(),
            pair: plan.name_of(contact.pair as usize),
            is_held,
            thickness: [thickness, distance(&place(node), &face, place)],
            place: plan.X[node as usize],
            time: frame.time,
        })
    }
}

impl Column {
    /// The column below a node of a body as it starts, given its faces then: to the nearest middle of a face that looks the other way,
    /// inwards.
    fn below(node: u32, body: &PlanBody, plan: &Plan, faces: &[StartFace]) -> Option<Self> {
        let start = |node: u32| plan.start_of(node);
        let around = body.boundary.faces.iter().filter(|face| face.contains(&node));
        let normals = around.map(|face| patch(face, start)).map(|face| face.normal(&MIDDLE) * face.area());
        let normal = normals.sum::<Vec3>().try_normalize(0.0)?;
        let from = start(node);
        let mut nearest: Option<(f64, &[u32; 4])> = None;
        for (face, other) in body.boundary.faces.iter().zip(faces) {
            let way = other.middle - from;
            let square = way.norm_squared();
            let is_nearer = nearest.is_none_or(|(least, _)| square < least);
            if is_nearer && way.dot(&normal) < 0.0 && other.normal.dot(&normal) < OPPOSITE {
                nearest = Some((square, face));
            }
        }
        let (_, face) = nearest?;
        let thickness = distance(&from, face, start);
        (thickness > 0.0).then_some(Self { face: *face, thickness })
    }
}

/// The boundary faces of a body as it starts, in their order.
fn faces_at_start(body: &PlanBody, plan: &Plan) -> Vec<StartFace> {
    let of = |face: &[u32; 4]| {
        let face = patch(face, |node| plan.start_of(node));
        StartFace { middle: face.point(&MIDDLE), normal: face.normal(&MIDDLE) }
    };
    body.boundary.faces.iter().map(of).collect()
}

/// The contacts of a frame that press.
fn pressed_contacts<'a>(frame: &Frame<'a>) -> impl Iterator<Item = &'a Contact> + use<'a> {
    let all = frame.contacts.iter().zip(frame.reactions);
    all.filter(|(_, reaction)| reaction.impulse[0] > 0.0).map(|(contact, _)| contact)
}

/// A face with its corners where they are [m].
fn patch(face: &[u32; 4], place: impl Fn(u32) -> Vec3) -> Patch {
    Patch { corners: face.map(place), triangle: face[2] == face[3] }
}

/// Distance of a point inwards of the plane of a face, negative beyond it [m].
fn distance(point: &Vec3, face: &[u32; 4], place: impl Fn(u32) -> Vec3) -> f64 {
    let face = patch(face, place);
    face.normal(&MIDDLE).dot(&(face.point(&MIDDLE) - point))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::plan::compile;
    use crate::scene::{Budget, NoFiles, load};
    use serde_json::json;

    /// A rigid ball at 5 m/s on a layer of gel, 20 mm thick and held at its bottom.
    fn plan() -> Plan {
        let scene = json!({
            "name": "layer", "end_time_s": 6e-3,
            "bodies": [
                {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -5],
                 "rigid": {"shape": {"kind": "ball", "radius_m": 0.02}, "center_m": [0, 0, 0.0201], "mass_kg": 0.02}},
                {"name": "gel", "role": "tissue", "fixed": [{"set": "z_min"}],
                 "mesh": {"generator": {"kind": "block", "min_m": [-0.03, -0.03, -0.02], "max_m": [0.03, 0.03, 0], "elements": [8, 8, 4]}},
                 "parts": [{"part": "*", "density_kg_per_m3": 1000, "material":
                    {"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 2e6}}]}
            ],
            "contact": {"pairs": [{"between": ["gel", "ball"]}]}
        });
        let loaded = load(&serde_json::to_vec(&scene).unwrap(), &NoFiles, &Budget::COMMAND_LINE).unwrap();
        compile(&loaded.scene).unwrap()
    }

    #[test]
    fn the_column_below_a_node_ends_at_the_other_side() {
        let plan = plan();
        let body = plan.bodies.iter().find(|body| body.role == Role::Tissue).unwrap();
        for &node in &body.boundary.nodes {
            let x = plan.X[node as usize];
            let is_inside = |c: f64| c.abs() < 0.029;
            if x.z > -1e-9 && is_inside(x.x) && is_inside(x.y) {
                let column = Column::below(node, body, &plan, &faces_at_start(body, &plan)).unwrap();
                assert!((column.thickness - 0.02).abs() < 1e-12, "{x:?}: {column:?}");
                assert!(column.face.iter().all(|corner| plan.X[*corner as usize].z < -0.0199));
            }
        }
    }
}
