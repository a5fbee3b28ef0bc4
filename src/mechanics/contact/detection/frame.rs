//! The local frame of a contact.

use crate::tensor::Vec3;

/// Largest component of a unit vector that is rounding.
const ROUNDING: f64 = 1e-13;

/// Right-handed orthonormal (n, t1, t2), t1 as close to `along` as possible; arbitrary if that is parallel to the
/// normal or zero.
///
/// Components that are rounding are zeros: the nodes of a plane of symmetry cannot move along its normal, and a tangent that is almost that
/// normal would have almost no compliance, which no solver copes with.
pub(super) fn local_frame(normal: &Vec3, along: &Vec3) -> [Vec3; 3] {
    let exact = |v: Vec3| v.map(|c| if c.abs() < ROUNDING { 0.0 } else { c });
    let normal = &exact(*normal);
    let flat = |v: &Vec3| v - normal * normal.dot(v);
    let mut t1 = flat(along);
    if t1.norm_squared() <= 1e-12 * along.norm_squared() {
        let axis = Vec3::ith(normal.iamin(), 1.0);
        t1 = flat(&axis);
    }
    let t1 = exact(t1.normalize());
    [*normal, t1, exact(normal.cross(&t1))]
}
