//! Nodes that hang: in the middle of an edge or of a face of a coarse element, corners of the finer ones beside it.
//!
//! The field is continuous where such a node moves as the trilinear coarse element does there: with the mean of the ends of its edge
//! (½, ½) or of the corners of its face (¼ each). These may hang themselves.

use crate::mechanics::followers::Masters;
use std::collections::BTreeMap;

/// The hanging nodes of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HangingNodes {
    /// Of each of them the two ends of the edge, or the four corners of the face, in whose middle it is.
    between: BTreeMap<u32, Vec<u32>>,
}

impl HangingNodes {
    /// Of nodes with the ends of the edge, or the corners of the face, in whose middle each is.
    pub fn new(between: BTreeMap<u32, Vec<u32>>) -> Self {
        Self { between }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.between.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.between.len()
    }

    /// Each node with those that it is in the middle of, ascending.
    pub fn each(&self) -> impl Iterator<Item = (u32, &[u32])> {
        self.between.iter().map(|(node, others)| (*node, &others[..]))
    }

    /// Whom they follow, with equal weights.
    pub fn ties(&self) -> BTreeMap<u32, Masters> {
        let equal = |others: &[u32]| others.iter().map(|a| (*a, 1.0 / others.len() as f64)).collect();
        self.each().map(|(node, others)| (node, equal(others))).collect()
    }

    /// Takes the nodes out of a set (sorted) that hang on nodes which are not all in it: what is held or loaded is told by these.
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

    /// Numbers the nodes anew; those that are gone, or one of whose others is, hang no more.
    pub(super) fn renumber(&mut self, new: impl Fn(u32) -> Option<u32>) {
        let renumbered = |(node, others): (&u32, &Vec<u32>)| {
            let others: Option<Vec<u32>> = others.iter().map(|a| new(*a)).collect();
            Some((new(*node)?, others?))
        };
        self.between = self.between.iter().filter_map(renumbered).collect();
    }

    /// The skin of elements with these hanging nodes, of the `faces` that belong to one element only: without those between coarse and
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
        let is_between =
            |face: &[u32; 4]| face.iter().any(is_in_a_face) || middles.contains_key(&sorted(face));
        let mut boundary = Vec::with_capacity(faces.len());
        for face in faces.into_iter().filter(|face| !is_between(face)) {
            let edges = (0..4).map(|i| [face[i], face[(i + 1) % 4]]);
            let corners = edges.flat_map(|edge| [Some(edge[0]), middles.get(&sorted(&edge)).copied()]);
            let corners: Vec<u32> = corners.flatten().collect();
            if corners.len() == 4 {
                boundary.push(face);
                continue;
            }
            // From a middle of an edge no triangle is flat.
            let first = corners.iter().position(|node| !face.contains(node)).unwrap_or(0);
            let corner = |i: usize| corners[(first + i) % corners.len()];
            boundary
                .extend((1..corners.len() - 1).map(|i| [corner(0), corner(i), corner(i + 1), corner(i + 1)]));
        }
        boundary
    }
}
