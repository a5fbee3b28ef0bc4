//! Hanging nodes: at the middle of an edge or face of a coarse element, and corners of the finer ones next to it.
//!
//! The field is continuous if such a node moves with the trilinear coarse element: with the mean of the ends of its edge
//! (½, ½) or of the corners of its face (¼ each). These may hang themselves.

use crate::mechanics::followers::Masters;
use std::collections::{BTreeMap, BTreeSet};

/// Hanging nodes of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HangingNodes {
    /// For each hanging node, the two ends of the edge, or the four corners of the face, whose middle it is.
    between: BTreeMap<u32, Vec<u32>>,
}

impl HangingNodes {
    /// Hanging nodes with the ends of the edge, or the corners of the face, of each.
    pub fn new(between: BTreeMap<u32, Vec<u32>>) -> Self {
        Self { between }
    }

    /// Whether there are no hanging nodes.
    pub fn is_empty(&self) -> bool {
        self.between.is_empty()
    }

    /// Number of hanging nodes.
    pub fn len(&self) -> usize {
        self.between.len()
    }

    /// Each hanging node with the nodes that it lies between, ascending.
    pub fn each(&self) -> impl Iterator<Item = (u32, &[u32])> {
        self.between.iter().map(|(node, others)| (*node, &others[..]))
    }

    /// Masters of the hanging nodes, with equal weights.
    pub fn ties(&self) -> BTreeMap<u32, Masters> {
        let equal = |others: &[u32]| others.iter().map(|a| (*a, 1.0 / others.len() as f64)).collect();
        self.each().map(|(node, others)| (node, equal(others))).collect()
    }

    /// Removes nodes from a (sorted) set that hang on nodes not all in it: constraints and loads are defined on the
    /// masters.
    pub fn complete(&self, set: &mut Vec<u32>) {
        loop {
            let has = |node: &u32| set.binary_search(node).is_ok();
            let hangs_alone =
                |node: &u32| self.between.get(node).is_some_and(|others| !others.iter().all(has));
            let kept: Vec<u32> = set.iter().filter(|node| !hangs_alone(node)).copied().collect();
            if kept.len() == set.len() {
                return;
            }
            *set = kept;
        }
    }

    /// Renumbers the nodes; nodes that are removed, or lose a master, no longer hang.
    pub(super) fn renumber(&mut self, new: impl Fn(u32) -> Option<u32>) {
        let renumbered = |(node, others): (&u32, &Vec<u32>)| {
            let others: Option<Vec<u32>> = others.iter().map(|a| new(*a)).collect();
            Some((new(*node)?, others?))
        };
        self.between = self.between.iter().filter_map(renumbered).collect();
    }

    /// Faces between elements of a layer, one on one side and two halves on the other, by their sorted nodes: of `faces` that
    /// belong to one element only, those with two nodes in the middles of opposite edges of another, and that other.
    fn halved(&self, faces: &[[u32; 4]]) -> BTreeSet<Vec<u32>> {
        let sorted = |nodes: &[u32; 4]| {
            let mut key = nodes.to_vec();
            key.sort_unstable();
            key
        };
        // The other end of the edge on which a node hangs.
        let beyond = |node: u32, end: u32| match self.between.get(&node).map(Vec::as_slice) {
            Some(&[a, b]) if a == end => Some(b),
            Some(&[a, b]) if b == end => Some(a),
            _ => None,
        };
        let has_hanging = |face: &&[u32; 4]| face.iter().any(|node| self.between.contains_key(node));
        let mut whole: BTreeSet<Vec<u32>> = BTreeSet::new();
        let mut pairs = Vec::new();
        for face in faces.iter().filter(has_hanging) {
            for i in 0..4 {
                let [m, n, end_n, end_m] = [0, 1, 2, 3].map(|k| face[(i + k) % 4]);
                if let (Some(a), Some(b)) = (beyond(m, end_m), beyond(n, end_n)) {
                    pairs.push((sorted(face), sorted(&[end_m, end_n, a, b])));
                }
            }
        }
        if pairs.is_empty() {
            return whole;
        }
        let known: BTreeSet<Vec<u32>> = faces.iter().map(sorted).collect();
        for (half, other) in pairs {
            if known.contains(&other) {
                whole.extend([half, other]);
            }
        }
        whole
    }

    /// Whether elements of a layer meet in halves of faces, which cannot be split further.
    pub fn halves_faces(&self, faces: &[[u32; 4]]) -> bool {
        !self.halved(faces).is_empty()
    }

    /// The boundary surface of elements with these hanging nodes, of the `faces` that belong to one element only: without those between coarse and
    /// fine elements, and with coarse faces that have hanging nodes on their edges cut into triangles (the last node repeated), so that
    /// each edge has a face on either side.
    pub fn boundary(&self, faces: Vec<[u32; 4]>) -> Vec<[u32; 4]> {
        if self.is_empty() {
            return faces;
        }
        let sorted = |nodes: &[u32]| {
            let mut key = nodes.to_vec();
            key.sort_unstable();
            key
        };
        let middles: BTreeMap<Vec<u32>, u32> = self.each().map(|(node, on)| (sorted(on), node)).collect();
        let is_in_a_face = |node: &u32| self.between.get(node).is_some_and(|others| others.len() == 4);
        let halved = self.halved(&faces);
        let is_between = |face: &[u32; 4]| {
            let corners = sorted(face);
            face.iter().any(is_in_a_face) || middles.contains_key(&corners) || halved.contains(&corners)
        };
        let mut boundary = Vec::with_capacity(faces.len());
        for face in faces.into_iter().filter(|face| !is_between(face)) {
            let edges = (0..4).map(|i| [face[i], face[(i + 1) % 4]]);
            let corners = edges.flat_map(|edge| [Some(edge[0]), middles.get(&sorted(&edge)).copied()]);
            let corners: Vec<u32> = corners.flatten().collect();
            if corners.len() == 4 {
                boundary.push(face);
                continue;
            }
            // Fanned from the middle of an edge, no triangle is degenerate.
            let first = corners.iter().position(|node| !face.contains(node)).unwrap_or(0);
            let corner = |i: usize| corners[(first + i) % corners.len()];
            boundary
                .extend((1..corners.len() - 1).map(|i| [corner(0), corner(i), corner(i + 1), corner(i + 1)]));
        }
        boundary
    }
}
