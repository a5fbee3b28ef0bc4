//! A body, or a plane, as one side of a pair.

use super::mesh::Mesh;
use crate::mechanics::contact::detection::closest_point::Patch;
use crate::mechanics::rigid::{Pose, Shape, triangulated};
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::mirror::MirrorPlane;
use crate::step::Frame;

/// One side of a pair at one time.
pub(super) enum Side<'a> {
    Mesh(Mesh<'a>),
    Rigid(Shape, Pose),
    Plane(Vec3, Vec3),
}

impl<'a> Side<'a> {
    pub fn of_body(frame: &Frame<'a>, index: usize, x: &'a [Vec3]) -> Self {
        let body = &frame.plan.bodies[index];
        match (frame.pose(index), body.rigid, &frame.plan.rigid) {
            (Some(pose), Some(rigid), Some(plan)) => Self::Rigid(plan.bodies[rigid].shape.clone(), pose),
            _ => Self::Mesh(Mesh::new(body, frame.erosion, x)),
        }
    }

    /// The part of it on the upper sides of planes of symmetry, which its images complete.
    #[must_use]
    pub fn in_images_of(self, planes: &[MirrorPlane]) -> Self {
        match self {
            Self::Mesh(mesh) => Self::Mesh(mesh.in_images(f64::from(1_u32 << planes.len()))),
            Self::Rigid(..) | Self::Plane(..) => self,
        }
    }

    /// Number of images that each of its points counts for; a rigid body is a whole.
    pub fn images(&self) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.images,
            Self::Rigid(..) | Self::Plane(..) => 1.0,
        }
    }

    /// Number of points that a volume is the sum of.
    pub fn size(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.cells.len(),
            Self::Rigid(..) | Self::Plane(..) => 0,
        }
    }

    /// Its volume [m³], or one that is not smaller than `enough`, if its own is not.
    pub fn volume_up_to(&self, enough: f64) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.volume_up_to(enough),
            Self::Rigid(shape, _) => shape.volume(),
            Self::Plane(..) => f64::INFINITY,
        }
    }

    /// Mean size of the faces of a mesh [m], of another if this is none, of none the smallest thickness.
    pub fn face_size_beside(&self, other: &Self) -> f64 {
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
    pub fn height(&self, point: &Vec3) -> f64 {
        match self {
            Self::Mesh(_) => f64::INFINITY,
            Self::Rigid(shape, pose) => shape.eval_distance(&pose.local(point)).0,
            Self::Plane(at, normal) => normal.dot(&(point - at)),
        }
    }

    /// Depth of a point inside [m], and the size of the nearest face of a mesh [m].
    pub fn depth_at(&self, point: &Vec3) -> (f64, Option<f64>) {
        let Self::Mesh(mesh) = self else { return (-self.height(point), None) };
        match mesh.depth_below_surface(point, |_| true) {
            Some((depth, size)) => (depth, Some(size)),
            None => (0.0, None),
        }
    }

    /// Bounding box outside which no point of another side can be inside [m].
    pub fn bounds(&self) -> [Vec3; 2] {
        match self {
            Self::Mesh(mesh) => mesh.bounds,
            Self::Rigid(shape, pose) => {
                [-1.0, 1.0].map(|sign| pose.centre.add_scalar(sign * shape.outer_radius()))
            }
            Self::Plane(..) => [f64::NEG_INFINITY, f64::INFINITY].map(Vec3::repeat),
        }
    }

    /// Whether this is a plane, and a box lies wholly above it.
    pub fn is_below(&self, [low, high]: &[Vec3; 2]) -> bool {
        let Self::Plane(at, normal) = self else { return false };
        let lowest = Vec3::from_fn(|i, _| if normal[i] > 0.0 { low[i] } else { high[i] });
        normal.dot(&(lowest - at)) > 0.0
    }

    /// Visits points of its surface.
    pub fn for_each_surface_point(&self, mut take: impl FnMut(&Vec3)) {
        match self {
            Self::Mesh(mesh) => {
                for &node in &mesh.surface.nodes {
                    take(&mesh.x[node as usize]);
                }
            }
            Self::Rigid(shape, pose) => {
                let (vertices, triangles) = triangulated(shape);
                for vertex in &vertices {
                    take(&pose.place(vertex));
                }
                for triangle in triangles {
                    let [a, b, c] = triangle.map(|i| vertices[i as usize]);
                    for sum in [a + b, b + c, c + a] {
                        take(&pose.place(&(sum * 0.5)));
                    }
                }
            }
            Self::Plane(..) => {}
        }
    }
}

/// Half-extents of the bounding box of a shape, in its own axes [m].
pub(super) fn half_extents(shape: &Shape) -> Vec3 {
    match *shape {
        Shape::Ball { radius } => Vec3::repeat(radius),
        Shape::Box { half } => half,
        Shape::Cylinder { radius, half_length } => Vec3::new(radius, half_length, radius),
        Shape::Capsule { radius, half_length } => Vec3::new(radius, half_length + radius, radius),
        Shape::Polyhedron(ref hull) => hull.half_extent(&Mat3::identity()),
    }
}
