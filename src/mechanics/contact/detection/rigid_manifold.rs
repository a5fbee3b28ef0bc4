//! Contact points of two convex shapes that touch or nearly touch, by parry; glam's vectors are confined to this
//! file.

use crate::rigid::{Pose, Shape};
use crate::tensor::Vec3;
use parry3d_f64::math::{Pose as ParryPose, Rotation as ParryRotation, Vector};
use parry3d_f64::query::{
    ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, TrackedContact, distance,
};
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder, SharedShape};

/// Largest number of points of one pair: two clipped quadrilaterals, and the closest point.
pub const MOST_POINTS: usize = 20;

/// Distance, as a fraction of the reach, below which two points coincide.
const SAME: f64 = 1e-6;

/// A contact point of two shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// Midway between both surfaces [m].
    pub point: Vec3,
    /// Unit normal out of the second shape.
    pub normal: Vec3,
    /// Distance of the surfaces along the normal, negative where they overlap [m].
    pub gap: f64,
}

/// Finds the contact points; only memory persists between calls, so the same poses give the same bits.
#[derive(Default)]
pub(super) struct ManifoldFinder {
    manifolds: Vec<ContactManifold<(), ()>>,
}

impl ManifoldFinder {
    /// Calls `take` with the contact points of `a` and `b` within `reach` [m] of each other.
    pub fn find(
        &mut self,
        (a, at): (&SharedShape, &Pose),
        (b, bt): (&SharedShape, &Pose),
        reach: f64,
        mut take: impl FnMut(Touch),
    ) {
        for manifold in &mut self.manifolds {
            // The previous result would be taken as an initial guess.
            manifold.points.clear();
            (manifold.local_n1, manifold.local_n2) = (Vector::ZERO, Vector::ZERO);
        }
        let between = to_parry(at).inv_mul(&to_parry(bt));
        let found = DefaultQueryDispatcher.contact_manifolds(
            &between,
            &*a.0,
            &*b.0,
            reach,
            &mut self.manifolds,
            &mut None,
        );
        debug_assert!(found.is_ok(), "all shapes are convex");
        for manifold in &self.manifolds {
            let normal = -(at.orientation * from_parry(manifold.local_n1));
            let points = &manifold.points;
            for (i, point) in points.iter().enumerate().filter(|(_, p)| p.dist <= reach).take(MOST_POINTS) {
                // Corners on corners or edges appear several times: one suffices.
                let is_same =
                    |other: &TrackedContact<()>| (other.local_p1 - point.local_p1).length() <= SAME * reach;
                if !points[..i].iter().any(is_same) {
                    let [on_a, on_b] =
                        [at.place(&from_parry(point.local_p1)), bt.place(&from_parry(point.local_p2))];
                    take(Touch { point: (on_a + on_b) * 0.5, normal, gap: point.dist });
                }
            }
        }
    }
}

/// Distance of the surfaces of two shapes [m]; 0 where they overlap.
pub(super) fn shape_distance((a, at): (&SharedShape, &Pose), (b, bt): (&SharedShape, &Pose)) -> f64 {
    distance(&to_parry(at), &*a.0, &to_parry(bt), &*b.0).map_or(0.0, |found| found.distance)
}

/// The shape in parry's representation.
pub(super) fn parry_shape(shape: &Shape) -> SharedShape {
    match *shape {
        Shape::Ball { radius } => SharedShape::new(Ball::new(radius)),
        Shape::Box { half } => SharedShape::new(Cuboid::new(vector(&half))),
        Shape::Cylinder { radius, half_length } => SharedShape::new(Cylinder::new(half_length, radius)),
        Shape::Capsule { radius, half_length } => SharedShape::new(Capsule::new_y(half_length, radius)),
        Shape::Polyhedron(ref hull) => SharedShape::new(hull.parry().clone()),
    }
}

fn to_parry(pose: &Pose) -> ParryPose {
    let q = pose.orientation.coords;
    ParryPose::from_parts(vector(&pose.centre), ParryRotation::from_xyzw(q.x, q.y, q.z, q.w))
}

fn vector(v: &Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn from_parry(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}
