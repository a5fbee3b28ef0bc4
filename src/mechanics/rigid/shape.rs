//! Shapes of rigid bodies about their centre of mass: volume, inertia, signed distance, points that may touch a plane.

use super::polyhedron::Polyhedron;
use crate::tensor::{Mat3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// A convex shape about its centre; lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A ball about the centre of mass.
    Ball {
        /// Radius of the ball [m].
        radius: f64,
    },
    /// A box along the axes of the body.
    Box {
        /// Half of each edge [m].
        half: Vec3,
    },
    /// A cylinder with flat ends, its axis along y.
    Cylinder {
        /// Radius of its cross-section [m].
        radius: f64,
        /// Half of its length [m].
        half_length: f64,
    },
    /// A cylinder with round ends, its axis along y.
    Capsule {
        /// Radius of the cross-section and of the ends [m].
        radius: f64,
        /// Half of the distance between the centres of its ends [m].
        half_length: f64,
    },
    /// The hull of a triangulated surface.
    Polyhedron(Arc<Polyhedron>),
}

impl Shape {
    /// Name of the shape in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ball { .. } => "ball",
            Self::Box { .. } => "box",
            Self::Cylinder { .. } => "cylinder",
            Self::Capsule { .. } => "capsule",
            Self::Polyhedron(_) => "polyhedron",
        }
    }

    /// Volume of the body [m³]: that inside its surface, of a polyhedron inside the surface that it is the hull of.
    pub fn volume(&self) -> f64 {
        match *self {
            Self::Ball { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Self::Box { half } => 8.0 * half.product(),
            Self::Cylinder { radius, half_length } => 2.0 * PI * radius * radius * half_length,
            Self::Capsule { radius, half_length } => {
                PI * radius * radius * (2.0 * half_length + 4.0 / 3.0 * radius)
            }
            Self::Polyhedron(ref hull) => hull.volume(),
        }
    }

    /// Principal moments of inertia per mass, of a homogeneous body [m²].
    pub fn inertia_per_mass(&self) -> Vec3 {
        match *self {
            Self::Ball { radius } => Vec3::repeat(0.4 * radius * radius),
            Self::Box { half } => {
                let [x, y, z] = [half.x, half.y, half.z].map(|a| a * a / 3.0);
                Vec3::new(y + z, z + x, x + y)
            }
            Self::Cylinder { radius, half_length } => {
                let (r2, l2) = (radius * radius, half_length * half_length);
                Vec3::new(r2 / 4.0 + l2 / 3.0, r2 / 2.0, r2 / 4.0 + l2 / 3.0)
            }
            Self::Capsule { radius, half_length } => {
                let (r2, l2) = (radius * radius, half_length * half_length);
                let (middle, ends) = (2.0 * half_length, 4.0 / 3.0 * radius);
                // Each half ball rotates about its own centre of mass, 3/8 r beyond the centre of the end.
                let along = (middle * 0.5 + ends * 0.4) * r2;
                let across =
                    middle * (r2 / 4.0 + l2 / 3.0) + ends * (0.4 * r2 + l2 + 0.75 * radius * half_length);
                Vec3::new(across, along, across) / (middle + ends)
            }
            Self::Polyhedron(ref hull) => hull.inertia_per_mass(),
        }
    }

    /// Radius of the circumscribed ball [m].
    pub fn outer_radius(&self) -> f64 {
        match *self {
            Self::Ball { radius } => radius,
            Self::Box { half } => half.norm(),
            Self::Cylinder { radius, half_length } => radius.hypot(half_length),
            Self::Capsule { radius, half_length } => radius + half_length,
            Self::Polyhedron(ref hull) => hull.outer_radius(),
        }
    }

    /// Half extents of the bounding box along the axes of space [m]; `axes` are those of the body, as columns.
    pub fn half_extent(&self, axes: &Mat3) -> Vec3 {
        // For the axis of a cylinder, and for the circle about it.
        let along = axes.column(1).abs();
        let across = along.map(|cosine| (1.0 - cosine * cosine).max(0.0).sqrt());
        match *self {
            Self::Ball { radius } => Vec3::repeat(radius),
            Self::Box { half } => axes.abs() * half,
            Self::Cylinder { radius, half_length } => along * half_length + across * radius,
            Self::Capsule { radius, half_length } => (along * half_length).add_scalar(radius),
            Self::Polyhedron(ref hull) => hull.half_extent(axes),
        }
    }

    /// The length that tolerances refer to: the smallest thickness [m].
    pub fn size(&self) -> f64 {
        match *self {
            Self::Ball { radius } | Self::Capsule { radius, .. } => 2.0 * radius,
            Self::Box { half } => 2.0 * half.min(),
            Self::Cylinder { radius, half_length } => 2.0 * radius.min(half_length),
            Self::Polyhedron(ref hull) => hull.thickness(),
        }
    }

    /// Signed distance of a point from the surface [m], negative inside, and the outward unit normal at the closest point
    /// of the surface; `p` in the axes of the body [m].
    ///
    /// In closed form, since a projection alone (parry's) provides no normal for a point on the surface.
    pub fn eval_distance(&self, p: &Vec3) -> (f64, Vec3) {
        match *self {
            Self::Ball { radius } => from_core(p, radius),
            Self::Capsule { radius, half_length } => {
                let on_axis = Vec3::new(0.0, p.y.clamp(-half_length, half_length), 0.0);
                from_core(&(p - on_axis), radius)
            }
            Self::Box { half } => from_slabs(&Vec3::from_fn(|i, _| p[i].abs() - half[i]), &p.map(sign_of)),
            Self::Cylinder { radius, half_length } => {
                // In the half plane through the axis and the point the section is a rectangle.
                let across = Vec3::new(p.x, 0.0, p.z);
                let distance = across.norm();
                let outwards = if distance > 0.0 { across / distance } else { Vec3::x() };
                let beyond = Vec3::new(distance - radius, p.y.abs() - half_length, f64::NEG_INFINITY);
                let (d, n) = from_slabs(&beyond, &Vec3::new(1.0, sign_of(p.y), 0.0));
                (d, outwards * n.x + Vec3::y() * n.y)
            }
            Self::Polyhedron(ref hull) => hull.eval_distance(p),
        }
    }

    /// The points that may be first to touch a plane, including the lowest of the body, in its axes [m]: `down` is
    /// the unit direction into the plane. Always the same number in the same order, so that those of two poses
    /// correspond.
    pub fn feet(&self, down: &Vec3) -> Feet<'_> {
        let mut feet = Feet { points: [Vec3::zeros(); Feet::MOST], count: 0, corners: &[] };
        match *self {
            Self::Ball { radius } => feet.push(down * radius),
            Self::Box { half } => {
                for corner in 0..8 {
                    feet.push(Vec3::from_fn(|i, _| if corner >> i & 1 == 0 { -half[i] } else { half[i] }));
                }
            }
            Self::Capsule { radius, half_length } => {
                for end in [-half_length, half_length] {
                    feet.push(Vec3::y() * end + down * radius);
                }
            }
            Self::Cylinder { radius, half_length } => {
                let across = Vec3::new(down.x, 0.0, down.z).try_normalize(FLAT).unwrap_or_else(Vec3::x);
                let beside = Vec3::y().cross(&across);
                for end in [-half_length, half_length] {
                    for rim in [across, beside, -across, -beside] {
                        feet.push(Vec3::y() * end + rim * radius);
                    }
                }
            }
            Self::Polyhedron(ref hull) => feet.corners = hull.corners(),
        }
        feet
    }
}

/// Points of a shape that may touch a plane.
#[derive(Clone, Copy, Debug)]
pub struct Feet<'a> {
    points: [Vec3; Feet::MOST],
    count: usize,
    /// Corners of a polyhedron; empty for other shapes.
    corners: &'a [Vec3],
}

impl Feet<'_> {
    /// Largest number of points of a shape other than a polyhedron.
    const MOST: usize = 8;

    fn push(&mut self, point: Vec3) {
        self.points[self.count] = point;
        self.count += 1;
    }

    /// Positions in the axes of the body [m].
    pub fn points(&self) -> &[Vec3] {
        if self.corners.is_empty() { &self.points[..self.count] } else { self.corners }
    }
}

/// Deviation from upright below which a cylinder stands on its end, where all directions across are equally low.
const FLAT: f64 = 1e-12;

/// Sign of x: 1 or −1, and 1 for zero of either sign.
fn sign_of(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// Distance and normal of a round shape, from `p` relative to the nearest point of its core.
fn from_core(p: &Vec3, radius: f64) -> (f64, Vec3) {
    let distance = p.norm();
    (distance - radius, if distance > 0.0 { p / distance } else { Vec3::x() })
}

/// Distance and normal of a shape bounded by planes: how far `beyond` each pair of them the point is, and on which
/// side.
fn from_slabs(beyond: &Vec3, side: &Vec3) -> (f64, Vec3) {
    let outside = beyond.sup(&Vec3::zeros());
    let distance = outside.norm();
    if distance > 0.0 {
        return (distance, outside.component_mul(side) / distance);
    }
    let nearest = beyond.imax();
    (beyond[nearest], Vec3::ith(nearest, side[nearest]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 4] = [
        Shape::Ball { radius: 0.7 },
        Shape::Box { half: Vec3::new(0.3, 0.5, 0.9) },
        Shape::Cylinder { radius: 0.4, half_length: 0.6 },
        Shape::Capsule { radius: 0.4, half_length: 0.6 },
    ];

    /// Points of a cube about the origin, on a fine grid.
    fn grid(n: i32) -> impl Iterator<Item = Vec3> {
        let at = move |i: i32| 1.1 * (2.0 * f64::from(i) + 1.0 - f64::from(n)) / f64::from(n);
        (0..n)
            .flat_map(move |i| (0..n).flat_map(move |j| (0..n).map(move |k| Vec3::new(at(i), at(j), at(k)))))
    }

    #[test]
    fn volume_and_inertia_are_those_of_the_points_inside() {
        let n = 110;
        let cell = (2.2 / f64::from(n)).powi(3);
        for shape in SHAPES {
            let (mut volume, mut inertia) = (0.0, Vec3::zeros());
            for p in grid(n).filter(|p| shape.eval_distance(p).0 < 0.0) {
                volume += cell;
                let s = p.component_mul(&p);
                inertia += Vec3::new(s.y + s.z, s.z + s.x, s.x + s.y) * cell;
            }
            assert!((volume / shape.volume() - 1.0).abs() < 0.01, "{shape:?}: {volume}");
            let error = (inertia / volume).component_div(&shape.inertia_per_mass()).add_scalar(-1.0);
            assert!(error.amax() < 0.01, "{shape:?}: {error}");
        }
    }

    #[test]
    fn the_distance_leads_to_the_surface_along_the_normal() {
        for shape in SHAPES {
            for p in grid(9) {
                let (d, n) = shape.eval_distance(&p);
                assert!((n.norm() - 1.0).abs() < 1e-12);
                let (left, _) = shape.eval_distance(&(p - n * d));
                assert!(left.abs() < 1e-12, "{shape:?} {p}: {left}");
                assert!(p.norm() - d <= shape.outer_radius() + 1e-12);
            }
        }
    }

    #[test]
    fn the_box_around_a_turned_shape_is_as_large_as_the_shape() {
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.4, -1.1, 2.3);
        let axes = turn.to_rotation_matrix().into_inner();
        for shape in SHAPES {
            let half = shape.half_extent(&axes);
            for axis in 0..3 {
                // The lowest foot is the lowest point of the shape.
                let down = turn.inverse_transform_vector(&Vec3::ith(axis, 1.0));
                let feet = shape.feet(&down);
                let farthest = feet.points().iter().map(|foot| down.dot(foot)).fold(0.0, f64::max);
                assert!((half[axis] - farthest).abs() < 1e-12, "{shape:?}, axis {axis}");
            }
        }
    }

    #[test]
    fn the_lowest_foot_is_the_lowest_point() {
        for shape in SHAPES {
            for down in grid(6).map(|p| p.normalize()) {
                let feet = shape.feet(&down);
                assert!(feet.points().iter().all(|foot| shape.eval_distance(foot).0 < 1e-12));
                let lowest =
                    feet.points().iter().map(|foot| down.dot(foot)).fold(f64::NEG_INFINITY, f64::max);
                // No point of the surface is lower.
                for p in grid(9) {
                    let (d, n) = shape.eval_distance(&p);
                    assert!(down.dot(&(p - n * d)) <= lowest + 1e-12, "{shape:?} {down}");
                }
            }
        }
    }
}
