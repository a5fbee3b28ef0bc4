//! Which faces of its own surface a node never meets.

use super::closest_point::Patch;
use super::skin::Skin;
use crate::mechanics::tensor::Vec3;

/// A face that lies behind a node at the start of the run and closer than this many sizes of it is the far side of
/// the node's own wall.
const WALL: f64 = 2.0;

/// Faces by node that self-contact leaves out; empty between different surfaces.
#[derive(Clone, Debug, Default)]
pub(super) struct Exclusions {
    /// (node, face), sorted.
    pairs: Vec<(u32, u32)>,
}

impl Exclusions {
    /// For two different surfaces.
    pub fn none() -> Self {
        Self::default()
    }

    /// For a surface against itself, at the positions `x` [m] of the start of the run: faces around a node, those that
    /// share a node with them, and the far side of thin walls.
    pub fn new(skin: &Skin, x: &[Vec3]) -> Self {
        let mut pairs = Vec::new();
        for &node in &skin.nodes {
            for &face in skin.faces_around(node) {
                for &corner in &skin.faces[face as usize] {
                    pairs.extend(skin.faces_around(corner).iter().map(|&other| (node, other)));
                }
            }
            let (s, normal) = (x[node as usize], skin.node_normal(node, x));
            for (i, face) in skin.faces.iter().enumerate() {
                let patch = Patch::new(face, x);
                let range = WALL * skin.sizes[i];
                // Before anything costly: a face within range has all corners within range and its own extent.
                let extent = (patch.corners[2] - patch.corners[0]).norm()
                    + (patch.corners[3] - patch.corners[1]).norm();
                if (patch.corners[0] - s).norm() > range + extent {
                    continue;
                }
                let closest = patch.closest(&s);
                let offset = s - closest.point;
                let face_normal = patch.normal(&closest.weights);
                let behind = face_normal.dot(&offset) < 0.0 && face_normal.dot(&normal) < 0.0;
                if behind && offset.norm() <= range {
                    pairs.push((node, i as u32));
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        Self { pairs }
    }

    /// Whether the node never meets the face.
    pub fn contain(&self, node: u32, face: u32) -> bool {
        !self.pairs.is_empty() && self.pairs.binary_search(&(node, face)).is_ok()
    }
}
