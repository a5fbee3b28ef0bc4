//! Closing of the patch: nodes that others in contact enclose count as in contact, too.
//!
//! On a coarse mesh a node leaves the surface for a time that grows with the size of its faces, in the midst of others that are pressed. The
//! set of nodes in contact is therefore dilated by one face and eroded by one (morphological closing): this fills gaps of up to two nodes
//! and keeps the outer edge. What it fills vanishes with the size of the faces, so that a real gap, as below a dented ball, stays open. Where
//! the surface ends, at a rim or a plane of symmetry, nodes are enclosed by others along that border alone.

use super::super::face_shape::distinct;
use super::place_map::PlaceMap;
use super::{Limit, PatchGeometry, Touch};
use crate::mechanics::followers::Followers;
use crate::mechanics::tensor::Vec3;
use std::ops::Range;

/// Work arrays of the closing, by places on the surface.
#[derive(Clone, Debug)]
pub(super) struct Closing {
    /// The nodes in contact, and those that follow them.
    pressed: PlaceMap<Touch>,
    /// Nodes beside them.
    beside: PlaceMap<Beside>,
    /// Of these the nodes whose neighbours' contacts have a mean; each with its entries of `rings`.
    near: PlaceMap<(Touch, Range<usize>)>,
    rings: Vec<Corner>,
}

impl Closing {
    /// For a surface of so many nodes.
    pub(super) fn of(nodes: usize) -> Self {
        Self {
            pressed: PlaceMap::of(nodes),
            beside: PlaceMap::of(nodes),
            near: PlaceMap::of(nodes),
            rings: Vec::new(),
        }
    }

    /// Whether all around a node are in contact or beside; if it is on the border, along that at least one in contact, and all these or
    /// beside such a one.
    fn is_enclosed(&self, ring: &Range<usize>) -> bool {
        let Self { pressed, near, rings, .. } = self;
        let along = |ring: &Range<usize>| rings[ring.clone()].iter().filter(|corner| corner.is_along());
        let touches_along = |ring| along(ring).any(|corner| pressed.contains(corner.place));
        let is_in = |corner: &Corner| pressed.contains(corner.place) || near.contains(corner.place);
        let is_in_along = |corner: &Corner| {
            pressed.contains(corner.place)
                || near.get(corner.place).is_some_and(|(_, ring)| touches_along(ring))
        };
        let is_within = along(ring).next().is_none() || touches_along(ring);
        is_within && rings[ring.clone()].iter().all(is_in) && along(ring).all(is_in_along)
    }
}

/// A corner around a node, of its faces that are oriented towards a contact.
#[derive(Clone, Copy, Debug)]
struct Corner {
    place: u32,
    /// Number of these faces at the edge to it; 0 across a face.
    faces: u32,
}

impl Corner {
    /// Whether it is along the border of these faces.
    fn is_along(self) -> bool {
        self.faces == 1
    }
}

/// A node beside others in contact: sums over these.
#[derive(Clone, Copy, Debug, Default)]
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
        let mut closing = std::mem::replace(&mut self.closing, Closing::of(0));
        let Closing { pressed, beside, near, rings } = &mut closing;
        self.take_touches_with(followers, pressed);
        // Dilation by one face.
        beside.clear();
        for (place, touch) in pressed.iter() {
            rings.clear();
            self.add_ring(place, &touch.normal, position, limit, rings);
            for corner in rings.iter().filter(|corner| !pressed.contains(corner.place)) {
                beside.entry(corner.place, Beside::default).add(touch);
            }
        }
        near.clear();
        rings.clear();
        for (place, beside) in beside.iter() {
            let Some(touch) = beside.touch() else { continue };
            let first = rings.len();
            self.add_ring(place, &touch.normal, position, limit, rings);
            near.entry(place, || (touch, first..rings.len()));
        }
        // Erosion by one face; a node that follows others has its area with them.
        let is_follower = |place: u32| followers.contains(self.nodes[place as usize] as usize);
        let enclosed = closing
            .near
            .iter()
            .filter(|(place, (_, ring))| !is_follower(*place) && closing.is_enclosed(ring));
        let enclosed = enclosed.map(|(place, (touch, _))| (place, *touch)).collect();
        self.closing = closing;
        enclosed
    }

    /// Fills the map with the nodes in contact, and those that follow them, in their order.
    fn take_touches_with(&self, followers: &Followers, pressed: &mut PlaceMap<Touch>) {
        pressed.clear();
        for (place, touch) in self.touches.iter() {
            *pressed.entry(place, || *touch) = *touch;
            for (follower, _) in followers.led_by(self.nodes[place as usize] as usize) {
                // What is in contact itself has its own; of several masters the last one's.
                if let Some(follower) =
                    self.place_of(*follower).filter(|place| !self.touches.contains(*place))
                {
                    *pressed.entry(follower, || *touch) = *touch;
                }
            }
        }
        pressed.sort();
    }

    /// Adds the corners around a node, of its faces that are oriented towards a contact with normal `n`, each once.
    fn add_ring(
        &mut self,
        place: u32,
        n: &Vec3,
        position: &impl Fn(u32) -> Vec3,
        limit: &Limit,
        rings: &mut Vec<Corner>,
    ) {
        let first = rings.len();
        for i in self.faces_of(place) {
            let (face, at) = self.incident[i];
            if !self.shape(face, position, limit).is_turned(n) {
                continue;
            }
            let ring = distinct(&self.faces[face as usize]);
            for (corner, other) in ring.iter().enumerate().filter(|(_, other)| **other != place) {
                let step = (corner + ring.len() - at as usize) % ring.len();
                let faces = u32::from(step == 1 || step == ring.len() - 1);
                match rings[first..].iter_mut().find(|known| known.place == *other) {
                    Some(known) => known.faces += faces,
                    None => rings.push(Corner { place: *other, faces }),
                }
            }
        }
    }
}
