//! Intersection of lines with the shape of a rigid body.

use super::shape::Shape;
use crate::tensor::Vec3;

/// Component of a unit direction below which the line is parallel to a plane.
const PARALLEL: f64 = 1e-12;

impl Shape {
    /// Whether the line through a point `p` [m] along the unit vector `d` intersects the shape, both in the axes of
    /// the body.
    pub fn is_met_by_line(&self, p: &Vec3, d: &Vec3) -> bool {
        match *self {
            Self::Ball { radius } => p.cross(d).norm() <= radius,
            Self::Capsule { radius, half_length } => {
                // The distance of a point y of the axis from the line is |p × d − y e_y × d|.
                let (moment, across) = (p.cross(d), Vec3::y().cross(d));
                let nearest = moment.dot(&across) / across.norm_squared().max(PARALLEL);
                (moment - across * nearest.clamp(-half_length, half_length)).norm() <= radius
            }
            Self::Box { half } => {
                let along = (0..3).map(|axis| between_planes(p[axis], d[axis], half[axis]));
                meet(along)
            }
            Self::Cylinder { radius, half_length } => {
                meet([between_planes(p.y, d.y, half_length), in_circle([p.x, p.z], [d.x, d.z], radius)])
            }
            Self::Polyhedron(ref hull) => hull.is_met_by_line(p, d),
        }
    }
}

/// Whether intervals of a line have a point in common.
fn meet(stretches: impl IntoIterator<Item = [f64; 2]>) -> bool {
    let [low, high] = stretches
        .into_iter()
        .fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], [from, to]| [low.max(from), high.min(to)]);
    low <= high
}

const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
const NOWHERE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// The interval of a line in which a coordinate is within ±`half`.
fn between_planes(p: f64, d: f64, half: f64) -> [f64; 2] {
    if d.abs() < PARALLEL {
        return if p.abs() <= half { EVERYWHERE } else { NOWHERE };
    }
    let ends = [(-half - p) / d, (half - p) / d];
    [ends[0].min(ends[1]), ends[0].max(ends[1])]
}

/// The interval of a line in which two coordinates are within a circle about the origin.
fn in_circle(p: [f64; 2], d: [f64; 2], radius: f64) -> [f64; 2] {
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let (dd, pd, excess) = (dot(d, d), dot(p, d), dot(p, p) - radius * radius);
    if dd < PARALLEL * PARALLEL {
        return if excess <= 0.0 { EVERYWHERE } else { NOWHERE };
    }
    let discriminant = pd * pd - dd * excess;
    if discriminant < 0.0 {
        return NOWHERE;
    }
    let root = discriminant.sqrt();
    [(-pd - root) / dd, (-pd + root) / dd]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_meets_a_shape_where_one_of_its_points_is_inside() {
        let shapes = [
            Shape::Ball { radius: 0.7 },
            Shape::Box { half: Vec3::new(0.3, 0.5, 0.9) },
            Shape::Cylinder { radius: 0.4, half_length: 0.6 },
            Shape::Capsule { radius: 0.4, half_length: 0.6 },
        ];
        let directions = [Vec3::x(), Vec3::y(), Vec3::z(), Vec3::new(0.3, -0.8, 0.5).normalize()];
        for (shape, d) in shapes.iter().flat_map(|shape| directions.map(|d| (shape, d))) {
            let (mut met, mut missed) = (0, 0);
            for i in 0..400 {
                let at = |k: u32| 2.4 * (f64::from(i * k + 7) * 0.618_034).fract() - 1.2;
                let p = Vec3::new(at(1), at(13), at(57));
                // The distance to a convex shape has a single minimum along a line; lines near the rim are omitted.
                let depth = |s: f64| shape.eval_distance(&(p + d * s)).0;
                let least = (-300..300).map(|s| depth(0.01 * f64::from(s))).fold(f64::INFINITY, f64::min);
                if least.abs() > 0.01 {
                    assert_eq!(shape.is_met_by_line(&p, &d), least < 0.0, "{shape:?} {p} {d}");
                    *(if least < 0.0 { &mut met } else { &mut missed }) += 1;
                }
            }
            assert!(met > 20 && missed > 20, "{shape:?} {d}: {met} {missed}");
        }
    }
}
