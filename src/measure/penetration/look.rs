//! Points of two bodies that lie inside each other.

use super::mesh::Found;
use super::side::{Side, half_extents};
use crate::mechanics::contact::detection::rigid_faces::{MOST_BOW, left_to_nodes};
use crate::mechanics::tensor::Vec3;
use crate::mesh::locate::{Locator, elements_near};
use crate::mesh::mirror::MirrorPlane;
use std::cell::OnceCell;

/// Lattice points along each axis of a rigid body.
const LATTICE: i32 = 12;
/// Distance from planes of symmetry at which points on them are looked for, relative to the size of the larger mesh [-]: no less than that
/// within which nodes are on the planes.
const INWARDS: f64 = 2e-9;

/// Volume of a body, or of another that is smaller [m³].
pub(super) fn smaller_volume(body: &Side, other: Option<&Side>) -> f64 {
    let Some(other) = other else { return body.volume_up_to(f64::INFINITY) };
    // Most of a body that is much larger than the other is not evaluated.
    let [first, second] = if other.size() < body.size() { [other, body] } else { [body, other] };
    let volume = first.volume_up_to(f64::INFINITY);
    second.volume_up_to(volume).min(volume)
}

/// Points of either side that lie inside the other; of what is on the upper sides of the planes of symmetry, which its images complete.
pub(super) fn look([a, b]: [&Side; 2], planes: &[MirrorPlane]) -> Found {
    // Bodies with disjoint bounding boxes do not overlap.
    let mut found = Found::default();
    let ([a_low, a_high], [b_low, b_high]) = (a.bounds(), b.bounds());
    let common = [a_low.sup(&b_low), a_high.inf(&b_high)];
    if (0..3).any(|i| common[0][i] > common[1][i]) || [a, b].into_iter().any(|side| side.is_below(&common)) {
        return found;
    }
    let [a, b] = [(a, b), (b, a)].map(|(side, other)| Near::new(side, other, &common, planes));
    found.left_to_nodes = if a.left_to_nodes.max(b.left_to_nodes) > 0.0 { MOST_BOW } else { 0.0 };
    for (points_of, of) in [(&a, &b), (&b, &a)] {
        let size = OnceCell::new();
        let size = || *size.get_or_init(|| of.side.face_size_beside(points_of.side));
        // Depth from the surface points.
        points_of.side.for_each_surface_point(|point| {
            let point = &points_of.on_this_side(point);
            if points_of.is_in_box(point) && of.holds(point) {
                let (depth, of_face) = of.side.depth_at(point);
                found.deepen(depth, of_face.unwrap_or_else(size));
            }
        });
        // Both sides sample the same volume, each at the resolution of its own points.
        let mut volume = 0.0;
        points_of.for_each_volume_point(|point, weight| {
            volume += if of.shares(point) { weight() } else { 0.0 };
        });
        found.volume = found.volume.max(points_of.side.images() * volume);
    }
    found
}

/// A side within the box that it has in common with another.
struct Near<'a, 'b> {
    side: &'b Side<'a>,
    common: &'b [Vec3; 2],
    planes: &'b [MirrorPlane],
    /// Distance from the planes of symmetry at which points on them are looked for: there the sector of a mesh may end short of them [m].
    inwards: f64,
    /// Depth of a mesh in this round rigid body that is left to the nodes [m]: no volume is shared up to it.
    left_to_nodes: f64,
    /// Elements of a mesh there.
    elements: Vec<u32>,
    locator: OnceCell<Locator<'b>>,
}

impl<'a, 'b> Near<'a, 'b> {
    fn new(side: &'b Side<'a>, other: &Side, common: &'b [Vec3; 2], planes: &'b [MirrorPlane]) -> Self {
        let left_to_nodes = match (side, other) {
            (Side::Rigid(shape, _), Side::Mesh(_)) => left_to_nodes(shape),
            _ => 0.0,
        };
        let elements = match side {
            Side::Mesh(mesh) => elements_near(common, &mesh.cells, mesh.x),
            Side::Rigid(..) | Side::Plane(..) => Vec::new(),
        };
        let meshes = [side, other].into_iter().filter(|side| matches!(side, Side::Mesh(_)));
        let size = |side: &Side| (side.bounds()[1] - side.bounds()[0]).norm();
        let inwards = INWARDS * meshes.map(size).fold(0.0, f64::max);
        Self { side, common, planes, inwards, left_to_nodes, elements, locator: OnceCell::new() }
    }

    /// A point, or its mirror image on the upper side of the planes of symmetry [m].
    fn on_this_side(&self, point: &Vec3) -> Vec3 {
        self.planes.iter().fold(*point, |point, plane| plane.above(point, 0.0))
    }

    /// Where a point is looked for: not on the planes of symmetry.
    fn off_planes(&self, point: &Vec3) -> Vec3 {
        self.planes.iter().fold(*point, |point, plane| plane.above(point, self.inwards))
    }

    /// Whether a point is in the box.
    fn is_in_box(&self, point: &Vec3) -> bool {
        let ([low, high], point) = (self.common, self.off_planes(point));
        point >= *low && point <= *high
    }

    /// Whether a point of the box is inside.
    fn holds(&self, point: &Vec3) -> bool {
        match self.side {
            Side::Mesh(mesh) => {
                let locator = || Locator::of(self.elements.clone(), &mesh.cells, mesh.x);
                self.locator.get_or_init(locator).element_at(&self.off_planes(point), |_| true).is_some()
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
        match self.side {
            Side::Mesh(mesh) => {
                let elements = self.elements.iter().map(|element| *element as usize);
                mesh.for_each_volume_point(elements, |_, point, weight| {
                    let point = self.on_this_side(point);
                    if self.is_in_box(&point) {
                        take(&point, weight);
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
                    let point = self.on_this_side(&pose.place(&local));
                    if self.is_in_box(&point) && inner(&local) {
                        take(&point, &|| cell.product());
                    }
                }
            }
            Side::Plane(..) => {}
        }
    }
}
