//! Rigid bodies initially inside meshes: detection only searches near the boundary surface, so it misses a body far below
//! it.

use crate::mechanics::contact::Surface;
use crate::mechanics::tensor::Vec3;
use std::f64::consts::PI;

/// Whether a point lies inside a closed surface: the solid angle of the surface seen from the point is 4π inside, and 0
/// outside and in cavities (Van Oosterom & Strackee 1983). `x`: positions of the nodes [m].
pub fn is_inside(surface: &Surface, x: &[Vec3], point: &Vec3) -> bool {
    let angle_of = |[a, b, c]: [Vec3; 3]| {
        let (na, nb, nc) = (a.norm(), b.norm(), c.norm());
        let under = na * nb * nc + a.dot(&b) * nc + b.dot(&c) * na + c.dot(&a) * nb;
        2.0 * a.dot(&b.cross(&c)).atan2(under)
    };
    let of_face = |face: &[u32; 4]| {
        let [a, b, c, d] = face.map(|node| x[node as usize] - point);
        angle_of([a, b, c]) + angle_of([a, c, d])
    };
    surface.faces.iter().map(of_face).sum::<f64>().abs() > 2.0 * PI
}
