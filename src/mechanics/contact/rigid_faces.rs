//! Faces of a mesh against a rigid body, between their nodes.
//!
//! The nodes are kept out of the shape itself. A face may enter it by [`ALLOWED`] of its size, and by the height of the cap that
//! a round shape has between nodes that lie on it: so faces that are small against the shape are held by their nodes alone. What
//! it is kept out of is a *core*, the shape less twice that on every side, at the distance of once that: the direction away from
//! the core is unique also at edges and corners of a box. So no body passes between the nodes, however small it is.
//!
//! A face that moves far within a step is followed along its way by steps of its distance, as nodes are: nothing tunnels.

use super::closest_point::{Feature, Patch};
use super::detection::NEAR;
use crate::mechanics::rigid::Shape;
use crate::mechanics::tensor::Vec3;

/// How deep a shape may be in a face, in shares of the face's size, without what is due to its curvature.
const ALLOWED: f64 = 0.01;
/// The same in all, at most, in shares of the shape's thickness.
const MOST: f64 = 0.2;
/// Projections in turn onto the core and onto the face.
const TURNS: usize = 60;
/// Steps along the way of a face.
const MARCH: usize = 100;
/// A face this share of its size from what it must not enter has met it.
const MET: f64 = 1e-6;

/// Where a face comes too near to a body, in the axes of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FaceTouch {
    /// Share of the step at which the face is taken: 0, or that of the impact.
    pub share: f64,
    /// Shape functions of the place on the face.
    pub weights: [f64; 4],
    /// Unit normal out of the body.
    pub normal: Vec3,
    /// Gap at the start of the step along the normal [m].
    pub gap: f64,
    /// Place on the face at that share [m].
    pub point: Vec3,
}

/// A place of the face that is closest to the core.
struct Closest {
    feature: Feature,
    weights: [f64; 4],
    point: Vec3,
    normal: Vec3,
    distance: f64,
}

/// How deep the shape may be in a face of a size at rest [m].
fn allowed(shape: &Shape, size: f64, face: &Patch) -> f64 {
    let cap = match *shape {
        Shape::Box { .. } => 0.0,
        Shape::Ball { radius } | Shape::Cylinder { radius, .. } | Shape::Capsule { radius, .. } => {
            // The height of a cap whose rim goes through the corners, half a diagonal from its middle.
            let [a, b, c, d] = face.corners;
            let half = 0.5 * (c - a).norm().max((d - b).norm());
            radius - (radius * radius - half * half).max(0.0).sqrt()
        }
    };
    (ALLOWED * size + cap).min(MOST * shape.size())
}

/// The touch of a face of a size [m] at rest that moves from `start` to `end`, both in the axes of the body [m]; `None` if it stays
/// away from the core, or comes nearest with a node.
pub(super) fn touch_of(shape: &Shape, size: f64, start: &Patch, end: &Patch) -> Option<FaceTouch> {
    let round = allowed(shape, size, start);
    let core = shape.eroded(2.0 * round);
    let moved = start.corners.iter().zip(&end.corners).map(|(p, q)| (q - p).norm()).fold(0.0, f64::max);
    // The distance from a convex body is convex: nowhere on the face below that of its tangent plane.
    let middle = start.point(&[0.25; 4]);
    let (distance, normal) = core.eval_distance(&middle);
    let lowest =
        start.corners.iter().map(|c| distance + normal.dot(&(c - middle))).fold(f64::INFINITY, f64::min);
    if lowest - round > moved {
        return None;
    }
    let closest = closest(&core, start);
    let gap = closest.distance - round;
    let change = |weights: &[f64; 4]| end.point(weights) - start.point(weights);
    if gap <= 0.0 || moved <= NEAR * size {
        let closes = gap.min(gap + closest.normal.dot(&change(&closest.weights))) <= 0.0;
        return if closes { closest.touch(0.0, gap) } else { None };
    }
    let mut share = 0.0;
    let mut left = gap;
    for _ in 0..MARCH {
        // No place of the face moves farther than `moved`.
        share += left / moved;
        if share > 1.0 {
            return None;
        }
        let then = between(start, end, share);
        let found = self::closest(&core, &then);
        left = found.distance - round;
        if left <= MET * size {
            let gap = left - found.normal.dot(&change(&found.weights)) * share;
            return found.touch(share, gap);
        }
    }
    None
}

impl Closest {
    /// `None` at a node, which is kept out of the whole shape.
    fn touch(self, share: f64, gap: f64) -> Option<FaceTouch> {
        let Self { feature, weights, point, normal, .. } = self;
        (!matches!(feature, Feature::Corner(_))).then_some(FaceTouch { share, weights, normal, gap, point })
    }
}

fn between(start: &Patch, end: &Patch, share: f64) -> Patch {
    let corners = std::array::from_fn(|k| start.corners[k].lerp(&end.corners[k], share));
    Patch { corners, triangle: start.triangle }
}

/// Projections in turn onto the face and onto the core, which come to the closest points of two convex sets (Cheney & Goldstein
/// 1959); at once for a ball. A face inside the core is told by the place closest to the centre.
fn closest(core: &Shape, face: &Patch) -> Closest {
    let mut towards = Vec3::zeros();
    let mut best: Option<Closest> = None;
    for _ in 0..TURNS {
        let on_face = face.closest(&towards);
        let (distance, normal) = core.eval_distance(&on_face.point);
        let nearer = best.as_ref().is_none_or(|b| distance < b.distance * (1.0 - 1e-9));
        if !nearer {
            break;
        }
        best = Some(Closest {
            feature: on_face.feature,
            weights: on_face.weights,
            point: on_face.point,
            normal,
            distance,
        });
        towards = on_face.point - normal * distance;
        if distance <= 0.0 {
            break;
        }
    }
    best.unwrap_or_else(|| {
        let point = face.point(&[0.25; 4]);
        let (distance, normal) = core.eval_distance(&point);
        Closest { feature: Feature::Interior, weights: [0.25; 4], point, normal, distance }
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    fn square(z: f64) -> Patch {
        let corners = [[-3.0, -2.0], [3.0, -2.0], [3.0, 4.0], [-3.0, 4.0]].map(|[x, y]| Vec3::new(x, y, z));
        Patch { corners, triangle: false }
    }

    #[test]
    fn a_small_body_is_met_in_the_middle_of_a_face_at_any_speed() {
        let shapes = [
            Shape::Ball { radius: 0.5 },
            Shape::Box { half: Vec3::new(0.3, 0.5, 0.5) },
            Shape::Cylinder { radius: 0.4, half_length: 0.5 },
            Shape::Capsule { radius: 0.4, half_length: 0.1 },
        ];
        for shape in shapes {
            let half = shape.outer_radius();
            assert_eq!(touch_of(&shape, 6.0, &square(-half - 0.5), &square(-half - 0.4)), None, "far");
            for far in [1.4, 10.0, 1000.0] {
                let found = touch_of(&shape, 6.0, &square(-1.5), &square(-1.5 + far)).unwrap();
                assert!(found.normal.z < -0.999, "{shape:?}: {}", found.normal);
                let at = -1.5 + found.share * far;
                let (distance, _) = shape.eval_distance(&Vec3::new(0.0, 0.0, at));
                assert!(
                    (distance + allowed(&shape, 6.0, &square(0.0))).abs() < 1e-5,
                    "{shape:?}: {distance}"
                );
            }
        }
    }

    #[test]
    fn the_corner_of_a_box_is_pushed_along_the_normal_of_the_face() {
        // A corner points down; the frame of the box is the turned one of the face.
        let shape = Shape::Box { half: Vec3::repeat(1.0) };
        let down = -Vec3::repeat(1.0).normalize();
        let turn = nalgebra::UnitQuaternion::rotation_between(&-Vec3::z(), &down).unwrap();
        let at = |z: f64| Patch { corners: square(z).corners.map(|c| turn * c), triangle: false };
        let found = touch_of(&shape, 6.0, &at(-1.65), &at(-1.5)).unwrap();
        assert!((found.normal - down).norm() < 0.05, "{}", found.normal);
    }
}
