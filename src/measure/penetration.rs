//! Interpenetration of the two sides of each pair, measured on the elements rather than on the list of contacts.
//!
//! A point is inside a mesh if one of its elements contains it ([`Locator`]), inside a rigid body if the signed
//! distance of its shape is negative, and inside a plane if it lies behind it. Its depth is the distance to the nearest
//! boundary face. Depth is evaluated at the boundary nodes of both sides (for a rigid body, at points of its surface),
//! volume at the Gauss points of the elements (for a rigid body, on a lattice), so that edges crossing between their
//! nodes show up in the volume. Between the nodes of a mesh on a round rigid body no volume counts as shared up to the depth that contact
//! leaves there ([`left_to_nodes`]). A node is inside its own body if the boundary surface winds around the place just
//! outside of it ([`nodes_inside`]).

mod mesh;

use crate::mechanics::contact::Master;
use crate::mechanics::contact::detection::bodies::meeting;
use crate::mechanics::contact::detection::closest_point::Patch;
use crate::mechanics::contact::detection::rigid_faces::{MOST_BOW, left_to_nodes};
use crate::mechanics::rigid::{Pose, Shape, triangulated};
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::locate::{Locator, elements_near};
use crate::step::Frame;
use mesh::{Found, Mesh};
use std::cell::OnceCell;

/// Penetration depth over face size above which the results of a run are withheld [-].
pub const DEPTH_LIMIT: f64 = 0.1;
/// Overlapping volume over the volume of the smaller body above which the results are withheld [-].
pub const OVERLAP_LIMIT: f64 = 0.01;
/// Remedy for a penetration or overlap beyond its limit.
pub const TOO_DEEP: &str = "Lower the speed, refine the coarser of the two surfaces, or end the run earlier; in an implicit run shorten the \
                            steps. Where soft bodies crush each other to folds no mesh keeps them apart.";
/// Lattice points along each axis of a rigid body.
const LATTICE: i32 = 12;

/// The deepest penetration and the largest overlap at the look times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Penetration {
    /// Depth with the largest fraction of a face size so far.
    pub deepest: Depth,
    /// Overlap with the largest fraction of a body volume so far.
    pub largest: Overlap,
}

/// Depth of a point inside another body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Depth {
    /// Depth of the point below the surface [m].
    pub depth: f64,
    /// Depth over the size (√area) of the nearest face; for a rigid body over the mean face size of the other side
    /// (between rigid bodies and planes over the smallest thickness) [-].
    pub fraction: f64,
    /// The fraction that contact leaves to the nodes of a mesh on a round rigid body [-].
    pub left_to_nodes: f64,
    /// Names of the bodies involved.
    pub between: String,
    /// Time of the maximum [s].
    pub time: f64,
}

/// A volume occupied by two bodies at once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlap {
    /// Volume occupied by both bodies [m³].
    pub volume: f64,
    /// Overlapping volume over the volume of the smaller body [-].
    pub fraction: f64,
    /// Names of the bodies involved.
    pub between: String,
    /// Time of the maximum [s].
    pub time: f64,
}

/// One side of a pair at one time.
enum Side<'a> {
    Mesh(Mesh<'a>),
    Rigid(Shape, Pose),
    Plane(Vec3, Vec3),
}

impl Penetration {
    /// Accumulates a frame at a look time, when all displacements are known. `touched`: whether a pair has been in
    /// contact so far; a body that has not touched itself cannot have entered itself.
    pub fn accumulate(&mut self, frame: &Frame, touched: impl Fn(usize) -> bool) {
        // Current positions.
        let plan = frame.plan;
        let mut x = plan.X.clone();
        for (index, body) in plan.bodies.iter().enumerate() {
            for node in body.nodes.clone() {
                x[node as usize] = frame.position_in(index, node);
            }
        }
        // Non-finite positions end the run with a failure of their own.
        if !x.iter().all(|x| x.iter().all(|c| c.is_finite())) {
            return;
        }
        // Each pair once; with itself only after contact.
        let sides: Vec<Side> = (0..plan.bodies.len()).map(|body| Side::of_body(frame, body, &x)).collect();
        let Some(contact) = &plan.contact else { return };
        let listed = contact.pairs.listed().map(|(index, pair)| (index, *pair));
        let every = contact.pairs.every_two();
        let boxes: Vec<[Vec3; 2]> =
            every.surfaces().map(|surface| sides[contact.surface_body[surface]].bounds()).collect();
        let number = |(first, second)| contact.pairs.unlisted().start + every.number(first, second);
        let unlisted = meeting(&boxes).into_iter().map(number).map(|index| (index, contact.pairs.get(index)));
        for (index, pair) in listed.chain(unlisted) {
            let (slave, master) = contact.bodies_of(&pair);
            let own = &sides[slave];
            let (found, other) = match (&pair.master, master, own) {
                (Master::Plane { point, normal }, ..) => (look(own, &Side::Plane(*point, *normal)), None),
                (_, Some(master), _) if master != slave => (look(own, &sides[master]), Some(&sides[master])),
                (.., Side::Mesh(mesh)) if touched(index) => (mesh.look_at_itself(), None),
                _ => continue,
            };
            if found.depth > 0.0 || found.volume > 0.0 {
                self.keep(&plan.name_of(index), frame.time, found, || smaller_volume(own, other));
            }
        }
    }

    /// Describes what exceeded its limit.
    pub fn excess(&self) -> Option<String> {
        let Self { deepest, largest } = self;
        let said = |fraction: f64, of: &str, between: &str, time: f64, limit: f64| {
            let [fraction, limit] = [fraction, limit].map(|x| 100.0 * x);
            (fraction > limit).then(|| {
                format!("{between}: at {:.2} ms {fraction:.1} % of {of} (limit {limit:.0} %)", 1e3 * time)
            })
        };
        let deep = said(deepest.fraction, "a face deep inside", &deepest.between, deepest.time, DEPTH_LIMIT);
        deep.or_else(|| {
            said(largest.fraction, "the volume shared", &largest.between, largest.time, OVERLAP_LIMIT)
        })
    }

    /// Keeps the maxima, given the volume of the smaller body, evaluated on demand.
    fn keep(&mut self, between: &str, time: f64, found: Found, smaller: impl FnOnce() -> f64) {
        let Found { depth, fraction, left_to_nodes, volume } = found;
        if fraction > self.deepest.fraction {
            let between = between.to_owned();
            self.deepest = Depth { depth, fraction, left_to_nodes, between, time };
        }
        let fraction = if volume > 0.0 { volume / smaller() } else { 0.0 };
        if fraction > self.largest.fraction {
            self.largest = Overlap { volume, fraction, between: between.to_owned(), time };
        }
    }
}

/// Volume of a body, or of another that is smaller [m³].
fn smaller_volume(body: &Side, other: Option<&Side>) -> f64 {
    let Some(other) = other else { return body.volume_up_to(f64::INFINITY) };
    // Most of a body that is much larger than the other is not evaluated.
    let [first, second] = if other.size() < body.size() { [other, body] } else { [body, other] };
    let volume = first.volume_up_to(f64::INFINITY);
    second.volume_up_to(volume).min(volume)
}

/// Points of either side that lie inside the other.
fn look<'a>(a: &Side<'a>, b: &Side<'a>) -> Found {
    // Bodies with disjoint bounding boxes do not overlap.
    let mut found = Found::default();
    let ([a_low, a_high], [b_low, b_high]) = (a.bounds(), b.bounds());
    let common = [a_low.sup(&b_low), a_high.inf(&b_high)];
    if (0..3).any(|i| common[0][i] > common[1][i]) || [a, b].into_iter().any(|side| side.is_below(&common)) {
        return found;
    }
    let [a, b] = [(a, b), (b, a)].map(|(side, other)| Near::new(side, other, &common));
    found.left_to_nodes = if a.left_to_nodes.max(b.left_to_nodes) > 0.0 { MOST_BOW } else { 0.0 };
    for (points_of, of) in [(&a, &b), (&b, &a)] {
        let size = OnceCell::new();
        let size = || *size.get_or_init(|| of.side.face_size_beside(points_of.side));
        // Depth from the surface points.
        points_of.side.for_each_surface_point(&common, |point| {
            if of.holds(point) {
                let (depth, of_face) = of.side.depth_at(point);
                found.deepen(depth, of_face.unwrap_or_else(size));
            }
        });
        // Both sides sample the same volume, each at the resolution of its own points.
        let mut volume = 0.0;
        points_of.for_each_volume_point(|point, weight| {
            volume += if of.shares(point) { weight() } else { 0.0 };
        });
        found.volume = found.volume.max(volume);
    }
    found
}

/// A side within the box that it has in common with another.
struct Near<'a, 'b> {
    side: &'b Side<'a>,
    common: &'b [Vec3; 2],
    /// Depth of a mesh in this round rigid body that is left to the nodes [m]: no volume is shared up to it.
    left_to_nodes: f64,
    /// Elements of a mesh there.
    elements: Vec<u32>,
    locator: OnceCell<Locator<'b>>,
}

impl<'a, 'b> Near<'a, 'b> {
    fn new(side: &'b Side<'a>, other: &Side, common: &'b [Vec3; 2]) -> Self {
        let left_to_nodes = match (side, other) {
            (Side::Rigid(shape, _), Side::Mesh(_)) => left_to_nodes(shape),
            _ => 0.0,
        };
        let elements = match side {
            Side::Mesh(mesh) => elements_near(common, &mesh.cells, mesh.x),
            Side::Rigid(..) | Side::Plane(..) => Vec::new(),
        };
        Self { side, common, left_to_nodes, elements, locator: OnceCell::new() }
    }

    /// Whether a point of the box is inside.
    fn holds(&self, point: &Vec3) -> bool {
        match self.side {
            Side::Mesh(mesh) => {
                let locator = || Locator::of(self.elements.clone(), &mesh.cells, mesh.x);
                self.locator.get_or_init(locator).element_at(point, |_| true).is_some()
            }
            Side::Rigid(..) | Side::Plane(..) => self.side.height(point) < 0.0,
        }
    }

    /// Whether a point of the box is so far inside that the other side must not be there.
    fn shares(&self, point: &Vec3) -> bool {
        if matches!(self.side, Side::Mesh(_)) {
            self.holds(point)
        } else {
            self.side.height(point) < -self.left_to_nodes
        }
    }

    /// Visits the points within the box with the volumes they represent [m³], evaluated on demand.
    fn for_each_volume_point(&self, mut take: impl FnMut(&Vec3, &dyn Fn() -> f64)) {
        let [low, high] = self.common;
        match self.side {
            Side::Mesh(mesh) => {
                let elements = self.elements.iter().map(|element| *element as usize);
                mesh.for_each_volume_point(elements, |_, point, weight| {
                    if point >= low && point <= high {
                        take(point, weight);
                    }
                });
            }
            Side::Rigid(shape, pose) => {
                let half = half_extents(shape);
                let cell = half * (2.0 / f64::from(LATTICE));
                let at =
                    |ijk: [i32; 3]| Vec3::from(ijk.map(|i| f64::from(i) + 0.5)).component_mul(&cell) - half;
                let inner = |p: &Vec3| shape.eval_distance(p).0 < -self.left_to_nodes;
                let cells =
                    (0..LATTICE.pow(3)).map(|n| [n % LATTICE, n / LATTICE % LATTICE, n / LATTICE.pow(2)]);
                for local in cells.map(at) {
                    let point = pose.place(&local);
                    if point >= *low && point <= *high && inner(&local) {
                        take(&point, &|| cell.product());
                    }
                }
            }
            Side::Plane(..) => {}
        }
    }
}

impl<'a> Side<'a> {
    fn of_body(frame: &Frame<'a>, index: usize, x: &'a [Vec3]) -> Self {
        let body = &frame.plan.bodies[index];
        match (frame.pose(index), body.rigid, &frame.plan.rigid) {
            (Some(pose), Some(rigid), Some(plan)) => Self::Rigid(plan.bodies[rigid].shape.clone(), pose),
            _ => Self::Mesh(Mesh::new(body, frame.erosion, x)),
        }
    }

    /// Number of points that a volume is the sum of.
    fn size(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.cells.len(),
            Self::Rigid(..) | Self::Plane(..) => 0,
        }
    }

    /// Its volume [m³], or one that is not smaller than `enough`, if its own is not.
    fn volume_up_to(&self, enough: f64) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.volume_up_to(enough),
            Self::Rigid(shape, _) => shape.volume(),
            Self::Plane(..) => f64::INFINITY,
        }
    }

    /// Mean size of the faces of a mesh [m], of another if this is none, of none the smallest thickness.
    fn face_size_beside(&self, other: &Self) -> f64 {
        let size = self.face_size().or_else(|| other.face_size());
        size.unwrap_or_else(|| self.thickness().min(other.thickness()))
    }

    /// Mean size of the faces of a mesh [m].
    fn face_size(&self) -> Option<f64> {
        let Self::Mesh(Mesh { surface, x, .. }) = self else { return None };
        let sizes = surface.faces.iter().map(|face| Patch::new(face, x).area().sqrt());
        Some(sizes.sum::<f64>() / surface.faces.len() as f64)
    }

    fn thickness(&self) -> f64 {
        match self {
            Self::Rigid(shape, _) => shape.size(),
            _ => f64::INFINITY,
        }
    }

    /// Signed distance of a point from a rigid body or a plane, negative inside [m]; meshes use their elements instead.
    fn height(&self, point: &Vec3) -> f64 {
        match self {
            Self::Mesh(_) => f64::INFINITY,
            Self::Rigid(shape, pose) => shape.eval_distance(&pose.local(point)).0,
            Self::Plane(at, normal) => normal.dot(&(point - at)),
        }
    }

    /// Depth of a point inside [m], and the size of the nearest face of a mesh [m].
    fn depth_at(&self, point: &Vec3) -> (f64, Option<f64>) {
        let Self::Mesh(mesh) = self else { return (-self.height(point), None) };
        match mesh.depth_below_surface(point, |_| true) {
            Some((depth, size)) => (depth, Some(size)),
            None => (0.0, None),
        }
    }

    /// Bounding box outside which no point of another side can be inside [m].
    fn bounds(&self) -> [Vec3; 2] {
        match self {
            Self::Mesh(mesh) => mesh.bounds,
            Self::Rigid(shape, pose) => {
                [-1.0, 1.0].map(|sign| pose.centre.add_scalar(sign * shape.outer_radius()))
            }
            Self::Plane(..) => [f64::NEG_INFINITY, f64::INFINITY].map(Vec3::repeat),
        }
    }

    /// Whether this is a plane, and a box lies wholly above it.
    fn is_below(&self, [low, high]: &[Vec3; 2]) -> bool {
        let Self::Plane(at, normal) = self else { return false };
        let lowest = Vec3::from_fn(|i, _| if normal[i] > 0.0 { low[i] } else { high[i] });
        normal.dot(&(lowest - at)) > 0.0
    }

    fn for_each_surface_point(&self, [low, high]: &[Vec3; 2], mut take: impl FnMut(&Vec3)) {
        let mut take_near = |point: &Vec3| {
            if point >= low && point <= high {
                take(point);
            }
        };
        match self {
            Self::Mesh(mesh) => {
                for &node in &mesh.surface.nodes {
                    take_near(&mesh.x[node as usize]);
                }
            }
            Self::Rigid(shape, pose) => {
                let (vertices, triangles) = triangulated(shape);
                for vertex in &vertices {
                    take_near(&pose.place(vertex));
                }
                for triangle in triangles {
                    let [a, b, c] = triangle.map(|i| vertices[i as usize]);
                    for sum in [a + b, b + c, c + a] {
                        take_near(&pose.place(&(sum * 0.5)));
                    }
                }
            }
            Self::Plane(..) => {}
        }
    }
}

/// Half-extents of the bounding box of a shape, in its own axes [m].
fn half_extents(shape: &Shape) -> Vec3 {
    match *shape {
        Shape::Ball { radius } => Vec3::repeat(radius),
        Shape::Box { half } => half,
        Shape::Cylinder { radius, half_length } => Vec3::new(radius, half_length, radius),
        Shape::Capsule { radius, half_length } => Vec3::new(radius, half_length + radius, radius),
        Shape::Polyhedron(ref hull) => hull.half_extent(&Mat3::identity()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mechanics::force::Erosion;
    use crate::mechanics::rigid::Rotation;
    use crate::plan::{Plan, compile};
    use crate::scene::{Budget, NoFiles, load};
    use serde_json::json;
    use std::f64::consts::PI;

    /// Two blocks of 2×2×2 elements and 1 m edges, one on top of the other.
    fn blocks() -> Plan {
        let block = |name: &str, low: f64| {
            json!({
                "name": name,
                "mesh": {"generator": {"kind": "block", "min_m": [0, 0, low], "max_m": [1, 1, low + 1.0], "elements": [2, 2, 2]}},
                "parts": [{"part": "*", "density_kg_per_m3": 1000, "material":
                    {"law": "neo_hookean", "c10_pa": 1e4, "bulk_modulus_pa": 1e6}}]
            })
        };
        let scene =
            json!({"name": "blocks", "end_time_s": 1e-3, "bodies": [block("a", 0.0), block("b", 1.0)]});
        let loaded = load(&serde_json::to_vec(&scene).unwrap(), &NoFiles, &Budget::COMMAND_LINE).unwrap();
        compile(&loaded.scene).unwrap()
    }

    #[test]
    fn a_block_in_a_block_has_its_depth_and_its_volume() {
        let plan = blocks();
        for (depth, volume) in [(-0.01, 0.0), (0.0, 0.0), (0.25, 0.25)] {
            let mut x = plan.X.clone();
            for node in plan.bodies[1].nodes.clone() {
                // Offset, so that no node lies on an edge of the other block.
                x[node as usize] += Vec3::new(0.1, 0.2, -depth);
            }
            let [a, b] = [0, 1].map(|body| Side::Mesh(Mesh::new(&plan.bodies[body], Erosion::none(), &x)));
            let found = look(&a, &b);
            assert!((found.depth - f64::max(depth, 0.0)).abs() < 1e-12, "{depth}: {}", found.depth);
            assert!((found.fraction - 2.0 * f64::max(depth, 0.0)).abs() < 1e-12);
            // A Gauss point represents an eighth of an element: the overlap is exact along z, and within 15 %
            // laterally.
            assert!((found.volume - volume * 0.9 * 0.8).abs() <= 0.15 * volume, "{depth}: {}", found.volume);
        }
    }

    #[test]
    fn a_ball_behind_a_plane_and_two_boxes_have_the_depth_and_volume_of_the_closed_forms() {
        let pose = |z: f64| Pose { centre: Vec3::new(0.3, 0.1, z), orientation: Rotation::identity() };
        let (radius, depth) = (0.5, 0.25);
        let ball = Side::Rigid(Shape::Ball { radius }, pose(radius - depth));
        let found = look(&ball, &Side::Plane(Vec3::zeros(), Vec3::z()));
        let cap = PI * depth * depth * (3.0 * radius - depth) / 3.0;
        assert!((found.depth / depth - 1.0).abs() < 0.01, "{}", found.depth);
        assert!((found.volume / cap - 1.0).abs() < 0.15, "{} for {cap}", found.volume);

        let shape = Shape::Box { half: Vec3::repeat(0.5) };
        let apart = look(&Side::Rigid(shape.clone(), pose(0.0)), &Side::Rigid(shape.clone(), pose(1.01)));
        assert!(apart.depth == 0.0 && apart.volume == 0.0);
        let [a, b] = [0.0, 0.7].map(|z| Side::Rigid(shape.clone(), pose(z)));
        let found = look(&a, &b);
        assert!(
            (found.depth - 0.3).abs() < 1e-12 && (found.volume / 0.3 - 1.0).abs() < 0.15,
            "{}",
            found.volume
        );
    }

    #[test]
    fn a_much_larger_body_is_not_evaluated_as_a_whole() {
        let plan = blocks();
        let [a, b] = [0, 1].map(|body| Side::Mesh(Mesh::new(&plan.bodies[body], Erosion::none(), &plan.X)));
        let pose = Pose { centre: Vec3::zeros(), orientation: Rotation::identity() };
        let ball = Side::Rigid(Shape::Ball { radius: 0.3 }, pose);
        let (small, large) = (4.0 / 3.0 * PI * 0.027, Side::Rigid(Shape::Ball { radius: 3.0 }, pose));
        for (body, other, volume) in
            [(&a, &ball, small), (&ball, &a, small), (&a, &large, 1.0), (&a, &b, 1.0)]
        {
            assert!((smaller_volume(body, Some(other)) - volume).abs() < 1e-12, "{volume}");
        }
        assert!((smaller_volume(&a, None) - 1.0).abs() < 1e-12);
        // The volume of the ball is reached by one of the eight elements.
        assert!((a.volume_up_to(small) - 0.125).abs() < 1e-12);
    }
}
