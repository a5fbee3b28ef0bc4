//! The local frame of a contact.

use crate::tensor::Vec3;

/// Right-handed orthonormal (n, t1, t2), t1 as close to `along` as possible; arbitrary if that is parallel to the
/// normal or zero.
pub(super) fn local_frame(normal: &Vec3, along: &Vec3) -> [Vec3; 3] {
    let flat = |v: &Vec3| v - normal * normal.dot(v);
    let mut t1 = flat(along);
    if t1.norm_squared() <= 1e-12 * along.norm_squared() {
        let axis = Vec3::ith(normal.iamin(), 1.0);
        t1 = flat(&axis);
    }
    let t1 = t1.normalize();
    [*normal, t1, normal.cross(&t1)]
}
