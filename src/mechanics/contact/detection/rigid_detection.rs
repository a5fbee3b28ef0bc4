//! Contact detection for rigid bodies: against meshes, planes, and each other.
//!
//! - *Mesh nodes against a shape*: by the signed distance of the shape, in its axes, where a node moves by `s₀ → s₁`.
//!   Within [`NEAR`] of a face's size the normal is that at the start. A node that moves farther than that within the
//!   step is followed along its path, by steps of its distance, which cannot jump over the surface; the normal is
//!   that at the place of impact. So nothing tunnels, whatever the speed.
//! - *A shape against a plane*: the few points that may be lowest ([`crate::rigid::Shape::feet`]).
//! - *Two shapes*: the points of parry's contact manifold, four or more where faces lie on each other; where they
//!   move or turn far relative to each other, at the time of their first impact, found in the same way as that of
//!   nodes.
//! - *Faces of a mesh between their nodes*, which a shape may enter by a small fraction of their size
//!   (`rigid_faces.rs`).
//!
//! The result depends on the positions alone, never on earlier steps.

use super::boundary::Boundary;
use super::closest_point::Patch;
use super::detector::{DetectionError, Detector, Motion};
use super::frame::local_frame;
use super::narrow_phase::{NEAR, Proximity, eval_proximity_within, is_outside_box};
use super::part::{LEAST, PARTS};
use super::rigid_faces::{Place, RIGID_ALLOWED, allowed, touches_of};
use super::rigid_manifold::{ManifoldFinder, Touch, parry_shape, shape_distance};
use super::rigid_mesh::{MeshPart, MeshSide};
use super::time_of_impact::first_meeting;
use crate::contact::kind::{Gap, Identity, Kind, SLOW};
use crate::contact::stencil::Stencil;
use crate::contact::{Contact, ContactLaw, ContactPair, Master, Surface};
use crate::rigid::{Pose, RigidBody, Shape};
use crate::tensor::Vec3;
use crate::threads::Threads;
use parry3d_f64::shape::SharedShape;

pub use super::rigid_manifold::MOST_POINTS;

/// Distance from the surface at which a node has met it, as a fraction of the search distance.
const MET: f64 = 1e-9;
/// The same for two shapes, whose distance is found by iteration.
const MET_SHAPES: f64 = 1e-3;

/// A rigid body against a face between its nodes, at one of several places. It may keep what linearisation leaves, up to twice
/// the allowed depth.
const FACE: Kind = Kind {
    gap: Gap::ConstantWeights,
    kept: RIGID_ALLOWED,
    pace: SLOW,
    identity: Identity::Weights,
    ..Kind::NODE
};
/// One of several points of a rigid body, against a plane or another one.
const POINT: Kind = Kind { identity: Identity::Point, ..Kind::NODE };

/// Largest distance from a shape or plane at which a contact is formed, for a length of a shape or face [m].
pub fn reach(size: f64) -> f64 {
    NEAR * size
}

/// One side of a pair.
#[derive(Clone, Debug)]
enum Side {
    Mesh(MeshSide),
    Body(usize),
    /// A point, and n, t1, t2.
    Plane(Vec3, [Vec3; 3]),
}

/// Finds the contacts of the pairs with a rigid side.
pub struct RigidDetector {
    bodies: Vec<RigidBody>,
    shapes: Vec<SharedShape>,
    /// Number of the pair, slave and master.
    pairs: Vec<(u32, Side, Side)>,
    manifolds: ManifoldFinder,
    touches: Vec<Touch>,
    /// Faces near the body of the present pair.
    near: Vec<u32>,
    /// Parts of the mesh of the present pair.
    parts: Vec<MeshPart>,
    threads: Threads,
}

impl RigidDetector {
    /// For the `pairs` with a rigid side, numbered from `first` on; `x` [m] are the positions of all nodes at the
    /// start of the run.
    pub fn new(
        surfaces: &[Surface],
        (pairs, first): (&[ContactPair], usize),
        bodies: &[RigidBody],
        x: &[Vec3],
    ) -> Self {
        let slave = |pair: &ContactPair| {
            let surface = &surfaces[pair.slave];
            let body = bodies.iter().position(|body| surface.nodes == [body.centre]);
            body.map_or_else(|| Side::Mesh(MeshSide::new(surface, x)), Side::Body)
        };
        let of_pair = |(index, pair): (usize, &ContactPair)| {
            let master = match pair.master {
                Master::Rigid(body) => Side::Body(body),
                Master::Plane { point, normal } => Side::Plane(point, local_frame(&normal, &Vec3::zeros())),
                Master::Surface(_) => return None,
            };
            Some(((first + index) as u32, slave(pair), master))
        };
        let faces = surfaces.iter().map(|surface| surface.faces.len()).max().unwrap_or(0);
        Self {
            parts: (0..PARTS).map(|_| MeshPart::with_capacity(faces.div_ceil(PARTS).max(LEAST))).collect(),
            threads: Threads::ONE,
            near: Vec::with_capacity(faces),
            bodies: bodies.to_vec(),
            shapes: bodies.iter().map(|body| parry_shape(&body.shape)).collect(),
            pairs: pairs.iter().enumerate().filter_map(of_pair).collect(),
            manifolds: ManifoldFinder::default(),
            touches: Vec::with_capacity(MOST_POINTS),
        }
    }

    /// Examines large meshes on several threads.
    #[must_use]
    pub fn on(self, threads: &Threads) -> Self {
        Self { threads: threads.clone(), ..self }
    }
}

impl Detector for RigidDetector {
    /// By pair, the contacts of nodes before those of faces.
    fn detect(&mut self, motion: &Motion, contacts: &mut Vec<Contact>) -> Result<(), DetectionError> {
        if let Some(body) = motion.poses.iter().chain(motion.poses_end).position(|pose| !pose.is_finite()) {
            return Err(DetectionError::BodyNotFinite { body: body % self.bodies.len() });
        }
        let Self { bodies, shapes, pairs, manifolds, touches, near, parts, threads } = self;
        for (index, slave, master) in pairs.iter() {
            let finder = Finder { pair: *index, bodies, motion };
            match (slave, master) {
                (Side::Mesh(mesh), Side::Body(body)) => {
                    parts.iter_mut().enumerate().for_each(|(i, part)| part.begin(i, mesh));
                    let threads = if mesh.owns.len() > LEAST { &*threads } else { &Threads::ONE };
                    threads.for_each(parts, |part| finder.mesh_on_body(mesh, *body, part));
                    for part in parts.iter_mut() {
                        contacts.append(&mut part.of_nodes);
                    }
                    near.clear();
                    for part in parts.iter_mut() {
                        contacts.append(&mut part.of_faces);
                        near.append(&mut part.near);
                    }
                    finder.corners_in_creases(&mesh.boundary, near, *body, contacts);
                }
                (Side::Body(body), Side::Plane(point, frame)) => {
                    finder.body_on_plane(*body, point, frame, contacts);
                }
                (Side::Body(a), Side::Body(b)) => {
                    finder.body_on_body([*a, *b], shapes, manifolds, touches, contacts);
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// Finds the contacts of one pair in one step.
struct Finder<'a> {
    pair: u32,
    bodies: &'a [RigidBody],
    motion: &'a Motion<'a>,
}

impl Finder<'_> {
    /// Contacts of a part of a mesh.
    fn mesh_on_body(&self, mesh: &MeshSide, body: usize, part: &mut MeshPart) {
        let MeshPart { nodes, faces, of_nodes, of_faces, near, places } = part;
        let nodes = mesh.boundary.nodes[nodes.clone()].iter();
        of_nodes
            .extend(nodes.filter_map(|&node| self.node_on_body(node, reach(mesh.boundary.mean_size), body)));
        for face in faces.clone() {
            if self.face_on_body((&mesh.boundary, face), mesh.owns[face], body, (of_faces, places)) {
                near.push(face as u32);
            }
        }
    }

    fn node_on_body(&self, node: u32, near: f64, body: usize) -> Option<Contact> {
        let (start, end) = (&self.motion.poses[body], &self.motion.poses_end[body]);
        let (x, x_end) = (self.motion.x[node as usize], self.motion.x_end[node as usize]);
        let shape = &self.bodies[body].shape;
        // Most nodes are far away during the whole step.
        let (from, to) = (x - start.centre, x_end - end.centre);
        if from.norm() - (to - from).norm() > shape.outer_radius() + near {
            return None;
        }
        let (s, s_end) = (start.local(&x), end.local(&x_end));
        let (gap, normal) = shape.eval_distance(&s);
        let way = s_end - s;
        let length = way.norm();
        if gap > 0.0
            && length > near
            && let Some(fraction) =
                first_meeting(|t| shape.eval_distance(&(s + way * t)).0, length, MET * near)
        {
            let met = s + way * fraction;
            let (left, normal) = shape.eval_distance(&met);
            let then = start.orientation.slerp(&end.orientation, fraction);
            let point = start.centre + then * met;
            let gap = left - normal.dot(&way) * fraction;
            return Some(self.contact(Kind::NODE, node, Some(body), &(then * normal), gap, point));
        }
        (gap <= near)
            .then(|| self.contact(Kind::NODE, node, Some(body), &(start.orientation * normal), gap, x))
    }

    /// Contacts of a face between its nodes, and on the edges checked with it; returns whether the face is near the
    /// body.
    fn face_on_body(
        &self,
        (boundary, index): (&Boundary, usize),
        owns: [bool; 4],
        body: usize,
        (contacts, places): (&mut Vec<Contact>, &mut Vec<Place>),
    ) -> bool {
        let (face, size) = (&boundary.faces[index], boundary.sizes[index]);
        let (start, end) = (&self.motion.poses[body], &self.motion.poses_end[body]);
        let shape = &self.bodies[body].shape;
        // Most faces are far away during the whole step.
        let from = face.map(|node| self.motion.x[node as usize] - start.centre);
        let to = face.map(|node| self.motion.x_end[node as usize] - end.centre);
        let middle = (from[0] + from[2]) * 0.5;
        let around = from.iter().map(|x| (x - middle).norm_squared()).fold(0.0, f64::max).sqrt();
        let moved =
            from.iter().zip(&to).map(|(x, x_end)| (x_end - x).norm_squared()).fold(0.0, f64::max).sqrt();
        if middle.norm() - around - moved > shape.outer_radius() {
            return false;
        }
        // Both ends of the step in the axes of the body.
        let patch = |pose: &Pose, x: [Vec3; 4]| Patch {
            corners: x.map(|x| pose.orientation.inverse_transform_vector(&x)),
            triangle: face[2] == face[3],
        };
        touches_of((shape, places), size, [&patch(start, from), &patch(end, to)], owns, |touch| {
            let then = start.orientation.slerp(&end.orientation, touch.fraction);
            let place = (touch.weights, start.place(&touch.point));
            contacts.extend(self.fixed((index as u32, face), place, &(then * touch.normal), touch.gap, body));
        });
        true
    }

    /// Corners of the body inside the mesh whose closest point, at the start of the step, is on an edge or a node: in
    /// a crease, where the adjacent faces rise, so that the corner projects onto none of them.
    fn corners_in_creases(
        &self,
        boundary: &Boundary,
        faces: &[u32],
        body: usize,
        contacts: &mut Vec<Contact>,
    ) {
        let shape @ (Shape::Box { .. } | Shape::Polyhedron(_)) = &self.bodies[body].shape else { return };
        for corner in shape.feet(&Vec3::zeros()).points() {
            let place = self.motion.poses[body].place(corner);
            let mut nearest: Option<Proximity> = None;
            for &face in faces {
                let limit = nearest.map_or(reach(boundary.largest_size), |p| p.distance);
                let corners = boundary.faces[face as usize].map(|node| self.motion.x[node as usize]);
                if is_outside_box(&corners, &place, limit) {
                    continue;
                }
                let found = eval_proximity_within(boundary, face, &place, self.motion.x, limit);
                nearest = found.filter(|p| nearest.is_none_or(|n| p.distance < n.distance)).or(nearest);
            }
            if let Some(p) = nearest.filter(|p| p.beyond && p.gap < 0.0) {
                let face = &boundary.faces[p.face as usize];
                let gap = p.gap + allowed(shape, boundary.sizes[p.face as usize], 0.0);
                let on_face = (p.weights, place - p.normal * p.gap);
                contacts.extend(self.fixed((p.face, face), on_face, &-p.normal, gap, body));
            }
        }
    }

    /// The contact of a point of a face, given by its shape functions and position [m].
    fn fixed(
        &self,
        (index, face): (u32, &[u32; 4]),
        (weights, point): ([f64; 4], Vec3),
        normal: &Vec3,
        gap: f64,
        body: usize,
    ) -> Option<Contact> {
        let of_face = || face.iter().copied().zip(weights);
        let heaviest =
            of_face().fold((face[0], 0.0), |best, (node, w)| if w > best.1 { (node, w) } else { best });
        let stencil = Stencil::new(of_face(), [(self.bodies[body].centre, 1.0)])?;
        let contact = self.contact(FACE, heaviest.0, Some(body), normal, gap, point);
        Some(Contact { face: index, stencil, ..contact })
    }

    fn body_on_plane(&self, body: usize, point: &Vec3, frame: &[Vec3; 3], contacts: &mut Vec<Contact>) {
        let RigidBody { shape, centre, .. } = &self.bodies[body];
        let feet = |pose: &Pose| shape.feet(&pose.orientation.inverse_transform_vector(&-frame[0]));
        let (start, end) = (&self.motion.poses[body], &self.motion.poses_end[body]);
        for (foot, foot_end) in feet(start).points().iter().zip(feet(end).points()) {
            let place = start.place(foot);
            let height = |x: &Vec3| frame[0].dot(&(x - point));
            let gap = height(&place);
            if gap.min(height(&end.place(foot_end))) <= reach(shape.size()) {
                let contact = self.contact(POINT, *centre, None, &frame[0], gap, place);
                contacts.push(Contact { frame: *frame, ..contact });
            }
        }
    }

    fn body_on_body(
        &self,
        bodies: [usize; 2],
        shapes: &[SharedShape],
        manifolds: &mut ManifoldFinder,
        touches: &mut Vec<Touch>,
        contacts: &mut Vec<Contact>,
    ) {
        // Bounds of the distance and of the relative motion.
        let [a, b] = bodies.map(|body| &self.bodies[body]);
        let [a_start, b_start] = bodies.map(|body| self.motion.poses[body]);
        let [a_end, b_end] = bodies.map(|body| self.motion.poses_end[body]);
        let [a_step, b_step] = [a_end.centre - a_start.centre, b_end.centre - b_start.centre];
        let near = reach(a.shape.size().min(b.shape.size()));
        let [a_turn, b_turn] = [rotation(&a_start, &a_end), rotation(&b_start, &b_end)];
        let [a_radius, b_radius] = [a.shape.outer_radius(), b.shape.outer_radius()];
        let moved = (a_step - b_step).norm() + a_turn.norm() * a_radius + b_turn.norm() * b_radius;
        let apart = (a_start.centre - b_start.centre).norm() - a_radius - b_radius;
        if apart > near + moved {
            return;
        }
        let [a_shape, b_shape] = bodies.map(|body| &shapes[body]);
        touches.clear();
        // Poses at a fraction of the step.
        let then = |start: &Pose, end: &Pose, fraction: f64| Pose {
            centre: start.centre.lerp(&end.centre, fraction),
            orientation: start.orientation.slerp(&end.orientation, fraction),
        };
        let distance = |fraction: f64| {
            shape_distance(
                (a_shape, &then(&a_start, &a_end, fraction)),
                (b_shape, &then(&b_start, &b_end, fraction)),
            )
        };
        // Slow bodies: the points that may close within the step, at the start. Fast ones: those of the first impact.
        if moved <= near {
            manifolds.find((a_shape, &a_start), (b_shape, &b_start), near, |touch| touches.push(touch));
        } else if let Some(fraction) = first_meeting(distance, moved, MET_SHAPES * near) {
            let (a_then, b_then) = (then(&a_start, &a_end, fraction), then(&b_start, &b_end, fraction));
            manifolds.find((a_shape, &a_then), (b_shape, &b_then), near, |touch| {
                // The gap at the start that closes to that of the impact, and the moment arm on the slave at the impact.
                let way =
                    |step: &Vec3, turn: &Vec3, then: &Pose| step + turn.cross(&(touch.point - then.centre));
                let closed = way(&a_step, &a_turn, &a_then) - way(&b_step, &b_turn, &b_then);
                let gap = touch.gap - touch.normal.dot(&closed) * fraction;
                let point = touch.point + (a_start.centre - a_then.centre);
                touches.push(Touch { point, gap, ..touch });
            });
        }
        contacts.extend(touches.iter().map(|touch| {
            self.contact(POINT, a.centre, Some(bodies[1]), &touch.normal, touch.gap, touch.point)
        }));
    }

    /// A contact of the slave's node (the centre of a rigid slave) with a rigid body or a plane.
    fn contact(
        &self,
        kind: Kind,
        slave: u32,
        master: Option<usize>,
        normal: &Vec3,
        gap: f64,
        point: Vec3,
    ) -> Contact {
        let centre = master.map_or(slave, |body| self.bodies[body].centre);
        let weight = if master.is_some() { 1.0 } else { 0.0 };
        Contact {
            pair: self.pair,
            kind,
            slave,
            face: u32::MAX,
            stencil: Stencil::node_on_face(slave, &[centre; 4], &[weight, 0.0, 0.0, 0.0]),
            frame: local_frame(normal, &Vec3::zeros()),
            gap,
            point,
            drift: Vec3::zeros(),
            law: ContactLaw::Frictionless,
        }
    }
}

/// The rotation from one pose to another, axis times angle [rad].
fn rotation(start: &Pose, end: &Pose) -> Vec3 {
    (end.orientation * start.orientation.inverse()).scaled_axis()
}

#[cfg(test)]
mod tests;
