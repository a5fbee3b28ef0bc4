//! A surface against itself: which of its own faces a node never meets, and how far its parts have moved against each other.

use super::broad_phase::Motion;
use super::closest_point::Patch;
use super::skin::Skin;
use crate::mechanics::tensor::Vec3;

/// A face that lies behind a node at the start of the run and closer than this many sizes of it is the far side of
/// the node's own wall.
const WALL: f64 = 2.0;

/// Faces by node that self-contact leaves out: faces around the node, and the far side of thin walls.
#[derive(Clone, Debug)]
pub(super) struct Exclusions {
    /// All nodes where they were at the start of the run [m].
    rest: Vec<Vec3>,
}

impl Exclusions {
    /// Of surfaces that start at the positions `x` [m] of all nodes.
    pub fn new(x: &[Vec3]) -> Self {
        Self { rest: x.to_vec() }
    }

    /// Whether the node never meets the face.
    pub fn contain(&self, skin: &Skin, node: u32, face: u32) -> bool {
        skin.faces[face as usize].contains(&node) || self.is_across_the_wall(skin, node, face)
    }

    fn is_across_the_wall(&self, skin: &Skin, node: u32, face: u32) -> bool {
        let (s, corners) = (&self.rest[node as usize], &skin.faces[face as usize]);
        let patch = Patch::new(corners, &self.rest);
        let range = WALL * skin.sizes[face as usize];
        // Before anything costly: a face within range has all corners within range and its own extent.
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
            && face_normal.dot(&skin.node_normal(node, &self.rest)) < 0.0
    }
}

/// Whether the face shares a node with a face around the node.
pub(super) fn is_beside(skin: &Skin, node: u32, face: u32) -> bool {
    let corners = skin.faces[face as usize].iter();
    corners.flat_map(|&c| skin.faces_around(c)).any(|&beside| skin.faces[beside as usize].contains(&node))
}

/// How a surface has moved against itself since its list was made.
///
/// Of two nodes with displacements d and e, ‖d − e‖ is at most the diagonal of the box around the displacements of all: a body
/// that flies, however far, has not moved against itself.
#[derive(Clone, Debug, Default)]
pub(super) struct OwnMotion {
    /// Where its nodes were then [m]; empty before the first list.
    snapshot: Vec<Vec3>,
    /// How far any two nodes have moved against each other since then, at either end of the step, at most [m].
    pub since_list: f64,
    /// How far a node moves within the step, at most [m].
    pub in_step: f64,
    /// The middle of the displacements since then, at the start of the step [m].
    pub shift: Vec3,
}

impl OwnMotion {
    /// Takes the positions at the start of the step as those of the list.
    pub fn restart(&mut self, skin: &Skin, motion: &Motion) {
        self.snapshot.clear();
        self.snapshot.extend(skin.nodes.iter().map(|&n| motion.x[n as usize]));
    }

    /// Whether there is a list.
    pub fn has_started(&self) -> bool {
        !self.snapshot.is_empty()
    }

    /// Measures the motion of a step; whether all positions are finite.
    pub fn measure(&mut self, skin: &Skin, motion: &Motion) -> bool {
        let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        let ([mut start, mut end], mut in_step, mut check) = ([nothing; 2], 0.0_f64, 0.0);
        for (&node, old) in skin.nodes.iter().zip(&self.snapshot) {
            let (x, x_end) = (&motion.x[node as usize], &motion.x_end[node as usize]);
            widen(&mut start, &(x - old));
            widen(&mut end, &(x_end - old));
            let step = (x_end - x).norm_squared();
            in_step = if step > in_step { step } else { in_step };
            // A NaN is dropped by the comparisons and shows in the sum.
            check += x.x + x.y + x.z + step;
        }
        if !check.is_finite() {
            return false;
        }
        let diagonal = |[low, high]: &[Vec3; 2]| (high - low).norm();
        self.since_list = diagonal(&start).max(diagonal(&end));
        self.in_step = in_step.sqrt();
        self.shift = (start[0] + start[1]) * 0.5;
        true
    }
}

#[inline]
fn widen([low, high]: &mut [Vec3; 2], d: &Vec3) {
    for i in 0..3 {
        low[i] = if d[i] < low[i] { d[i] } else { low[i] };
        high[i] = if d[i] > high[i] { d[i] } else { high[i] };
    }
}
