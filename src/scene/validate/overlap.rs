//! Bodies that lie inside each other, or behind a plane, before anything has moved.

use super::Findings;
use crate::mechanics::contact::detection::Detector;
use crate::mechanics::contact::initial_overlap::{Overlap, TOLERANCE, initial_overlaps};
use crate::mechanics::contact::{ContactLaw, ContactPair, Master, Surface};
use crate::mechanics::tensor::Vec3;
use crate::mesh::surface::{skin, skin_nodes};
use crate::scene::SceneBody;
use crate::scene::document::{BodyDocument, ContactPairs, SceneDocument};
use crate::scene::problem::{Pointer, Problem};

/// Two sides that may touch: a body, and a body or a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sides {
    Bodies(usize, usize),
    Plane(usize, usize),
}

/// Checks every pair that may touch; pairs whose boxes lie apart cost nothing.
pub fn check(document: &SceneDocument, bodies: &[SceneBody], out: &mut Findings) {
    let start = Start::new(document, bodies);
    let asked: Vec<Sides> =
        sides(document).into_iter().filter(|sides| start.may_overlap(document, *sides)).collect();
    if asked.is_empty() {
        return;
    }
    // Both ways round: a coarse surface can enclose a node of a fine one and the other way.
    let mut pairs = Vec::new();
    let mut asked_of = Vec::new();
    for (i, sides) in asked.iter().enumerate() {
        let found = contact_pairs(document, *sides);
        asked_of.extend(std::iter::repeat_n(i, found.len()));
        pairs.extend(found);
    }
    let detector = Detector::new(&start.surfaces, &pairs, &start.x);
    let overlaps = initial_overlaps(&detector, &start.x);
    for (i, sides) in asked.iter().enumerate() {
        let of_pair: Vec<&Overlap> = overlaps.iter().filter(|o| asked_of[o.pair] == i).collect();
        if let Some(deepest) = of_pair.iter().max_by(|a, b| a.depth.total_cmp(&b.depth)) {
            out.push(problem(document, *sides, of_pair.len(), deepest));
        }
    }
}

/// Where everything is before anything has moved.
struct Start {
    /// Positions of the nodes of all bodies, body after body [m].
    x: Vec<Vec3>,
    /// The skin of each body.
    surfaces: Vec<Surface>,
    /// The box around each body [m].
    boxes: Vec<[Vec3; 2]>,
}

impl Start {
    fn new(document: &SceneDocument, bodies: &[SceneBody]) -> Self {
        let mut start = Self { x: Vec::new(), surfaces: Vec::new(), boxes: Vec::new() };
        for (written, body) in document.bodies.iter().zip(bodies) {
            let first = start.x.len() as u32;
            start.x.extend(body.mesh.nodes.iter().map(|X| start_position(written, X)));
            let faces: Vec<[u32; 4]> = skin(&body.mesh.hexes).iter().map(|f| f.map(|a| a + first)).collect();
            start.boxes.push(bounds(&start.x[first as usize..]));
            start.surfaces.push(Surface { nodes: skin_nodes(&faces), faces });
        }
        start
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

fn start_position(body: &BodyDocument, X: &Vec3) -> Vec3 {
    body.initial_deformation.as_ref().map_or(*X, |deformation| deformation.position(X))
}

fn bounds(points: &[Vec3]) -> [Vec3; 2] {
    let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    points.iter().fold(nothing, |[low, high], x| [low.inf(x), high.sup(x)])
}

/// All sides that may touch.
fn sides(document: &SceneDocument) -> Vec<Sides> {
    let count = document.bodies.len();
    match &document.contact.pairs {
        ContactPairs::All(_) => {
            let between = (0..count).flat_map(|a| (a + 1..count).map(move |b| Sides::Bodies(a, b)));
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
    }
}

/// The pairs that detection looks at for these sides.
fn contact_pairs(document: &SceneDocument, sides: Sides) -> Vec<ContactPair> {
    let pair =
        |slave, master| ContactPair { name: String::new(), slave, master, law: ContactLaw::Frictionless };
    match sides {
        Sides::Bodies(a, b) if a == b => vec![pair(a, Master::Surface(a))],
        Sides::Bodies(a, b) => vec![pair(a, Master::Surface(b)), pair(b, Master::Surface(a))],
        Sides::Plane(body, plane) => {
            let plane = &document.planes[plane];
            let normal = Vec3::from(plane.normal).normalize();
            vec![pair(body, Master::Plane { point: plane.point_m.into(), normal })]
        }
    }
}

fn problem(document: &SceneDocument, sides: Sides, count: usize, deepest: &Overlap) -> Problem {
    let (body, other) = match sides {
        Sides::Bodies(a, b) => (a, &document.bodies[b].name),
        Sides::Plane(body, plane) => (body, &document.planes[plane].name),
    };
    let name = &document.bodies[body].name;
    let Overlap { place, depth, .. } = deepest;
    let message = format!(
        "{name} and {other} overlap at the start: {count} node(s), the deepest by {depth:.4e} m at \
         ({:.6}, {:.6}, {:.6}) m",
        place.x, place.y, place.z
    );
    Problem::error("initial_overlap", &Pointer::root().key("bodies").index(body), message)
        .value(*depth)
        .limit(format!("at most {TOLERANCE:e} of the size of a face"))
        .remedy(format!(
            "move {name} away from {other} by at least this depth (placement, or the mesh itself)"
        ))
}
