//! Closing of the patch: nodes that others in contact enclose count as in contact, too.
//!
//! On a coarse mesh a node leaves the surface for a time that grows with the size of its faces, in the midst of others that are pressed. The
//! set of nodes in contact is therefore dilated by one face and eroded by one (morphological closing): this fills gaps of up to two nodes
//! and keeps the outer edge. What it fills vanishes with the size of the faces, so that a real gap, as below a dented ball, stays open. Where
//! the surface ends, at a rim or a plane of symmetry, nodes are enclosed by others along that border alone.

use super::place_map::PlaceMap;
use super::touch::Touch;
use crate::mechanics::tensor::Vec3;
use std::ops::Range;

/// Work arrays of the closing, by places on the surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Closing {
    /// The nodes in contact, and those that follow them, sorted.
    pub(super) pressed: PlaceMap<Touch>,
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

    /// The nodes that those in contact enclose, each with the mean of its neighbours' contacts and without a force. `add_ring` adds the corners
    /// around a node, of its faces that are oriented towards a contact with a normal.
    pub(super) fn enclosed(
        &mut self,
        mut add_ring: impl FnMut(u32, &Vec3, &mut Vec<Corner>),
    ) -> Vec<(u32, Touch)> {
        let Self { pressed, beside, near, rings } = self;
        // Dilation by one face.
        beside.clear();
        for (place, touch) in pressed.iter() {
            rings.clear();
            add_ring(place, &touch.normal, rings);
            for corner in rings.iter().filter(|corner| !pressed.contains(corner.place)) {
                beside.entry(corner.place, Beside::default).add(touch);
            }
        }
        near.clear();
        rings.clear();
        for (place, beside) in beside.iter() {
            let Some(touch) = beside.touch() else { continue };
            let first = rings.len();
            add_ring(place, &touch.normal, rings);
            near.entry(place, || (touch, first..rings.len()));
        }
        // Erosion by one face.
        let enclosed = self.near.iter().filter(|(_, (_, ring))| self.is_enclosed(ring));
        enclosed.map(|(place, (touch, _))| (place, *touch)).collect()
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
pub(super) struct Corner {
    pub place: u32,
    /// Number of these faces at the edge to it; 0 across a face.
    pub faces: u32,
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
