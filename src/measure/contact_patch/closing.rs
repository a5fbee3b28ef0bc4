//! Closing of the patch: nodes that others in contact enclose count as in contact, too.
//!
//! On a coarse mesh a node leaves the surface for a time that grows with the size of its faces, in the midst of others that are pressed. The
//! set of nodes in contact is therefore dilated by one face and eroded by one (morphological closing): this fills gaps of up to two nodes
//! and keeps the outer edge. What it fills vanishes with the size of the faces, so that a real gap, as below a dented ball, stays open. Where
//! the surface ends, at a rim or a plane of symmetry, nodes are enclosed by others along that border alone.

use super::super::face_shape::distinct;
use super::{Limit, PatchGeometry, Touch};
use crate::mechanics::followers::Followers;
use crate::mechanics::tensor::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// The corners around a node, of its faces that are oriented towards a contact.
struct Around {
    /// All of them.
    corners: BTreeSet<u32>,
    /// Those along the border of these faces, if the node is on it.
    along: Vec<u32>,
}

/// A node beside others in contact: sums over these.
#[derive(Clone, Copy, Default)]
struct Beside {
    normal: Vec3,
    weight: f64,
    count: f64,
}

impl Beside {
    fn add(&mut self, touch: &Touch) {
        self.normal += touch.normal;
        self.weight += touch.largest.1;
        self.count += 1.0;
    }
    /// Their mean, without a force at any time.
    fn touch(&self) -> Option<Touch> {
        let normal = self.normal.try_normalize(0.0)?;
        let weight = self.weight / self.count;
        Some(Touch {
            largest: (f64::NEG_INFINITY, weight),
            ..Touch::new((f64::NEG_INFINITY, normal), weight, 0.0)
        })
    }
}

impl PatchGeometry {
    /// The nodes that those in contact enclose, each with the mean of its neighbours' contacts and without a force.
    pub(super) fn enclosed(
        &mut self,
        position: &impl Fn(u32) -> Vec3,
        limit: &Limit,
        followers: &Followers,
    ) -> Vec<(u32, Touch)> {
        let pressed = self.touches_with(followers);
        // Dilation by one face.
        let mut beside: BTreeMap<u32, Beside> = BTreeMap::new();
        for (node, touch) in &pressed {
            let around = self.around(*node, &touch.normal, position, limit);
            for corner in around.corners.iter().filter(|corner| !pressed.contains_key(corner)) {
                beside.entry(*corner).or_default().add(touch);
            }
        }
        let near: BTreeMap<u32, (Touch, Around)> = beside
            .into_iter()
            .filter_map(|(node, beside)| {
                let touch = beside.touch()?;
                Some((node, (touch, self.around(node, &touch.normal, position, limit))))
            })
            .collect();
        // Erosion by one face; a node that follows others has its area with them.
        let is_in = |corner: &u32| pressed.contains_key(corner) || near.contains_key(corner);
        let touches_along = |around: &Around| around.along.iter().any(|corner| pressed.contains_key(corner));
        let is_in_along = |corner: &u32| {
            pressed.contains_key(corner) || near.get(corner).is_some_and(|(_, around)| touches_along(around))
        };
        let is_enclosed = |around: &Around| {
            let is_within = around.along.is_empty() || touches_along(around);
            is_within && around.corners.iter().all(is_in) && around.along.iter().all(is_in_along)
        };
        let enclosed = near
            .iter()
            .filter(|(node, (_, around))| !followers.contains(**node as usize) && is_enclosed(around));
        enclosed.map(|(node, (touch, _))| (*node, *touch)).collect()
    }

    /// The nodes in contact, and those that follow them.
    fn touches_with(&self, followers: &Followers) -> BTreeMap<u32, Touch> {
        let led = |(node, touch): (&u32, &Touch)| {
            let touch = *touch;
            followers.led_by(*node as usize).iter().map(move |(follower, _)| (*follower, touch))
        };
        let mut all: BTreeMap<u32, Touch> = self.touches.iter().flat_map(led).collect();
        all.extend(&self.touches);
        all
    }

    /// The corners around a node, of its faces that are oriented towards a contact with normal `n`.
    fn around(&mut self, node: u32, n: &Vec3, position: &impl Fn(u32) -> Vec3, limit: &Limit) -> Around {
        let mut corners = BTreeSet::new();
        // Number of faces at each edge from the node.
        let mut edges: BTreeMap<u32, usize> = BTreeMap::new();
        for i in self.faces_of(node) {
            let face = self.incident[i];
            if !self.shape(face, position, limit).is_turned(n) {
                continue;
            }
            let ring = distinct(&self.faces[face as usize]);
            corners.extend(ring);
            if let Some(at) = ring.iter().position(|&corner| corner == node) {
                for step in [1, ring.len() - 1] {
                    *edges.entry(ring[(at + step) % ring.len()]).or_default() += 1;
                }
            }
        }
        let along = edges.into_iter().filter(|(_, faces)| *faces == 1).map(|(corner, _)| corner).collect();
        Around { corners, along }
    }
}
