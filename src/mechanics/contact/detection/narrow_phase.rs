//! Narrow phase: one slave node against the faces near it; distance, sign, and the choice of one face.

use super::boundary::{Across, Boundary};
use super::closest_point::{Feature, Patch};
use crate::tensor::Vec3;
use std::cell::OnceCell;

/// Distance outside a face, as a fraction of its size, within which a node is a candidate: it may close within the
/// step, also when pushed by the reaction of another contact.
pub const NEAR: f64 = 0.05;
/// Depth behind a face, as a fraction of its size, to which a node is held by it without finding the closest face of
/// all. Deeper nodes are held by the closest face, which determines their side; in self-contact there is no such
/// face, and they are not held: a wall that is being crushed comes nearer than its thickness at rest, and its far
/// side must not be taken for a penetration.
pub const DEPTH: f64 = 0.08;
/// Width of the band beyond its border, as a fraction of its size, in which a face is still valid, so that nodes on
/// the edge of a body stay in contact while rounding (or the difference of two lateral strains) moves them across.
pub const BAND: f64 = 0.01;
/// Difference of distances, as a fraction of the size, below which faces are equally close: the most opposed one is
/// taken.
const TIE: f64 = 1e-6;
/// Largest cosine between the normals of slave and face: they must be opposed.
pub(super) const OPPOSED: f64 = -0.02;

/// A node relative to a face, at the closest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::contact) struct Proximity {
    /// Index of the face.
    pub face: u32,
    /// Shape functions at the closest point.
    pub weights: [f64; 4],
    /// Unit normal of the contact, out of the master.
    pub normal: Vec3,
    /// Signed gap along the normal [m].
    pub gap: f64,
    /// Distance of the node from the face [m].
    pub distance: f64,
    /// Whether the closest point is on an edge or a corner and the normal is the direction between it and the node.
    pub beyond: bool,
}

/// Distance and sign of `s` [m] relative to one face, or `None` where the projection is not valid: beyond the border
/// of an open surface, or on the far side of an edge, where the neighbour applies.
pub(in crate::contact) fn eval_proximity(
    boundary: &Boundary,
    face: u32,
    s: &Vec3,
    x: &[Vec3],
) -> Option<Proximity> {
    eval_proximity_within(boundary, face, s, x, f64::INFINITY)
}

/// As [`eval_proximity`]; also `None` where the face is farther than `limit` [m].
pub(super) fn eval_proximity_within(
    boundary: &Boundary,
    face: u32,
    s: &Vec3,
    x: &[Vec3],
    limit: f64,
) -> Option<Proximity> {
    let patch = Patch::new(&boundary.faces[face as usize], x);
    let size = boundary.sizes[face as usize];
    let closest = patch.closest(s);
    let offset = s - closest.point;
    let distance = offset.norm();
    if distance > limit {
        return None;
    }
    let normal = patch.normal(&closest.weights);
    if normal == Vec3::zeros() {
        return None;
    }
    let along = normal.dot(&offset);
    let found = |normal, gap| {
        Some(Proximity { face, weights: closest.weights, normal, gap, distance, beyond: false })
    };
    // The pseudo-normal at an edge or corner determines the side there.
    let (pseudo_normal, border) = match closest.feature {
        Feature::Interior => return found(normal, along),
        Feature::Edge(k) => match boundary.across(face, k) {
            Across::Border => (normal, true),
            Across::Mirror(axis) => (normal - unit(axis) * normal[axis], false),
            Across::Face(other) => (normal + normal_nearest(boundary, other, &closest.point, x), false),
        },
        Feature::Corner(k) => {
            let node = boundary.faces[face as usize][k];
            (boundary.vertex_normal(node, x), boundary.on_border(node))
        }
    };
    // Within the band the plane of the face continues: no jump for a node that slides across its edge.
    if (offset - normal * along).norm() <= BAND * size {
        let outside = pseudo_normal.dot(&offset) >= 0.0;
        // Farther past a sharp edge this plane would give the wrong sign: the neighbour gives the right one.
        let on_plane = along.abs() <= BAND * size;
        return if border || on_plane || (along >= 0.0) == outside { found(normal, along) } else { None };
    }
    if border || distance == 0.0 {
        return None;
    }
    let sign = if pseudo_normal.dot(&offset) >= 0.0 { 1.0 } else { -1.0 };
    let normal = offset * (sign / distance);
    Some(Proximity { face, weights: closest.weights, normal, gap: sign * distance, distance, beyond: true })
}

/// The unit vector along an axis.
fn unit(axis: usize) -> Vec3 {
    Vec3::from_fn(|i, _| if i == axis { 1.0 } else { 0.0 })
}

/// Normal of a face at its point closest to `p`.
fn normal_nearest(boundary: &Boundary, face: u32, p: &Vec3, x: &[Vec3]) -> Vec3 {
    let patch = Patch::new(&boundary.faces[face as usize], x);
    patch.normal(&patch.closest(p).weights)
}

/// The face that holds the node, of those given in ascending order: the closest one within reach and opposed to the
/// slave's own normal (zero: any), and of equally close ones the most opposed. The normal is evaluated only if
/// needed.
///
/// The sign at an edge or a corner is valid only at the closest point of the whole surface. So a node is behind a
/// face only if no other face, whatever its orientation, has it in front and closer.
pub(super) fn choose_face(
    boundary: &Boundary,
    faces: &(impl Iterator<Item = u32> + Clone),
    s: &Vec3,
    slave_normal: impl Fn() -> Vec3,
    x: &[Vec3],
) -> Option<Proximity> {
    let normal = OnceCell::new();
    let mut in_front = f64::INFINITY;
    let mut best = None;
    for face in faces.clone() {
        let Some(p) = eval_within(boundary, face, s, x, best.as_ref()) else { continue };
        // Count only faces within their own reach: others may or may not be listed.
        if p.gap > 0.0 && p.distance <= DEPTH * boundary.sizes[p.face as usize] {
            in_front = in_front.min(p.distance);
        }
        keep_better(boundary, &mut best, p, &normal, &slave_normal);
    }
    // A node behind the best face but in front of a closer one: the best face that has it in front.
    let held = best?;
    if held.gap >= 0.0 || in_front >= held.distance - BAND * boundary.sizes[held.face as usize] {
        return best;
    }
    let mut best = None;
    for face in faces.clone() {
        let found = eval_within(boundary, face, s, x, best.as_ref());
        if let Some(p) = found.filter(|p| p.gap >= 0.0) {
            keep_better(boundary, &mut best, p, &normal, &slave_normal);
        }
    }
    best
}

/// Replaces `best` by the face if that may hold the node, is opposed and better.
fn keep_better(
    boundary: &Boundary,
    best: &mut Option<Proximity>,
    found: Proximity,
    normal: &OnceCell<Vec3>,
    slave_normal: impl Fn() -> Vec3,
) {
    let size = boundary.sizes[found.face as usize];
    let within = found.gap <= NEAR * size && found.gap >= -DEPTH * size && found.distance <= DEPTH * size;
    if !within {
        return;
    }
    let normal = normal.get_or_init(slave_normal);
    let opposed = *normal == Vec3::zeros() || normal.dot(&found.normal) < OPPOSED;
    if opposed && best.is_none_or(|b| is_better(boundary, &found, &b, normal)) {
        *best = Some(found);
    }
}

/// The proximity of a face within its own reach of the node, unless it is too far to hold the node instead of `best`,
/// or to have it in front closer than `best`.
pub(super) fn eval_within(
    boundary: &Boundary,
    face: u32,
    s: &Vec3,
    x: &[Vec3],
    best: Option<&Proximity>,
) -> Option<Proximity> {
    let corners = boundary.faces[face as usize].map(|node| x[node as usize]);
    // Slightly more than `keep_better` takes, for rounding.
    let reach = DEPTH * (1.0 + 1e-9) * boundary.sizes[face as usize];
    let limit = best.map_or(reach, |b| reach.min(b.distance + 2.0 * TIE * boundary.largest_size));
    // Cheap bounds first: the face lies within the box and the slab of its corners.
    if is_outside_box(&corners, s, limit) || is_outside_slab(&corners, s, limit) {
        return None;
    }
    eval_proximity_within(boundary, face, s, x, limit)
}

/// Whether `s` is farther than `far` from the bounding box of the corners, along any axis.
#[inline]
pub(super) fn is_outside_box(corners: &[Vec3; 4], s: &Vec3, far: f64) -> bool {
    let [a, b, c, d] = corners;
    (0..3).any(|i| {
        let low = a[i].min(b[i]).min(c[i].min(d[i]));
        let high = a[i].max(b[i]).max(c[i].max(d[i]));
        s[i] < low - far || s[i] > high + far
    })
}

/// Whether `s` is farther than `far` from all corners along the normal of the diagonals.
#[inline]
fn is_outside_slab(corners: &[Vec3; 4], s: &Vec3, far: f64) -> bool {
    let [a, b, c, d] = corners;
    let normal = (c - a).cross(&(d - b));
    let heights = corners.map(|corner| normal.dot(&(s - corner)));
    let far = far * normal.norm();
    heights.iter().all(|h| *h > far) || heights.iter().all(|h| *h < -far)
}

/// Whether `a` is closer, or as close and more opposed; faces come in ascending order, so the first of equal ones is
/// kept.
fn is_better(boundary: &Boundary, a: &Proximity, b: &Proximity, slave_normal: &Vec3) -> bool {
    let tie = TIE * boundary.sizes[a.face as usize].max(boundary.sizes[b.face as usize]);
    if (a.distance - b.distance).abs() > tie {
        return a.distance < b.distance;
    }
    if *slave_normal == Vec3::zeros() {
        return a.gap > b.gap;
    }
    slave_normal.dot(&a.normal) < slave_normal.dot(&b.normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Surface;

    /// A wavy sheet with a fold, finer towards one side, of n × n faces.
    fn sheet(n: u32) -> (Boundary, Vec<Vec3>) {
        let mut x = Vec::new();
        for j in 0..=n {
            for i in 0..=n {
                let (a, b) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let height = 0.05 * (7.0 * a).sin() * (5.0 * b).cos() + 0.8 * (b - 0.5).max(0.0);
                x.push(Vec3::new(a * a, b, height));
            }
        }
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let cells = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let faces = cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let surface = Surface::new((0..x.len() as u32).collect(), faces);
        (Boundary::new(&surface, &x), x)
    }

    /// The result of [`choose_face`] with every face evaluated and none skipped.
    fn choose_of_all(boundary: &Boundary, s: &Vec3, down: &Vec3, x: &[Vec3]) -> Option<Proximity> {
        let normal = OnceCell::new();
        let count = boundary.faces.len() as u32;
        let all: Vec<Proximity> =
            (0..count).filter_map(|face| eval_proximity(boundary, face, s, x)).collect();
        let choose = |take: &dyn Fn(&Proximity) -> bool| {
            let mut best = None;
            all.iter()
                .filter(|p| take(p))
                .for_each(|p| keep_better(boundary, &mut best, *p, &normal, || *down));
            best
        };
        let held = choose(&|_| true)?;
        let size = |p: &Proximity| boundary.sizes[p.face as usize];
        let is_in_front = |p: &Proximity| {
            p.gap > 0.0 && p.distance <= DEPTH * size(p) && p.distance < held.distance - BAND * size(&held)
        };
        if held.gap < 0.0 && all.iter().any(is_in_front) { choose(&|p| p.gap >= 0.0) } else { Some(held) }
    }

    #[test]
    fn what_is_passed_over_changes_nothing() {
        let (boundary, x) = sheet(9);
        let faces = 0..boundary.faces.len() as u32;
        let down = Vec3::new(0.1, -0.2, -1.0).normalize();
        let (mut held, mut inside) = (0, 0);
        for k in 0..20_000 {
            let t = f64::from(k);
            let [a, b, c] = [0.618_034, 0.754_878, 0.569_840].map(|step| (t * step).fract());
            // Around the sheet, within a few face sizes of it.
            let on = (a * 80.0) as usize;
            let s = x[on] + Vec3::new(b - 0.5, c - 0.5, (b + 2.0 * c).fract() - 0.5) * 0.1;
            let found = choose_face(&boundary, &faces, &s, || down, &x);
            assert_eq!(found, choose_of_all(&boundary, &s, &down, &x), "{s}");
            held += usize::from(found.is_some());
            inside += usize::from(found.is_some_and(|p| p.gap < 0.0));
        }
        assert!(held > 1000 && inside > 300, "{held} held, {inside} inside");
    }
}
