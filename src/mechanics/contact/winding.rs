//! How many times a closed surface winds around a point: 0 outside, 1 inside, 2 where two of its parts lie in each other.
//!
//! Along a ray from the point each way out counts 1 and each way in −1. Faces are two triangles, seen along an axis of space; an
//! edge is on one side of the ray or the other by the same arithmetic for both of its triangles, so none is counted twice or missed.

use super::broad_phase::FaceTree;
use super::skin::Skin;
use crate::mechanics::tensor::Vec3;

/// Of the surface of `tree` around `point` [m], at positions `x` [m] that are `shift` [m] from those of the tree, within its
/// slack. The ray is the axis nearest to `towards`.
pub(super) fn winding_number(
    skin: &Skin,
    tree: &FaceTree,
    (point, towards): (&Vec3, &Vec3),
    (x, shift): (&[Vec3], &Vec3),
) -> i32 {
    let axis = towards.iamax();
    let sign = if towards[axis] < 0.0 { -1.0 } else { 1.0 };
    // Looking against the ray, right-handed: across, up, along.
    let (mut across, mut up) = ((axis + 1) % 3, (axis + 2) % 3);
    if sign < 0.0 {
        (across, up) = (up, across);
    }
    let seen = |node: u32| {
        let d = x[node as usize] - point;
        [d[across], d[up], sign * d[axis]]
    };
    let mut count = 0;
    for face in tree.ahead(&(point - shift), axis, sign) {
        let [a, b, c, d] = skin.faces[face as usize].map(seen);
        count += passage([a, b, c]) + passage([a, c, d]);
    }
    count
}

/// 1 where the ray leaves through the triangle, −1 where it enters, else 0.
fn passage([a, b, c]: [[f64; 3]; 3]) -> i32 {
    let cross = |p: &[f64; 3], q: &[f64; 3]| p[0] * q[1] - p[1] * q[0];
    let turn = |p: &[f64; 3], q: &[f64; 3]| match (p[1] > 0.0, q[1] > 0.0) {
        (false, true) => i32::from(cross(p, q) > 0.0),
        (true, false) => -i32::from(cross(p, q) < 0.0),
        _ => 0,
    };
    let around = turn(&a, &b) + turn(&b, &c) + turn(&c, &a);
    if around == 0 {
        return 0;
    }
    // Height where the ray passes, times twice the area seen.
    let height = cross(&b, &c) * a[2] + cross(&c, &a) * b[2] + cross(&a, &b) * c[2];
    if height * f64::from(around) > 0.0 { around } else { 0 }
}
