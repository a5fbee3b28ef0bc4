//! Winding number of a closed surface around a point: 0 outside, 1 inside, 2 where two of its parts overlap.
//!
//! Along a ray from the point each exit counts 1 and each entry −1. Faces are two triangles, projected along a
//! coordinate axis; the side of the ray on which an edge lies is computed by the same arithmetic for both of its
//! triangles, so none is counted twice or missed.

use super::boundary::Boundary;
use super::broad_phase::FaceTree;
use crate::contact::Surface;
use crate::tensor::Vec3;

/// Distance from a node along its normal, as a fraction of the mean face size, at which a place is outside the node's
/// surroundings.
const BESIDE: f64 = 1e-6;

/// Nodes of a closed surface that lie inside the volume that it encloses, at positions `x` [m] of all nodes, with the
/// surface's normals there: the surface winds around the place just outside them.
pub fn nodes_inside(surface: &Surface, x: &[Vec3]) -> Vec<(u32, Vec3)> {
    let boundary = Boundary::new(surface, x);
    let (tree, beside) = (FaceTree::new(&boundary, x), BESIDE * boundary.mean_size);
    let inside = |&node: &u32| {
        let normal = boundary.node_normal(node, x);
        let place = x[node as usize] + normal * beside;
        let count = winding_number(&boundary, &tree, (&place, &normal), (x, &Vec3::zeros()));
        (count > 0).then_some((node, normal))
    };
    surface.nodes.iter().filter_map(inside).collect()
}

/// Winding number around `point` [m] of the surface of `tree`, at positions `x` [m] that are `shift` [m] from those
/// of the tree, within its slack. The ray is along the axis nearest to `towards`.
pub(super) fn winding_number(
    boundary: &Boundary,
    tree: &FaceTree,
    (point, towards): (&Vec3, &Vec3),
    (x, shift): (&[Vec3], &Vec3),
) -> i32 {
    // Off the planes of symmetry, where the surface ends.
    let beside = BESIDE * boundary.mean_size;
    let inwards = boundary.mirrors.map(|mirror| mirror.map_or(0.0, |_| beside));
    let point = &(point + Vec3::from(inwards));
    let axis = towards.iamax();
    // Any ray does; one that meets no plane of symmetry meets no mirror image.
    let sign = if towards[axis] < 0.0 && boundary.mirrors[axis].is_none() { -1.0 } else { 1.0 };
    // Seen against the ray, right-handed: across, up, along.
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
        let [a, b, c, d] = boundary.faces[face as usize].map(seen);
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
    // Height of the triangle on the ray, times twice its projected area.
    let height = cross(&b, &c) * a[2] + cross(&c, &a) * b[2] + cross(&a, &b) * c[2];
    if height * f64::from(around) > 0.0 { around } else { 0 }
}
