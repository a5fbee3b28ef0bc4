//! Initial overlaps: bodies inside each other, or behind a plane, at the start.

use super::Findings;
use super::rigid_on_mesh::is_inside;
use crate::mechanics::contact::detection::bodies::meeting;
use crate::mechanics::contact::detection::detector::{Detector as _, Motion};
use crate::mechanics::contact::detection::initial_overlap::{Overlap, TOLERANCE, initial_overlaps};
use crate::mechanics::contact::detection::node_to_face::NodeToFace;
use crate::mechanics::contact::detection::rigid_detection::RigidDetector;
use crate::mechanics::contact::{Contact, ContactLaw, ContactPair, Master, Surface};
use crate::mechanics::rigid::{Pose, RigidBody};
use crate::mechanics::tensor::Vec3;
use crate::mesh::surface::boundary_nodes;
use crate::scene::document::{ContactPairs, MeshDocument, SceneDocument};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::scene_body::{RigidSceneBody, SceneBody};

/// A potential contact: a body, and a body or a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sides {
    Bodies(usize, usize),
    Plane(usize, usize),
}

/// Checks every pair that may touch; pairs with disjoint bounding boxes cost nothing.
pub fn check(document: &SceneDocument, bodies: &[SceneBody], out: &mut Findings) {
    let start = Start::new(document, bodies);
    let (rigid, requested): (Vec<Sides>, Vec<Sides>) = sides(document, &start.boxes)
        .into_iter()
        .filter(|sides| start.may_overlap(document, *sides))
        .partition(|sides| start.has_rigid_side(*sides));
    check_rigid(document, &start, &rigid, out);
    if requested.is_empty() {
        return;
    }
    // Both ways round: a coarse surface can enclose a node of a fine one, and vice versa.
    let mut pairs = Vec::new();
    let mut requested_of = Vec::new();
    for (i, sides) in requested.iter().enumerate() {
        let found = contact_pairs(document, *sides);
        requested_of.extend(std::iter::repeat_n(i, found.len()));
        pairs.extend(found);
    }
    let mut detector = NodeToFace::new(&start.surfaces, &pairs.into_iter().collect(), &start.x);
    let overlaps = initial_overlaps(&mut detector, &start.x);
    for (i, sides) in requested.iter().enumerate() {
        let of_pair: Vec<&Overlap> = overlaps.iter().filter(|o| requested_of[o.pair] == i).collect();
        if let Some(deepest) = of_pair.iter().max_by(|a, b| a.depth.total_cmp(&b.depth)) {
            out.push(problem(document, *sides, of_pair.len(), (deepest.depth, deepest.place)));
        }
    }
}

/// Pairs with a rigid side: by the contacts detected in the initial configuration.
fn check_rigid(document: &SceneDocument, start: &Start, requested: &[Sides], out: &mut Findings) {
    if requested.is_empty() {
        return;
    }
    let pairs: Vec<ContactPair> = requested.iter().map(|sides| start.rigid_pair(document, *sides)).collect();
    let mut detector = RigidDetector::new(&start.surfaces, (&pairs, 0), &start.rigid, &start.x);
    let motion = Motion { x: &start.x, x_end: &start.x, poses: &start.poses, poses_end: &start.poses };
    let mut contacts = Vec::new();
    // Non-finite positions are reported with the numbers that they come from.
    if detector.detect(&motion, &mut contacts).is_err() {
        return;
    }
    let mut is_reported = vec![false; requested.len()];
    for of_pair in contacts.chunk_by(|a, b| a.pair == b.pair) {
        let pair = of_pair[0].pair as usize;
        let sides = requested[pair];
        let size = start.rigid_size(sides);
        let inside: Vec<&Contact> = of_pair.iter().filter(|c| -c.gap > TOLERANCE * size).collect();
        if let Some(deepest) = inside.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)) {
            out.push(problem(document, sides, inside.len(), (-deepest.gap, deepest.point)));
            is_reported[pair] = true;
        }
    }
    // Even with no node nearby, a body may lie wholly inside a mesh.
    for (sides, _) in requested.iter().zip(is_reported).filter(|(_, is_reported)| !is_reported) {
        if let Some((depth, place)) = start.depth_inside(*sides) {
            out.push(problem(document, *sides, 1, (depth, place)));
        }
    }
}

/// Bodies and planes in their initial configuration.
struct Start {
    /// Positions of the nodes of all bodies, body after body [m].
    x: Vec<Vec3>,
    /// Boundary surface of each body.
    surfaces: Vec<Surface>,
    /// Bounding box of each body [m].
    boxes: Vec<[Vec3; 2]>,
    /// The rigid bodies, the index of the rigid body for each body, and the initial poses.
    rigid: Vec<RigidBody>,
    rigid_of: Vec<Option<usize>>,
    poses: Vec<Pose>,
}

impl Start {
    fn new(document: &SceneDocument, bodies: &[SceneBody]) -> Self {
        let mut start = Self {
            x: Vec::new(),
            surfaces: Vec::new(),
            boxes: Vec::new(),
            rigid: Vec::new(),
            rigid_of: Vec::new(),
            poses: Vec::new(),
        };
        for (written, body) in document.bodies.iter().zip(bodies) {
            let first = start.x.len() as u32;
            start.rigid_of.push(body.rigid.is_some().then_some(start.rigid.len()));
            if let Some(rigid) = &body.rigid {
                start.add_rigid(rigid);
                continue;
            }
            start.x.extend(body.mesh.nodes.iter().map(|X| written.start_position(X)));
            let faces = body.boundary();
            let faces: Vec<[u32; 4]> = faces.iter().map(|f| f.map(|a| a + first)).collect();
            start.boxes.push(bounds(&start.x[first as usize..]));
            start.surfaces.push(Surface::new(boundary_nodes(&faces), faces));
        }
        start
    }

    /// A rigid body as in a plan: two nodes, one for its centre and one for its spin.
    fn add_rigid(&mut self, body: &RigidSceneBody) {
        let RigidSceneBody { shape, mass, inertia, pose, .. } = body.clone();
        let centre = self.x.len() as u32;
        self.x.extend([pose.centre; 2]);
        self.surfaces.push(Surface::new(vec![centre], Vec::new()));
        let radius = shape.outer_radius();
        self.boxes.push([pose.centre.add_scalar(-radius), pose.centre.add_scalar(radius)]);
        self.rigid.push(RigidBody { centre, spin: centre + 1, shape, mass, inertia });
        self.poses.push(pose);
    }

    fn rigid_sides(&self, sides: Sides) -> [Option<usize>; 2] {
        match sides {
            Sides::Bodies(a, b) => [self.rigid_of[a], self.rigid_of[b]],
            Sides::Plane(body, _) => [self.rigid_of[body], None],
        }
    }

    /// The rigid body of a pair and the mesh that it faces (indices of the document), if there is one of each.
    fn rigid_and_mesh(&self, sides: Sides) -> Option<(usize, usize)> {
        let Sides::Bodies(a, b) = sides else { return None };
        match [self.rigid_of[a], self.rigid_of[b]] {
            [Some(_), None] => Some((a, b)),
            [None, Some(_)] => Some((b, a)),
            _ => None,
        }
    }

    /// An upper bound on how far a rigid body must move [m] if its centre is inside the mesh of the pair, and where that is
    /// [m].
    fn depth_inside(&self, sides: Sides) -> Option<(f64, Vec3)> {
        let (body, mesh) = self.rigid_and_mesh(sides)?;
        let rigid = self.rigid_of[body]?;
        let (centre, surface) = (self.poses[rigid].centre, &self.surfaces[mesh]);
        let distance = |node: &u32| (self.x[*node as usize] - centre).norm();
        let nearest = surface.nodes.iter().map(distance).fold(f64::INFINITY, f64::min);
        is_inside(surface, &self.x, &centre)
            .then(|| (nearest + self.rigid[rigid].shape.outer_radius(), centre))
    }

    fn has_rigid_side(&self, sides: Sides) -> bool {
        self.rigid_sides(sides) != [None; 2]
    }

    /// Smallest thickness of the rigid bodies of a pair [m].
    fn rigid_size(&self, sides: Sides) -> f64 {
        let of_pair = self.rigid_sides(sides);
        of_pair.iter().flatten().map(|&body| self.rigid[body].shape.size()).fold(f64::INFINITY, f64::min)
    }

    /// The pair for detection: the mesh is the slave of a rigid body.
    fn rigid_pair(&self, document: &SceneDocument, sides: Sides) -> ContactPair {
        match sides {
            Sides::Plane(body, plane) => contact_pair(body, plane_of(document, plane)),
            Sides::Bodies(a, b) => match [self.rigid_of[a], self.rigid_of[b]] {
                [_, Some(master)] => contact_pair(a, Master::Rigid(master)),
                [Some(master), None] => contact_pair(b, Master::Rigid(master)),
                [None, None] => contact_pair(a, Master::Surface(b)),
            },
        }
    }

    fn may_overlap(&self, document: &SceneDocument, sides: Sides) -> bool {
        match sides {
            Sides::Bodies(a, b) => {
                let ([low_a, high_a], [low_b, high_b]) = (self.boxes[a], self.boxes[b]);
                (0..3).all(|i| low_a[i] <= high_b[i] && low_b[i] <= high_a[i])
            }
            Sides::Plane(body, plane) => {
                let plane = &document.planes[plane];
                let normal = Vec3::from(plane.normal);
                let lowest = Vec3::from_fn(|i, _| self.boxes[body][usize::from(normal[i] < 0.0)][i]);
                normal.dot(&(lowest - Vec3::from(plane.point_m))) < 0.0
            }
        }
    }
}

fn bounds(points: &[Vec3]) -> [Vec3; 2] {
    let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    points.iter().fold(nothing, |[low, high], x| [low.inf(x), high.sup(x)])
}

/// All pairs that may touch; of every two bodies, those whose `boxes` [m] meet.
fn sides(document: &SceneDocument, boxes: &[[Vec3; 2]]) -> Vec<Sides> {
    let count = document.bodies.len();
    let mut sides: Vec<Sides> = match &document.contact.pairs {
        ContactPairs::All(_) => {
            let between = meeting(boxes).into_iter().map(|(a, b)| Sides::Bodies(a, b));
            let onto = (0..count).flat_map(|a| (0..document.planes.len()).map(move |p| Sides::Plane(a, p)));
            between.chain(onto).collect()
        }
        ContactPairs::List(list) => {
            let body = |name: &str| document.bodies.iter().position(|b| b.name == name);
            let plane = |name: &str| document.planes.iter().position(|p| p.name == name);
            let of_names = |[a, b]: [&str; 2]| match (body(a), body(b)) {
                (Some(a), Some(b)) => Some(Sides::Bodies(a, b)),
                (Some(a), None) => Some(Sides::Plane(a, plane(b)?)),
                (None, Some(b)) => Some(Sides::Plane(b, plane(a)?)),
                (None, None) => None,
            };
            list.iter().filter_map(|pair| of_names([&pair.between[0], &pair.between[1]])).collect()
        }
    };
    // Generated meshes do not overlap themselves.
    let may_be_folded = |body: &usize| {
        let body = &document.bodies[*body];
        body.initial_deformation.is_some() || !matches!(body.mesh, Some(MeshDocument::Generator(_)))
    };
    let itself = document.bodies_that_meet_themselves().filter(may_be_folded);
    sides.extend(itself.map(|body| Sides::Bodies(body, body)));
    sides
}

/// The pairs for detection between two meshes, or a mesh and a plane.
fn contact_pairs(document: &SceneDocument, sides: Sides) -> Vec<ContactPair> {
    match sides {
        Sides::Bodies(a, b) if a == b => vec![contact_pair(a, Master::Surface(a))],
        Sides::Bodies(a, b) => {
            vec![contact_pair(a, Master::Surface(b)), contact_pair(b, Master::Surface(a))]
        }
        Sides::Plane(body, plane) => vec![contact_pair(body, plane_of(document, plane))],
    }
}

fn contact_pair(slave: usize, master: Master) -> ContactPair {
    ContactPair { slave, master, law: ContactLaw::Frictionless }
}

fn plane_of(document: &SceneDocument, plane: usize) -> Master {
    let plane = &document.planes[plane];
    Master::Plane { point: plane.point_m.into(), normal: Vec3::from(plane.normal).normalize() }
}

/// The problem of an overlapping pair; `deepest`: depth [m] and place [m].
fn problem(document: &SceneDocument, sides: Sides, count: usize, deepest: (f64, Vec3)) -> Problem {
    let (body, other) = match sides {
        Sides::Bodies(a, b) => (a, &document.bodies[b].name),
        Sides::Plane(body, plane) => (body, &document.planes[plane].name),
    };
    let name = &document.bodies[body].name;
    let (depth, place) = deepest;
    let points = if count == 1 { "point" } else { "points" };
    let message = format!(
        "{name} and {other} overlap at the start: {count} {points}, the deepest by {depth:.4e} m at \
         ({:.6}, {:.6}, {:.6}) m",
        place.x, place.y, place.z
    );
    Problem::error("initial_overlap", &Pointer::root().key("bodies").index(body), message)
        .value(depth)
        .limit(format!("at most {TOLERANCE:e} of the size of a face, or of the thickness of a rigid body"))
        .remedy(format!(
            "move {name} away from {other} by at least this depth (placement, the mesh itself, or the centre)"
        ))
}
