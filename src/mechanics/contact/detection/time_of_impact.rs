//! The first time in a step at which a moving node meets a moving face: conservative, so that nothing tunnels.
//!
//! Node and corners move on straight lines. Then `F(a, b, τ) = x_face(a, b, τ) − s(τ)` is linear in each of its three
//! arguments, and over any box of them it stays within the bounds of its eight corner values. Boxes whose bounds
//! exclude zero are dropped, others bisected, earliest first (the inclusion test of Snyder 1992 as used for
//! collisions by Wang et al. 2021): no crossing can be missed, whatever the speed. Newton's method finishes in small
//! boxes.

use super::closest_point::Patch;
use crate::tensor::{Mat3, Vec3};

/// Number of boxes after which the search accepts the earliest time not excluded; a usual hit takes some forty.
const MAX_BOXES: usize = 4000;
/// Size of the image of a box, as a fraction of the face, below which Newton's method is tried.
const NEWTON_FRACTION: f64 = 0.05;
/// Size of the image of a box, as a fraction of the face, below which it counts as a crossing.
const LEAF_FRACTION: f64 = 1e-7;
/// Largest number of steps along the path of a node; each leads to the surface or most of the way to the closest
/// pass.
const MARCH: usize = 100;
/// Distance of Newton's root outside 0…1 that is tolerated, for rounding on common edges.
const SLACK: f64 = 1e-9;

/// Place and time at which a node meets a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Fraction of the step, 0…1.
    pub tau: f64,
    /// First coordinate on the face, 0…1, see [`Patch::weights`].
    pub a: f64,
    /// Second coordinate on the face, 0…1.
    pub b: f64,
}

impl Impact {
    fn at(arguments: [f64; 3]) -> Self {
        let [a, b, tau] = arguments.map(|x| x.clamp(0.0, 1.0));
        Self { tau, a, b }
    }
}

/// A box of (a, b, τ) with the values of F at its corners; bits 0, 1, 2 of an index stand for a, b, τ.
#[derive(Clone, Copy)]
struct Box3 {
    low: [f64; 3],
    width: [f64; 3],
    values: [Vec3; 8],
}

/// Boxes for which a search reserves memory at first.
const ROOM: usize = 256;

/// Memory of the search, reused between calls.
#[derive(Clone)]
pub struct Search {
    stack: Vec<Box3>,
}

impl Default for Search {
    fn default() -> Self {
        Self { stack: Vec::with_capacity(ROOM) }
    }
}

impl std::fmt::Debug for Search {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Search").field("capacity", &self.stack.capacity()).finish()
    }
}

impl Search {
    /// The first impact of a node moving from `s` to `s_end` on the *outside* of a face moving from `face` to
    /// `face_end` [m], before the fraction `before` of the step; `None` if it does not reach the face, or passes
    /// through it from behind.
    pub fn first_impact(
        &mut self,
        face: &Patch,
        face_end: &Patch,
        s: &Vec3,
        s_end: &Vec3,
        before: f64,
    ) -> Option<Impact> {
        // Exclude most nodes by the bounds of the whole step.
        let whole = Box3::whole(face, face_end, s, s_end);
        let scale = face.corners.iter().map(|c| (c - face.corners[0]).amax()).fold(0.0, f64::max);
        let rounding = 1e-14 * whole.values.iter().map(Vec3::amax).fold(scale, f64::max);
        if whole.excludes_zero(rounding) {
            return None;
        }
        // A crossing from outside found at once is the first one: an earlier one would need two more.
        if let Some(hit) = whole.guess(face, s).and_then(|start| whole.newton(&whole, start))
            && whole.approaches(hit)
        {
            let found = Impact::at(hit);
            return (found.tau < before).then_some(found);
        }
        // Bisection, earliest times first.
        let mut best: Option<Impact> = None;
        self.stack.clear();
        self.stack.push(whole);
        let mut count = 0;
        while let Some(part) = self.stack.pop() {
            let too_late = part.low[2] >= best.map_or(before, |b| b.tau);
            if too_late || part.excludes_zero(rounding) {
                continue;
            }
            count += 1;
            let extents = part.extents();
            let largest = extents[0].max(extents[1]).max(extents[2]);
            let hit = if largest <= LEAF_FRACTION * scale || count > MAX_BOXES {
                Some(part.earliest())
            } else if largest <= NEWTON_FRACTION * scale {
                part.newton(&whole, part.middle())
            } else {
                None
            };
            if let Some(at) = hit {
                if whole.approaches(at) && at[2] < best.map_or(before, |b| b.tau) {
                    best = Some(Impact::at(at));
                }
                continue;
            }
            let axis = if extents[2] >= largest { 2 } else { usize::from(extents[1] >= largest) };
            let (first, second) = part.halves(axis);
            self.stack.push(second);
            self.stack.push(first);
        }
        best
    }
}

impl Box3 {
    fn whole(face: &Patch, face_end: &Patch, s: &Vec3, s_end: &Vec3) -> Self {
        // Corner of the face at (a, b) = (0,0), (1,0), (0,1), (1,1).
        let order = [0, 1, 3, 2];
        let values = std::array::from_fn(|i| {
            let k = order[i & 3];
            if i & 4 == 0 { face.corners[k] - s } else { face_end.corners[k] - s_end }
        });
        Self { low: [0.0; 3], width: [1.0; 3], values }
    }

    fn middle(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.low[i] + 0.5 * self.width[i])
    }

    /// Middle of the face at the earliest time of the box, to be conservative.
    fn earliest(&self) -> [f64; 3] {
        let [a, b, _] = self.middle();
        [a, b, self.low[2]]
    }

    /// Initial guess of the root: from the closest point at the start, if the node is outside there and closing.
    fn guess(&self, face: &Patch, s: &Vec3) -> Option<[f64; 3]> {
        let closest = face.closest(s);
        let [_, w1, w2, w3] = closest.weights;
        let b = w2 + w3;
        let a = if face.triangle { w1 / (1.0 - b) } else { w1 + w2 };
        let a = if a.is_finite() { a } else { 0.5 };
        let normal = face.normal(&closest.weights);
        let gap = normal.dot(&(s - closest.point));
        let closing = normal.dot(&self.eval([a, b, 0.0]).1[2]);
        let tau = gap / closing;
        (gap >= 0.0 && closing > 0.0 && tau <= 1.5).then_some([a, b, tau.min(1.0)])
    }

    fn excludes_zero(&self, rounding: f64) -> bool {
        (0..3).any(|c| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for v in &self.values {
                low = low.min(v[c]);
                high = high.max(v[c]);
            }
            // NaN excludes as well: a broken state is reported elsewhere.
            !(low <= rounding && high >= -rounding)
        })
    }

    /// The largest change of F along each argument.
    fn extents(&self) -> [f64; 3] {
        [1, 2, 4].map(|bit| {
            let pairs = (0..8).filter(|i| i & bit == 0);
            pairs.map(|i| (self.values[i | bit] - self.values[i]).amax()).fold(0.0, f64::max)
        })
    }

    fn halves(&self, axis: usize) -> (Self, Self) {
        let bit = 1 << axis;
        let (mut first, mut second) = (*self, *self);
        let half = 0.5 * self.width[axis];
        first.width[axis] = half;
        second.width[axis] = half;
        second.low[axis] += half;
        for i in (0..8).filter(|i| i & bit == 0) {
            let middle = (self.values[i] + self.values[i | bit]) * 0.5;
            first.values[i | bit] = middle;
            second.values[i] = middle;
        }
        (first, second)
    }

    /// F and its derivatives at arguments of the whole box.
    fn eval(&self, [a, b, tau]: [f64; 3]) -> (Vec3, [Vec3; 3]) {
        let v = &self.values;
        let mix = |p: Vec3, q: Vec3, t: f64| p + (q - p) * t;
        let along_tau: [Vec3; 4] = std::array::from_fn(|i| mix(v[i], v[i | 4], tau));
        let change: [Vec3; 4] = std::array::from_fn(|i| v[i | 4] - v[i]);
        let over_face = |c: &[Vec3; 4]| mix(mix(c[0], c[1], a), mix(c[2], c[3], a), b);
        let d_a = mix(along_tau[1] - along_tau[0], along_tau[3] - along_tau[2], b);
        let d_b = mix(along_tau[2] - along_tau[0], along_tau[3] - along_tau[1], a);
        (over_face(&along_tau), [d_a, d_b, over_face(&change)])
    }

    /// A root of F in this box (with a small margin), by Newton's method; `whole` has the values of F on the full
    /// range of its arguments.
    fn newton(&self, whole: &Self, mut at: [f64; 3]) -> Option<[f64; 3]> {
        for _ in 0..12 {
            let (f, d) = whole.eval(at);
            let step = Mat3::from_columns(&d).lu().solve(&f)?;
            for i in 0..3 {
                at[i] -= step[i];
                let room = 0.5 * self.width[i] + SLACK;
                if !(at[i] >= self.low[i] - room && at[i] <= self.low[i] + self.width[i] + room) {
                    return None;
                }
            }
            if step.amax() <= 1e-13 {
                let inside = at.iter().all(|x| *x >= -SLACK && *x <= 1.0 + SLACK);
                return inside.then_some(at);
            }
        }
        None
    }

    /// Whether the node moves towards the outside of the face.
    fn approaches(&self, at: [f64; 3]) -> bool {
        let (_, [d_a, d_b, d_tau]) = self.eval(at);
        let mut n = d_a.cross(&d_b);
        if n.norm_squared() <= 1e-24 * (d_a.norm_squared() + d_b.norm_squared()).powi(2) {
            // The degenerate side of a triangle: use the normal at the middle of the face.
            let (_, [d_a, d_b, _]) = self.eval([0.5, 0.5, at[2]]);
            n = d_a.cross(&d_b);
        }
        n.dot(&d_tau) > 0.0
    }
}

/// The first fraction of a straight path of the given length [m] at which the distance falls to `met` [m]; it starts
/// outside.
///
/// No step exceeds the distance, so no surface is jumped over.
pub(super) fn first_meeting(distance: impl Fn(f64) -> f64, length: f64, met: f64) -> Option<f64> {
    let mut fraction = 0.0;
    for _ in 0..MARCH {
        let left = distance(fraction);
        if left <= met {
            return Some(fraction);
        }
        fraction += left / length;
        if fraction > 1.0 {
            return None;
        }
    }
    // It passes along the surface, which counts as an impact.
    Some(fraction)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact equality is intended
mod tests {
    use super::*;

    fn square(z: f64) -> Patch {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, z));
        Patch { corners, triangle: false }
    }

    #[test]
    fn straight_fall_and_miss_and_exit() {
        let mut search = Search::default();
        let (face, from, to) = (square(0.0), Vec3::new(0.3, 0.6, 1.0), Vec3::new(0.3, 0.6, -3.0));
        let hit = search.first_impact(&face, &face, &from, &to, 2.0).unwrap();
        assert!((hit.tau - 0.25).abs() < 1e-12 && (hit.a - 0.3).abs() < 1e-12 && (hit.b - 0.6).abs() < 1e-12);
        // No impact from behind, beside, or with too short a path.
        assert_eq!(search.first_impact(&face, &face, &to, &from, 2.0), None);
        assert_eq!(search.first_impact(&face, &face, &(from + Vec3::x()), &(to + Vec3::x()), 2.0), None);
        assert_eq!(search.first_impact(&face, &face, &from, &Vec3::new(0.3, 0.6, 0.01), 2.0), None);
    }

    #[test]
    fn moving_warped_face_is_met_where_its_equations_say() {
        let mut search = Search::default();
        let mut start = square(0.0);
        start.corners[2].z = 0.3;
        start.corners[0].z = -0.2;
        let mut end = start;
        for (k, c) in end.corners.iter_mut().enumerate() {
            *c += Vec3::new(0.4, -0.2, 0.7 + 0.1 * k as f64);
        }
        let (s, s_end) = (Vec3::new(0.9, 0.2, 1.4), Vec3::new(0.3, 0.8, -0.9));
        let hit = search.first_impact(&start, &end, &s, &s_end, 2.0).unwrap();
        let face = Patch {
            corners: std::array::from_fn(|k| {
                start.corners[k] + (end.corners[k] - start.corners[k]) * hit.tau
            }),
            triangle: false,
        };
        let node = s + (s_end - s) * hit.tau;
        assert!((face.point(&face.weights(hit.a, hit.b)) - node).norm() < 1e-12);
    }

    #[test]
    fn nothing_slips_through_the_shared_edge_of_two_faces() {
        let mut search = Search::default();
        let left = square(0.0);
        let mut right = square(0.0);
        for c in &mut right.corners {
            c.x += 1.0;
        }
        for k in 0..200 {
            let t = f64::from(k);
            // Every path crosses z = 0 exactly on (or within rounding of) the edge x = 1.
            let d = Vec3::new((1.3 * t).sin(), 0.2 * (2.1 * t).cos(), -1.0 - 0.5 * (0.7 * t).sin().abs());
            let at = Vec3::new(1.0, 0.5 + 0.4 * (0.37 * t).sin(), 0.0);
            let (s, s_end) = (at - d * 0.7, at + d * 300.0);
            let hits = [&left, &right].map(|face| search.first_impact(face, face, &s, &s_end, 2.0));
            assert!(hits.iter().any(Option::is_some), "path {k} tunnels");
        }
    }

    #[test]
    fn sliding_in_the_plane_ends_and_stays_finite() {
        let mut search = Search::default();
        let face = square(0.0);
        let (s, s_end) = (Vec3::new(-1.0, 0.5, 0.0), Vec3::new(2.0, 0.5, 0.0));
        // Touching without approaching is no impact; the search must only terminate.
        assert_eq!(search.first_impact(&face, &face, &s, &s_end, 2.0), None);
    }
}
