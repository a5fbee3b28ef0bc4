//! The surface of a shape as triangles, to be looked at; parry makes them.

use super::Shape;
use crate::mechanics::tensor::Vec3;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder};

/// Divisions around a circle, and along a quarter or half of one.
const AROUND: u32 = 32;
const ALONG: u32 = 16;

/// Vertices in the axes of the body [m], and the corners of the triangles, counter-clockwise seen from outside.
///
/// Vertices lie on the surface, so a round shape is drawn a little too small: by 0.5 % of its radius at most.
pub fn triangulated(shape: &Shape) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (vertices, triangles) = match *shape {
        Shape::Ball { radius } => Ball::new(radius).to_trimesh(AROUND, ALONG),
        Shape::Box { half } => Cuboid::new(Vector::new(half.x, half.y, half.z)).to_trimesh(),
        Shape::Cylinder { radius, half_length } => Cylinder::new(half_length, radius).to_trimesh(AROUND),
        Shape::Capsule { radius, half_length } => {
            Capsule::new_y(half_length, radius).to_trimesh(AROUND, ALONG)
        }
    };
    (vertices.into_iter().map(|v| Vec3::new(v.x, v.y, v.z)).collect(), triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_triangles_enclose_nearly_the_volume_and_are_turned_outwards() {
        let shapes = [
            Shape::Ball { radius: 0.7 },
            Shape::Box { half: Vec3::new(0.3, 0.5, 0.9) },
            Shape::Cylinder { radius: 0.4, half_length: 0.6 },
            Shape::Capsule { radius: 0.4, half_length: 0.6 },
        ];
        for shape in shapes {
            let (x, triangles) = triangulated(&shape);
            assert!(x.iter().all(|x| shape.eval_distance(x).0.abs() < 1e-9), "{shape:?}");
            let of_triangle = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|i| x[i as usize]);
                a.dot(&b.cross(&c)) / 6.0
            };
            let volume: f64 = triangles.iter().map(of_triangle).sum();
            assert!(volume < shape.volume() * 1.001 && volume > 0.97 * shape.volume(), "{shape:?}: {volume}");
        }
    }
}
