//! A surface against itself: the faces that a node never meets, and the motion of its parts relative to each other.

use super::boundary::Boundary;
use super::closest_point::Patch;
use super::detector::Motion;
use crate::tensor::Vec3;
use std::sync::Arc;

/// Distance in sizes of a face within which a face behind a node at the start of the run is the far side of the
/// node's own wall.
const WALL: f64 = 2.0;

/// Faces excluded from self-contact by node: faces around the node, and the far side of thin walls.
#[derive(Clone, Debug)]
pub(super) struct Exclusions {
    /// Positions of all nodes at the start of the run [m], shared by all surfaces.
    rest: Arc<[Vec3]>,
}

impl Exclusions {
    /// For surfaces that start at the positions `x` [m] of all nodes.
    pub fn new(x: &Arc<[Vec3]>) -> Self {
        Self { rest: Arc::clone(x) }
    }

    /// Whether the node never meets the face.
    pub fn contain(&self, boundary: &Boundary, node: u32, face: u32) -> bool {
        boundary.faces[face as usize].contains(&node) || self.is_across_the_wall(boundary, node, face)
    }

    fn is_across_the_wall(&self, boundary: &Boundary, node: u32, face: u32) -> bool {
        let (s, corners) = (&self.rest[node as usize], &boundary.faces[face as usize]);
        let patch = Patch::new(corners, &self.rest);
        let range = WALL * boundary.sizes[face as usize];
        // Cheap bound first: a face within range has all corners within range and its own extent.
        let extent =
            (patch.corners[2] - patch.corners[0]).norm() + (patch.corners[3] - patch.corners[1]).norm();
        if (patch.corners[0] - s).norm() > range + extent {
            return false;
        }
        let closest = patch.closest(s);
        let offset = s - closest.point;
        let face_normal = patch.normal(&closest.weights);
        offset.norm() <= range
            && face_normal.dot(&offset) < 0.0
            && face_normal.dot(&boundary.node_normal(node, &self.rest)) < 0.0
    }
}

/// Motion of a surface relative to itself since its list was made.
///
/// For two nodes with displacements d and e, ‖d − e‖ is at most the diagonal of the box around all displacements: a
/// body that translates, however far, has not moved relative to itself.
#[derive(Clone, Debug, Default)]
pub(super) struct OwnMotion {
    /// Positions of its nodes at that time [m]; empty before the first list.
    snapshot: Vec<Vec3>,
    /// Upper bound of the relative displacement of any two nodes since then, at either end of the step [m].
    pub since_list: f64,
    /// Upper bound of the displacement of a node within the step [m].
    pub in_step: f64,
    /// Centre of the box of the displacements since then, at the start of the step [m].
    pub shift: Vec3,
    /// Positions of its nodes at the start of the last step [m].
    last: Vec<Vec3>,
    /// Sum over the steps since the list was made, up to the start of the present one, of upper bounds of the relative displacement of any
    /// two nodes [m].
    pub travel: f64,
    /// Upper bound of the relative displacement of any two nodes within the step [m].
    pub closing: f64,
}

impl OwnMotion {
    /// Starts a list at the positions at the start of the step.
    pub fn restart(&mut self, boundary: &Boundary, motion: &Motion) {
        self.snapshot.clear();
        self.snapshot.extend(boundary.nodes.iter().map(|&n| motion.x[n as usize]));
        self.last.clone_from(&self.snapshot);
        self.travel = 0.0;
    }

    /// Whether there is a list.
    pub fn has_started(&self) -> bool {
        !self.snapshot.is_empty()
    }

    /// Measures the motion of a step; returns whether all positions are finite.
    pub fn measure(&mut self, boundary: &Boundary, motion: &Motion) -> bool {
        let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        let ([mut start, mut end, mut before, mut within], mut in_step, mut check) =
            ([nothing; 4], 0.0_f64, 0.0);
        for ((&node, old), last) in boundary.nodes.iter().zip(&self.snapshot).zip(&mut self.last) {
            let (x, x_end) = (&motion.x[node as usize], &motion.x_end[node as usize]);
            widen(&mut start, &(x - old));
            widen(&mut end, &(x_end - old));
            widen(&mut before, &(x - *last));
            widen(&mut within, &(x_end - x));
            *last = *x;
            let step = (x_end - x).norm_squared();
            in_step = if step > in_step { step } else { in_step };
            // The comparisons drop a NaN, which shows in the sum.
            check += x.x + x.y + x.z + step;
        }
        if !check.is_finite() {
            return false;
        }
        let diagonal = |[low, high]: &[Vec3; 2]| (high - low).norm();
        self.since_list = diagonal(&start).max(diagonal(&end));
        // A little more for rounding.
        self.travel += diagonal(&before) * (1.0 + 1e-9);
        self.closing = diagonal(&within) * (1.0 + 1e-9);
        self.in_step = in_step.sqrt();
        self.shift = (start[0] + start[1]) * 0.5;
        true
    }

    /// Upper bound of the displacement relative to a face [m], since the list was made, of the node with this `place` in the surface; at
    /// the start of the step.
    pub fn relative_to(&self, boundary: &Boundary, place: usize, face: u32, x: &[Vec3]) -> f64 {
        let moved = |place: usize| x[boundary.nodes[place] as usize] - self.snapshot[place];
        let own = moved(place);
        let corners = boundary.faces[face as usize].iter().filter_map(|&corner| boundary.place(corner));
        corners.map(|corner| (own - moved(corner)).norm_squared()).fold(0.0, f64::max).sqrt() * (1.0 + 1e-9)
    }
}

#[inline]
fn widen([low, high]: &mut [Vec3; 2], d: &Vec3) {
    for i in 0..3 {
        low[i] = if d[i] < low[i] { d[i] } else { low[i] };
        high[i] = if d[i] > high[i] { d[i] } else { high[i] };
    }
}
