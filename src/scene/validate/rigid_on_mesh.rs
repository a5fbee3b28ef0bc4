//! Rigid bodies inside meshes before anything has moved: detection looks at the skin of a mesh, so a body that lies far below it is not
//! seen by it.

use crate::mechanics::contact::Surface;
use crate::mechanics::tensor::Vec3;
use std::f64::consts::PI;

/// Whether a point lies inside a closed surface: the solid angle that the surface fills around it is 4π, and 0 outside and in
/// cavities (Van Oosterom & Strackee 1983). `x` [m] places of the nodes.
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
