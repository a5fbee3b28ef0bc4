//! The contact patch: area, axes and pressure of the nodes in contact.
//!
//! The patch is that of the slave, the finer surface, bounded by what its master can cover: the faces of a mesh around
//! the participating nodes, or the projection of a rigid body. The patch of a flat end is therefore at most that end.
//!
//! In an impact nodes leave the surface and touch it again within a few steps, on every mesh at other instants, so that the area of the
//! nodes pressed at one instant does not converge. A node therefore counts as in contact until it was last pressed a given time ago.
//! The coarser the mesh, the longer a node stays away: gaps of up to two nodes between others in contact are closed (`closing.rs`).

mod closing;
mod patch;
mod place_map;
mod touch;

use self::closing::{Closing, Corner};
pub use self::patch::ContactPatch;
use self::patch::{Pressed, patch_of};
use self::place_map::PlaceMap;
use self::touch::Touch;
use super::face_shape::{FaceShape, Shadow, distinct};
use crate::mechanics::contact::Surface;
use crate::mechanics::followers::Followers;
use crate::mechanics::rigid::Shape;
use crate::mechanics::tensor::Vec3;
use crate::step::Frame;

/// Incidence of nodes and faces of a slave surface, found once per run, with work arrays of the evaluation.
#[derive(Clone, Debug)]
pub struct PatchGeometry {
    /// Index of the body that owns the surface.
    body: usize,
    /// Number of eroded elements when the faces were listed.
    gone: usize,
    /// Whether it is the master of the contacts: its participating nodes then count in full.
    is_master: bool,
    /// Body index and shape of the master, if it is rigid.
    rigid_master: Option<(usize, Shape)>,
    /// Sorted nodes of the surface; elsewhere a node is its place among them.
    nodes: Vec<u32>,
    /// Corners of each face.
    faces: Vec<[u32; 4]>,
    /// Faces of a node, each with the corner that it is: `incident[start[i]..start[i + 1]]`.
    start: Vec<u32>,
    incident: Vec<(u32, u32)>,
    /// Shape of each face, with the evaluation it belongs to.
    shapes: Vec<(u64, FaceShape)>,
    evaluation: u64,
    /// The nodes in contact.
    touches: PlaceMap<Touch>,
    closing: Closing,
    /// Resultant of the impulses along the normals, of late [N s], with its time [s]; zero before the first contact. In a single step the
    /// nodes at the edge of a body can tilt it by degrees.
    pressing: (Vec3, f64),
    pressed_faces: Vec<u32>,
}

/// Limit of the part of a surface that can be pressed at all.
enum Limit {
    /// All faces oriented towards the contact.
    None,
    /// The part in the projection of a rigid master.
    Shadow(Shadow),
    /// Faces oriented towards the contact as a whole, given by its unit normal.
    Front(Vec3),
}

impl PatchGeometry {
    /// Geometry of a slave surface, the boundary of a body; with body and shape of the master if that is rigid.
    pub fn of_slave(body: usize, surface: &Surface, rigid_master: Option<(usize, Shape)>) -> Self {
        Self { rigid_master, ..Self::new(body, surface, false) }
    }

    /// Geometry of a master surface, the boundary of another body.
    pub fn of_master(body: usize, surface: &Surface) -> Self {
        Self::new(body, surface, true)
    }

    fn new(body: usize, surface: &Surface, is_master: bool) -> Self {
        // Faces of each node, then flattened to one array.
        let nodes = surface.nodes.clone();
        // The nodes of a surface are the corners of its faces.
        let place = |node: u32| nodes.partition_point(|other| *other < node) as u32;
        let faces: Vec<[u32; 4]> = surface.faces.iter().map(|corners| corners.map(place)).collect();
        let mut lists = vec![Vec::new(); nodes.len()];
        for (face, corners) in faces.iter().enumerate() {
            for (corner, place) in distinct(corners).iter().enumerate() {
                lists[*place as usize].push((face as u32, corner as u32));
            }
        }
        let mut start = vec![0];
        let mut incident = Vec::new();
        for list in lists {
            incident.extend(list);
            start.push(incident.len() as u32);
        }
        Self {
            body,
            gone: 0,
            is_master,
            rigid_master: None,
            start,
            incident,
            shapes: vec![(0, FaceShape::default()); faces.len()],
            faces,
            evaluation: 0,
            touches: PlaceMap::of(nodes.len()),
            closing: Closing::of(nodes.len()),
            nodes,
            pressing: (Vec3::zeros(), 0.0),
            pressed_faces: Vec::new(),
        }
    }

    /// Place of a node on the surface; `None` when it is not on it.
    fn place_of(&self, node: u32) -> Option<u32> {
        self.nodes.binary_search(&node).ok().map(|place| place as u32)
    }

    /// Entries of the faces of a node in `incident`.
    fn faces_of(&self, place: u32) -> std::ops::Range<usize> {
        self.start[place as usize] as usize..self.start[place as usize + 1] as usize
    }

    /// Current tributary area of a node [m²]: ∫ N_a dA over its faces oriented towards the contact, with `n` the
    /// outward normal of the other side; within the limit, and in full. Those faces are marked as pressed.
    fn tributary_area(
        &mut self,
        place: u32,
        n: &Vec3,
        position: &impl Fn(u32) -> Vec3,
        limit: &Limit,
    ) -> [f64; 2] {
        let mut areas = [0.0; 2];
        for i in self.faces_of(place) {
            let (face, corner) = self.incident[i];
            let shape = self.shape(face, position, limit);
            // Faces oriented towards the contact contribute.
            let is_pressed = shape.is_turned(n)
                && match limit {
                    Limit::Front(normal) => shape.is_in_front(normal),
                    Limit::Shadow(_) | Limit::None => true,
                };
            if is_pressed {
                let of_corner = shape.tributary_areas(corner as usize);
                areas.iter_mut().zip(of_corner).for_each(|(sum, area)| *sum += area);
                self.pressed_faces.push(face);
            }
        }
        areas
    }

    /// Shape of a face within the limit, found once per evaluation; `position` is that of a global node [m].
    fn shape(&mut self, face: u32, position: &impl Fn(u32) -> Vec3, limit: &Limit) -> &FaceShape {
        let Self { nodes, faces, shapes, evaluation, .. } = self;
        let corners = &faces[face as usize];
        let (of, shape) = &mut shapes[face as usize];
        if *of != *evaluation {
            let position = |place: u32| position(nodes[place as usize]);
            let whole = FaceShape::new(corners, &position);
            let limited = match limit {
                Limit::Shadow(shadow) => whole.clipped(corners, &position, shadow),
                Limit::Front(_) | Limit::None => whole,
            };
            (*of, *shape) = (*evaluation, limited);
        }
        shape
    }

    /// The patch of pair `pair` in a frame; nodes count as in contact until they were last pressed `window` ago [s].
    pub fn eval(&mut self, frame: &Frame, pair: u32, window: f64) -> ContactPatch {
        self.follow_erosion(frame);
        self.touch(frame, pair, window);
        self.keep_since(frame.time - window);
        if self.touches.is_empty() {
            return ContactPatch::default();
        }
        let direction = self.pressing.0.try_normalize(0.0);
        let limit = direction.map_or(Limit::None, |direction| self.limit(frame, direction));
        let body = self.body;
        let position = |node: u32| frame.position_in(body, node);
        let pressed = self.press(frame.time, &position, &limit, frame.plan.assembly.followers());
        let spacing = self.spacing();
        let shadow = if let Limit::Shadow(shadow) = &limit { Some(shadow) } else { None };
        patch_of(&pressed, spacing, shadow)
    }

    /// Notes the nodes that a pair presses in a frame, and their resultant, whose memory is as long as the window [s].
    fn touch(&mut self, frame: &Frame, pair: u32, window: f64) {
        let sign = if self.is_master { -1.0 } else { 1.0 };
        let mut resultant = Vec3::zeros();
        for (contact, reaction) in frame.contacts_of(pair).filter(|(_, reaction)| reaction.impulse[0] > 0.0) {
            let (normal, p_n) = (contact.frame[0] * sign, reaction.impulse[0]);
            resultant += normal * p_n;
            for (node, w) in contact.stencil.side(self.is_master) {
                let weight = if self.is_master { 1.0 } else { w };
                self.add(node, Touch::new((frame.time, normal), weight, w * p_n / frame.mean_step));
            }
        }
        // Without a contact the direction stays.
        if resultant != Vec3::zeros() {
            let (before, time) = self.pressing;
            let kept = if window > 0.0 { (-(frame.time - time) / window).exp() } else { 0.0 };
            self.pressing = (before * kept + resultant, frame.time);
        }
    }

    /// Adds a contact to a node of the surface; points of rigid bodies are not on it.
    fn add(&mut self, node: u32, touch: Touch) {
        let Some(place) = self.place_of(node) else { return };
        let of_node = self.touches.entry(place, || Touch { weight: 0.0, force: 0.0, ..touch });
        let before =
            if of_node.time < touch.time { Touch { weight: 0.0, force: 0.0, ..*of_node } } else { *of_node };
        let (weight, force) = (before.weight + touch.weight, before.force + touch.force);
        *of_node = Touch { weight, force, largest: before.largest, ..touch };
    }

    /// Keeps the nodes that were pressed since a time [s], each with its largest weight since then.
    fn keep_since(&mut self, since: f64) {
        self.touches.retain(|touch| touch.time >= since);
        self.touches.values_mut().for_each(|touch| touch.keep_largest(since));
        self.touches.sort();
    }

    /// Takes the faces that erosion leaves and exposes; contacts of nodes that are no longer on the surface are forgotten.
    fn follow_erosion(&mut self, frame: &Frame) {
        let gone = frame.erosion.elements().len();
        if gone != self.gone {
            let surface = frame.plan.bodies[self.body].boundary_after(frame.erosion);
            let before = std::mem::replace(self, Self::new(self.body, &surface, self.is_master));
            (self.gone, self.rigid_master, self.pressing) = (gone, before.rigid_master, before.pressing);
            for (place, touch) in before.touches.iter() {
                if let Some(place) = self.place_of(before.nodes[place as usize]) {
                    self.touches.entry(place, || *touch);
                }
            }
        }
    }

    /// The region that contacts with this resultant unit normal can press.
    fn limit(&self, frame: &Frame, normal: Vec3) -> Limit {
        if self.is_master {
            return Limit::Front(normal);
        }
        let Some((body, shape)) = &self.rigid_master else { return Limit::None };
        frame.pose(*body).map_or(Limit::None, |pose| {
            let direction = pose.orientation.inverse_transform_vector(&normal);
            Limit::Shadow(Shadow { shape: shape.clone(), pose, normal, direction })
        })
    }

    /// The nodes in contact at a time [s] with their areas. A node has its fraction of the areas of the nodes that follow it.
    fn press(
        &mut self,
        time: f64,
        position: &impl Fn(u32) -> Vec3,
        limit: &Limit,
        followers: &Followers,
    ) -> Vec<Pressed> {
        self.evaluation += 1;
        self.pressed_faces.clear();
        let mut touches: Vec<(u32, Touch)> =
            self.touches.iter().map(|(place, touch)| (place, *touch)).collect();
        touches.extend(self.enclosed(position, limit, followers));
        touches.sort_unstable_by_key(|(place, _)| *place);
        let pressed = touches.into_iter().map(|(place, touch)| {
            let node = self.nodes[place as usize];
            let mut tributary = self.tributary_area(place, &touch.normal, position, limit);
            for (follower, w) in followers.led_by(node as usize) {
                let Some(follower) = self.place_of(*follower) else { continue };
                let of_follower = self.tributary_area(follower, &touch.normal, position, limit);
                tributary = std::array::from_fn(|i| tributary[i] + w * of_follower[i]);
            }
            let normal_force = if touch.time < time { 0.0 } else { touch.force };
            let weights = [touch.weight, touch.largest.1];
            Pressed { position: position(node), tributary, weights, normal_force }
        });
        pressed.collect()
    }

    /// The nodes that those in contact enclose; one that follows others has its area with them.
    fn enclosed(
        &mut self,
        position: &impl Fn(u32) -> Vec3,
        limit: &Limit,
        followers: &Followers,
    ) -> Vec<(u32, Touch)> {
        let mut closing = std::mem::take(&mut self.closing);
        self.take_touches_with(followers, &mut closing.pressed);
        let mut enclosed =
            closing.enclosed(|place, n, rings| self.add_ring((place, n), position, limit, rings));
        enclosed.retain(|(place, _)| !followers.contains(self.nodes[*place as usize] as usize));
        self.closing = closing;
        enclosed
    }

    /// Fills the map with the nodes in contact, and those that follow them, in their order.
    fn take_touches_with(&self, followers: &Followers, pressed: &mut PlaceMap<Touch>) {
        pressed.clear();
        for (place, touch) in self.touches.iter() {
            pressed.insert(place, *touch);
            for (follower, _) in followers.led_by(self.nodes[place as usize] as usize) {
                // What is in contact itself has its own; of several masters the last one's.
                if let Some(follower) =
                    self.place_of(*follower).filter(|place| !self.touches.contains(*place))
                {
                    pressed.insert(follower, *touch);
                }
            }
        }
        pressed.sort();
    }

    /// Adds the corners around a node, of its faces that are oriented towards a contact with normal `n`, each once.
    fn add_ring(
        &mut self,
        (place, n): (u32, &Vec3),
        position: &impl Fn(u32) -> Vec3,
        limit: &Limit,
        rings: &mut Vec<Corner>,
    ) {
        let first = rings.len();
        for i in self.faces_of(place) {
            let (face, at) = self.incident[i];
            if !self.shape(face, position, limit).is_turned(n) {
                continue;
            }
            let ring = distinct(&self.faces[face as usize]);
            for (corner, other) in ring.iter().enumerate().filter(|(_, other)| **other != place) {
                let step = (corner + ring.len() - at as usize) % ring.len();
                let faces = u32::from(step == 1 || step == ring.len() - 1);
                match rings[first..].iter_mut().find(|known| known.place == *other) {
                    Some(known) => known.faces += faces,
                    None => rings.push(Corner { place: *other, faces }),
                }
            }
        }
    }

    /// Mean edge length of the pressed faces [m].
    fn spacing(&mut self) -> f64 {
        self.pressed_faces.sort_unstable();
        self.pressed_faces.dedup();
        let faces = &self.pressed_faces;
        let area: f64 = faces.iter().map(|&f| self.shapes[f as usize].1.whole()).sum();
        if faces.is_empty() { 0.0 } else { (area / faces.len() as f64).sqrt() }
    }
}

#[cfg(test)]
mod tests;
