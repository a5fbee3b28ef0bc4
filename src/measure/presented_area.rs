//! Area presented by a projectile in its direction of flight, and its energy.

use crate::mechanics::rigid::Shape;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::scene::document::Role;
use std::f64::consts::PI;

/// Kinetic energy and presented area of the projectile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onslaught {
    /// ½ m v², with v the speed of flight relative to the tissue [J].
    pub kinetic_energy: f64,
    /// Area of the convex hull of its outline, seen along that velocity [m²].
    pub presented_area: f64,
}

impl Onslaught {
    /// For a plan with exactly one projectile and one body of tissue; `None` otherwise, or if nothing moves.
    pub fn new(plan: &Plan) -> Option<Self> {
        let one = |role: Role| {
            let mut found = (0..plan.bodies.len()).filter(|&b| plan.bodies[b].role == role);
            found.next().filter(|_| found.next().is_none())
        };
        let (projectile, tissue) = (one(Role::Projectile)?, one(Role::Tissue)?);
        let body = &plan.bodies[projectile];
        let velocity = body.flight_velocity - plan.bodies[tissue].flight_velocity;
        let direction = velocity.try_normalize(0.0)?;
        let presented_area = match (body.rigid, &plan.rigid) {
            (Some(index), Some(rigid)) => shape_area(
                &rigid.bodies[index].shape,
                &rigid.orientations[index].inverse_transform_vector(&direction),
            ),
            _ => hull_area(&body.boundary.nodes, &plan.X, &direction),
        };
        Some(Self { kinetic_energy: 0.5 * body.mass * velocity.norm_squared(), presented_area })
    }

    /// Kinetic energy over presented area [J/m²].
    pub fn energy_density(&self) -> f64 {
        self.kinetic_energy / self.presented_area
    }

    /// Diameter of a disc of that area [m].
    pub fn diameter(&self) -> f64 {
        2.0 * (self.presented_area / PI).sqrt()
    }
}

/// Projected area of a shape along a unit direction in its own axes [m²].
fn shape_area(shape: &Shape, direction: &Vec3) -> f64 {
    let along = direction.y.abs();
    let across = (1.0 - along * along).max(0.0).sqrt();
    match *shape {
        Shape::Ball { radius } => PI * radius * radius,
        Shape::Box { half } => {
            let d = direction.abs();
            4.0 * (d.x * half.y * half.z + d.y * half.z * half.x + d.z * half.x * half.y)
        }
        Shape::Cylinder { radius, half_length } => {
            PI * radius * radius * along + 4.0 * radius * half_length * across
        }
        Shape::Capsule { radius, half_length } => PI * radius * radius + 4.0 * radius * half_length * across,
        Shape::Polyhedron(ref hull) => {
            let corners: Vec<u32> = (0..hull.corners().len() as u32).collect();
            hull_area(&corners, hull.corners(), direction)
        }
    }
}

/// Area of the convex hull of nodes projected along a unit direction [m²]: the monotone chain of Andrew (1979).
fn hull_area(nodes: &[u32], X: &[Vec3], direction: &Vec3) -> f64 {
    let axis = if direction.x.abs() < 0.5 { Vec3::x() } else { Vec3::y() };
    let e1 = direction.cross(&axis).normalize();
    let e2 = direction.cross(&e1);
    let mut points: Vec<[f64; 2]> =
        nodes.iter().map(|&a| [X[a as usize].dot(&e1), X[a as usize].dot(&e2)]).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn =
        |o: [f64; 2], a: [f64; 2], b: [f64; 2]| (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut hull: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while hull.len() >= 2 && turn(hull[hull.len() - 2], hull[hull.len() - 1], point) <= 0.0 {
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    let next = hull.iter().cycle().skip(1);
    hull.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shadows_of_shapes() {
        let cube = Shape::Box { half: Vec3::repeat(0.5) };
        assert!((shape_area(&cube, &Vec3::z()) - 1.0).abs() < 1e-12);
        // A regular hexagon of area √3.
        assert!((shape_area(&cube, &Vec3::repeat(1.0).normalize()) - 3.0_f64.sqrt()).abs() < 1e-12);
        let corners: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)))
            .collect();
        let nodes: Vec<u32> = (0..8).collect();
        assert!((hull_area(&nodes, &corners, &Vec3::repeat(1.0).normalize()) - 3.0_f64.sqrt()).abs() < 1e-12);
        assert!((hull_area(&nodes, &corners, &-Vec3::x()) - 1.0).abs() < 1e-12);
        let baton = Shape::Capsule { radius: 1.0, half_length: 2.0 };
        assert!((shape_area(&baton, &Vec3::y()) - PI).abs() < 1e-12);
        assert!((shape_area(&baton, &Vec3::x()) - (PI + 8.0)).abs() < 1e-12);
    }
}
