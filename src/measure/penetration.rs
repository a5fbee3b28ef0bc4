//! How far the two sides of each pair lie inside each other: by the elements, not by the list of contacts.
//!
//! A point is inside a mesh where one of its elements holds it ([`Locator`]), inside a rigid body where the signed distance of its
//! shape is negative, inside a plane where it is behind it. Its depth is the distance to the nearest face of the skin. Looked at:
//! the nodes of both skins (of a rigid body points of its surface), for the depth; the Gauss points of the elements (of a rigid body
//! a lattice), for the volume, so that of two edges which cross between their nodes the volume tells.

use crate::mechanics::contact::Master;
use crate::mechanics::contact::closest_point::Patch;
use crate::mechanics::rigid::{Pose, Shape, triangulated};
use crate::mechanics::tensor::Vec3;
use crate::mesh::hexahedron::{gauss_points, jacobian, volume_m3};
use crate::mesh::locate::{Locator, place};
use crate::plan::PlanBody;
use crate::step::Frame;

/// Points of the lattice in a rigid body along each axis.
const LATTICE: i32 = 12;

/// The deepest penetration and the largest overlap at the field times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Penetration {
    /// The depth that is the largest share of a face so far.
    pub deepest: Depth,
    /// The overlap that is the largest share of a body so far.
    pub largest: Overlap,
}

/// How deep a point lies inside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Depth {
    /// Depth [m].
    pub depth: f64,
    /// The same over the size (√ of the area) of the nearest face; of a rigid body over the mean size of the other side's faces
    /// (between rigid bodies and planes over its smallest thickness) [-].
    pub share: f64,
    /// Of which bodies.
    pub between: String,
    /// When [s].
    pub time: f64,
}

/// How much of a volume belongs to two.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlap {
    /// Volume [m³].
    pub volume: f64,
    /// The same over the volume of the smaller body [-].
    pub share: f64,
    /// Of which bodies.
    pub between: String,
    /// When [s].
    pub time: f64,
}

/// One side of a pair at a time.
enum Side<'a> {
    Mesh(Mesh<'a>),
    Rigid(Shape, Pose),
    Plane(Vec3, Vec3),
}

/// A body of elements where it is.
struct Mesh<'a> {
    body: &'a PlanBody,
    x: &'a [Vec3],
    locator: Locator<'a>,
    bounds: [Vec3; 2],
    volume: f64,
}

/// What is found of one pair: depth and its share, volume.
#[derive(Clone, Copy, Default)]
struct Found {
    depth: f64,
    share: f64,
    volume: f64,
}

impl Penetration {
    /// Takes in what a frame shows; it is at a field time, when all displacements are known.
    pub fn accumulate(&mut self, frame: &Frame) {
        let plan = frame.plan;
        let mut x = plan.X.clone();
        for (index, body) in plan.bodies.iter().enumerate() {
            for node in body.nodes.clone() {
                x[node as usize] = frame.position_in(index, node);
            }
        }
        // Broken positions end the run, which says so.
        if !x.iter().all(|x| x.iter().all(|c| c.is_finite())) {
            return;
        }
        let sides: Vec<Side> = (0..plan.bodies.len()).map(|body| Side::of_body(frame, body, &x)).collect();
        for pair in plan.contact.iter().flat_map(|contact| contact.pairs.iter().zip(&contact.pair_bodies)) {
            let (pair, &(slave, master)) = pair;
            let own = &sides[slave];
            let (found, smaller) = match (&pair.master, master, own) {
                (Master::Plane { point, normal }, ..) => {
                    (look(own, &Side::Plane(*point, *normal)), own.volume())
                }
                (_, Some(master), _) if master != slave => {
                    (look(own, &sides[master]), own.volume().min(sides[master].volume()))
                }
                (.., Side::Mesh(mesh)) => (mesh.look_at_itself(), mesh.volume),
                _ => continue,
            };
            self.keep(&pair.name, frame.time, found, smaller);
        }
    }

    fn keep(&mut self, between: &str, time: f64, found: Found, smaller: f64) {
        let Found { depth, share, volume } = found;
        if share > self.deepest.share {
            self.deepest = Depth { depth, share, between: between.to_owned(), time };
        }
        let share = volume / smaller;
        if share > self.largest.share {
            self.largest = Overlap { volume, share, between: between.to_owned(), time };
        }
    }
}

/// Points of either side inside the other.
fn look(a: &Side, b: &Side) -> Found {
    let mut found = Found::default();
    for (points_of, of) in [(a, b), (b, a)] {
        let size =
            of.face_size().or(points_of.face_size()).unwrap_or_else(|| a.thickness().min(b.thickness()));
        points_of.for_each_surface_point(of, |point| {
            if let Some((depth, of_face)) = of.depth_at(point) {
                found.deepen(depth, of_face.unwrap_or(size));
            }
        });
        // Both count the same volume, each as finely as its own points.
        let mut volume = 0.0;
        points_of.for_each_volume_point(of, |point, weight| {
            volume += if of.holds(point) { weight() } else { 0.0 };
        });
        found.volume = found.volume.max(volume);
    }
    found
}

impl Found {
    fn deepen(&mut self, depth: f64, size: f64) {
        if depth > self.share * size {
            (self.depth, self.share) = (depth, depth / size);
        }
    }
}

impl<'a> Side<'a> {
    fn of_body(frame: &Frame<'a>, index: usize, x: &'a [Vec3]) -> Self {
        let body = &frame.plan.bodies[index];
        match (frame.pose(index), body.rigid, &frame.plan.rigid) {
            (Some(pose), Some(rigid), Some(plan)) => Self::Rigid(plan.bodies[rigid].shape, pose),
            _ => Self::Mesh(Mesh::new(body, x)),
        }
    }

    fn volume(&self) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.volume,
            Self::Rigid(shape, _) => shape.volume(),
            Self::Plane(..) => f64::INFINITY,
        }
    }

    /// Mean size of the faces of a mesh [m].
    fn face_size(&self) -> Option<f64> {
        let Self::Mesh(Mesh { body, x, .. }) = self else { return None };
        let sizes = body.skin.faces.iter().map(|face| Patch::new(face, x).area().sqrt());
        Some(sizes.sum::<f64>() / body.skin.faces.len() as f64)
    }

    fn thickness(&self) -> f64 {
        match self {
            Self::Rigid(shape, _) => shape.size(),
            _ => f64::INFINITY,
        }
    }

    fn holds(&self, point: &Vec3) -> bool {
        match self {
            Self::Mesh(mesh) => mesh.locator.element_at(point, |_| true).is_some(),
            Self::Rigid(shape, pose) => shape.eval_distance(&pose.local(point)).0 < 0.0,
            Self::Plane(at, normal) => normal.dot(&(point - at)) < 0.0,
        }
    }

    /// How deep a point is inside [m], with the size of the nearest face of a mesh [m].
    fn depth_at(&self, point: &Vec3) -> Option<(f64, Option<f64>)> {
        let depth = match self {
            Self::Mesh(mesh) => {
                mesh.locator.element_at(point, |_| true)?;
                return mesh.depth_below_skin(point, |_| true).map(|(d, size)| (d, Some(size)));
            }
            Self::Rigid(shape, pose) => -shape.eval_distance(&pose.local(point)).0,
            Self::Plane(at, normal) => -normal.dot(&(point - at)),
        };
        (depth > 0.0).then_some((depth, None))
    }

    /// The box around what the points of another side must be in to be inside [m].
    fn bounds(&self) -> [Vec3; 2] {
        match self {
            Self::Mesh(mesh) => mesh.bounds,
            Self::Rigid(shape, pose) => {
                [-1.0, 1.0].map(|sign| pose.centre.add_scalar(sign * shape.outer_radius()))
            }
            Self::Plane(..) => [f64::NEG_INFINITY, f64::INFINITY].map(Vec3::repeat),
        }
    }

    fn for_each_surface_point(&self, inside: &Side, mut take: impl FnMut(&Vec3)) {
        let [low, high] = inside.bounds();
        let mut take_near = |point: &Vec3| {
            if *point >= low && *point <= high {
                take(point);
            }
        };
        match self {
            Self::Mesh(mesh) => {
                mesh.body.skin.nodes.iter().for_each(|&node| take_near(&mesh.x[node as usize]))
            }
            Self::Rigid(shape, pose) => {
                let (vertices, triangles) = triangulated(shape);
                vertices.iter().for_each(|vertex| take_near(&pose.place(vertex)));
                for triangle in triangles {
                    let [a, b, c] = triangle.map(|i| vertices[i as usize]);
                    [a + b, b + c, c + a].iter().for_each(|sum| take_near(&pose.place(&(sum * 0.5))));
                }
            }
            Self::Plane(..) => {}
        }
    }

    /// Points with the volumes that they stand for [m³], asked for where they matter.
    fn for_each_volume_point(&self, inside: &Side, mut take: impl FnMut(&Vec3, &dyn Fn() -> f64)) {
        let [low, high] = inside.bounds();
        match self {
            Self::Mesh(mesh) => mesh.for_each_volume_point(|_, point, weight| {
                if *point >= low && *point <= high {
                    take(point, weight);
                }
            }),
            Self::Rigid(shape, pose) => {
                let cell = 2.0 * shape.outer_radius() / f64::from(LATTICE);
                let at = |i: i32| (f64::from(i) + 0.5) * cell - shape.outer_radius();
                let inner = |p: &Vec3| shape.eval_distance(p).0 < 0.0;
                let cells =
                    (0..LATTICE.pow(3)).map(|n| [n % LATTICE, n / LATTICE % LATTICE, n / LATTICE.pow(2)]);
                for local in cells.map(|ijk| Vec3::from(ijk.map(at))).filter(inner) {
                    let point = pose.place(&local);
                    if point >= low && point <= high {
                        take(&point, &|| cell.powi(3));
                    }
                }
            }
            Self::Plane(..) => {}
        }
    }
}

impl<'a> Mesh<'a> {
    fn new(body: &'a PlanBody, x: &'a [Vec3]) -> Self {
        let at = |hex: &[u32; 8]| hex.map(|node| x[node as usize]);
        let nodes = body.skin.nodes.iter().map(|&node| x[node as usize]);
        let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        Self {
            body,
            x,
            locator: Locator::new(&body.hexes, x),
            bounds: nodes.fold(nothing, |[low, high], x| [low.inf(&x), high.sup(&x)]),
            volume: body.hexes.iter().map(|hex| volume_m3(&at(hex))).sum(),
        }
    }

    /// Distance [m] to the nearest face of those taken, and its size [m].
    fn depth_below_skin(&self, point: &Vec3, takes: impl Fn(&[u32; 4]) -> bool) -> Option<(f64, f64)> {
        let mut best: Option<(f64, f64)> = None;
        for face in self.body.skin.faces.iter().filter(|face| takes(face)) {
            let patch = Patch::new(face, self.x);
            let far = patch.corners.iter().map(|c| (c - patch.corners[0]).norm_squared()).fold(0.0, f64::max);
            let least = (point - patch.corners[0]).norm() - far.sqrt();
            if best.is_none_or(|(depth, _)| least < depth) {
                let depth = (patch.closest(point).point - point).norm();
                if best.is_none_or(|(least, _)| depth < least) {
                    best = Some((depth, patch.area().sqrt()));
                }
            }
        }
        best
    }

    /// Calls `take` with each element, its Gauss points, and their volumes [m³].
    fn for_each_volume_point(&self, mut take: impl FnMut(usize, &Vec3, &dyn Fn() -> f64)) {
        for (element, hex) in self.body.hexes.iter().enumerate() {
            let corners = hex.map(|node| self.x[node as usize]);
            for xi in gauss_points() {
                take(element, &place(&corners, xi), &|| jacobian(&corners, xi).determinant());
            }
        }
    }

    /// Nodes of the skin inside elements that are no neighbours of their own ones; the volume only where there are such.
    fn look_at_itself(&self) -> Found {
        let mut found = Found::default();
        let is_apart = |around: &[u32], other: &[u32]| !other.iter().any(|node| around.contains(node));
        let mut around = Vec::new();
        for &node in &self.body.skin.nodes {
            let point = &self.x[node as usize];
            // Its own elements hold every node.
            let others = |e: usize| !self.body.hexes[e].contains(&node);
            if self.locator.element_at(point, others).is_none() {
                continue;
            }
            around.clear();
            around.extend(self.body.hexes.iter().filter(|hex| hex.contains(&node)).flatten());
            let apart = |e: usize| is_apart(&around, &self.body.hexes[e]);
            if self.locator.element_at(point, apart).is_some()
                && let Some((depth, size)) = self.depth_below_skin(point, |face| is_apart(&around, face))
            {
                found.deepen(depth, size);
            }
        }
        if found.depth > 0.0 {
            self.for_each_volume_point(|element, point, weight| {
                let hexes = &self.body.hexes;
                if self.locator.element_at(point, |e| is_apart(&hexes[element], &hexes[e])).is_some() {
                    // Each of the two counts it.
                    found.volume += 0.5 * weight();
                }
            });
        }
        found
    }
}
