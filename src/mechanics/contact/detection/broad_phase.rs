//! Broad phase: the faces that each slave node may meet, listed by a tree of swept boxes and reused while nodes have
//! moved little.
//!
//! The list only saves time. It contains every pair that the narrow phase could accept, so that its age never changes
//! a result.

use super::boundary::Boundary;
use super::closest_point::Patch;
use super::detector::Motion;
use super::narrow_phase::{DEPTH, NEAR, Proximity, eval_proximity_within};
use crate::tensor::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use std::cell::Cell;
use std::ops::Range;

impl Motion<'_> {
    fn segment(&self, node: u32) -> Aabb {
        let (p, q) = (self.x[node as usize], self.x_end[node as usize]);
        Aabb::new(to_parry(&p.inf(&q)), to_parry(&p.sup(&q)))
    }

    /// Box of a face over the step, enlarged by `margin`.
    fn swept_face(&self, face: &[u32; 4], margin: f64) -> Aabb {
        let (mut low, mut high) = (self.x[face[0] as usize], self.x[face[0] as usize]);
        for &node in face {
            for p in [&self.x[node as usize], &self.x_end[node as usize]] {
                low = low.inf(p);
                high = high.sup(p);
            }
        }
        Aabb::new(to_parry(&low.add_scalar(-margin)), to_parry(&high.add_scalar(margin)))
    }
}

pub(super) fn to_parry(p: &Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

/// Distance beyond which a node is out of reach of the narrow phase for a face of this size [m].
pub fn reach(size: f64) -> f64 {
    NEAR.max(DEPTH) * size
}

/// Tree over the faces of one master surface.
#[derive(Clone, Debug)]
pub(super) struct FaceTree {
    bvh: Bvh,
}

impl FaceTree {
    pub fn new(boundary: &Boundary, x: &[Vec3]) -> Self {
        let motion = Motion::of_nodes(x, x);
        let boxes: Vec<Aabb> = boundary.faces.iter().map(|f| motion.swept_face(f, 0.0)).collect();
        let mut tree = Self { bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes) };
        // The first refit allocates the memory of the tree.
        tree.refit(boundary, &motion, 0.0);
        tree
    }

    /// Refits to the boxes of this step, each enlarged by the reach of its face and `slack`.
    pub fn refit(&mut self, boundary: &Boundary, motion: &Motion, slack: f64) {
        for (i, face) in boundary.faces.iter().enumerate() {
            let grown = motion.swept_face(face, reach(boundary.sizes[i]) + slack);
            self.bvh.insert_or_update_partially(grown, i as u32, 0.0);
        }
        self.bvh.refit_without_opt();
    }

    /// Whether a point is within the box around all faces.
    fn holds(&self, s: &Vec3) -> bool {
        let (all, point) = (self.bvh.root_aabb(), to_parry(s));
        all.mins.cmple(point).all() && point.cmple(all.maxs).all()
    }

    /// Faces whose boxes are met by a ray from a point along an axis in the direction of `sign`.
    pub fn ahead(&self, point: &Vec3, axis: usize, sign: f64) -> impl Iterator<Item = u32> {
        let point = to_parry(point);
        self.bvh.leaves(move |node: &BvhNode| {
            let (low, high) = (node.mins(), node.maxs());
            (0..3).all(|i| {
                let (from_below, from_above) = (i == axis && sign > 0.0, i == axis && sign < 0.0);
                (from_below || low[i] <= point[i]) && (from_above || point[i] <= high[i])
            })
        })
    }

    /// The closest of all faces with its sign, at any distance, at positions `x` [m] that the list still covers; of
    /// equally close ones the first by number. `None` where the projection onto no face is valid, or all are farther
    /// than `limit` [m].
    pub fn closest(&self, boundary: &Boundary, s: &Vec3, x: &[Vec3], limit: f64) -> Option<Proximity> {
        let (point, best) = (to_parry(s), Cell::new(limit));
        let mut closest: Option<Proximity> = None;
        // A box contains its face wherever that has moved since the list was made, so its distance is never too
        // large.
        let may_be_closer = |node: &BvhNode| {
            let (low, high) = (node.mins(), node.maxs());
            let beyond = (low - point).max(point - high).max(Vector::ZERO);
            beyond.length() <= best.get()
        };
        for face in self.bvh.leaves(may_be_closer) {
            let Some(p) = eval_proximity_within(boundary, face, s, x, best.get()) else { continue };
            if closest.is_none_or(|c| (p.distance, p.face) < (c.distance, c.face)) {
                best.set(p.distance);
                closest = Some(p);
            }
        }
        closest
    }
}

/// A face that the list has for a slave node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub face: u32,
    /// Whether it is beside those around the node, on one surface.
    pub is_beside: bool,
    /// Distance when the list was made, less the reach [m]: displacement of nodes before it becomes relevant.
    pub spare: f64,
}

/// A slave node of the list.
#[derive(Clone, Copy, Debug)]
pub(super) struct Listed {
    pub node: u32,
    /// Index in the nodes of the slave's surface.
    pub place: u32,
    entries: (u32, u32),
    /// The least `spare` of its entries [m].
    spare: f64,
    /// Distance from the closest of all faces when the list was made [m], and whether inside.
    distance: f64,
    is_inside: bool,
}

/// A slave node that may meet something in a step.
pub(super) struct Candidate<F> {
    pub node: u32,
    /// Faces within its reach, ascending by number.
    pub faces: F,
    /// Upper bound of the distance to the closest face [m], if the node may be inside the master: it was, or has
    /// moved that far.
    pub may_be_inside: Option<f64>,
}

/// Slave nodes and faces of one pair that may meet before nodes have moved by `slack`.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    listed: Vec<Listed>,
    entries: Vec<Entry>,
    slack: f64,
}

/// Faces per slave node for which memory is reserved.
const ROOM: usize = 16;

impl Candidates {
    /// Reserves memory for so many slave nodes; lists of more grow with the first that need it.
    pub fn with_capacity(slaves: usize) -> Self {
        Self { listed: Vec::with_capacity(slaves), entries: Vec::with_capacity(ROOM * slaves), slack: 0.0 }
    }

    /// Empties the list for a step, and returns whether it must be filled: surfaces farther apart than the slack [m] need no list until
    /// they have closed in. `clearance` [m] as in [`clearance`].
    pub fn begin(&mut self, slack: f64, clearance: Option<f64>) -> bool {
        self.listed.clear();
        self.entries.clear();
        self.slack = clearance.map_or(slack, |clearance| clearance.max(slack));
        clearance.is_none_or(|clearance| clearance <= slack)
    }

    /// Whether the list still covers everything that may meet, given the largest distances [m] that nodes of the
    /// slave and of the master have moved since it was made, at either end of the step.
    pub fn cover(&self, slave_moved: f64, master_moved: f64) -> bool {
        slave_moved + master_moved <= self.slack
    }

    /// Fills the list for a step, after [`Candidates::begin`], by a `tree` that has been refitted with at least the slack. `excluded`
    /// states which faces a node never meets.
    pub fn fill(
        &mut self,
        slave: &Boundary,
        master: &Boundary,
        tree: &FaceTree,
        motion: &Motion,
        excluded: impl Fn(u32, u32) -> bool,
    ) {
        let slave_is_other = master.is_closed && !std::ptr::eq(slave, master);
        // Neighbouring nodes have similar distances: the last one bounds the search for the next.
        let (mut last, mut distance_of_last) = (Vec3::zeros(), f64::INFINITY);
        for (place, &node) in slave.nodes.iter().enumerate() {
            // Faces whose swept boxes the node's path crosses.
            let start = self.entries.len();
            let s = motion.x[node as usize];
            for face in tree.bvh.intersect_aabb(&motion.segment(node)) {
                if !excluded(node, face) {
                    let patch = Patch::new(&master.faces[face as usize], motion.x);
                    let distance = (patch.closest(&s).point - s).norm();
                    // Subtract a little for rounding.
                    let spare = distance * (1.0 - 1e-9) - reach(master.sizes[face as usize]);
                    let is_beside = std::ptr::eq(slave, master) && master.is_beside(node, face);
                    self.entries.push(Entry { face, is_beside, spare });
                }
            }
            // Signed distance from the closest face, where the master has an inside.
            let (mut distance, mut is_inside) = (f64::INFINITY, false);
            if slave_is_other && tree.holds(&s) {
                let limit =
                    (distance_of_last + (s - last).norm()) * (1.0 + 1e-9) + 1e-9 * master.largest_size;
                let closest = tree.closest(master, &s, motion.x, limit);
                (distance, is_inside) = closest.map_or((distance, false), |p| (p.distance, p.gap < 0.0));
                (last, distance_of_last) = (s, distance);
            }
            if self.entries.len() > start || is_inside {
                let found = &mut self.entries[start..];
                found.sort_unstable_by_key(|e| e.face);
                let spare = found.iter().map(|e| e.spare).fold(f64::INFINITY, f64::min);
                let entries = (start as u32, self.entries.len() as u32);
                // A node inside is held at any distance from the faces.
                let spare = if is_inside { f64::NEG_INFINITY } else { spare };
                self.listed.push(Listed { node, place: place as u32, entries, spare, distance, is_inside });
            }
        }
    }

    /// Rebuilds the list against the half space behind `point` along `normal`; `reach` [m] as in [`reach`].
    pub fn rebuild_plane(
        &mut self,
        slave: &Boundary,
        point: &Vec3,
        normal: &Vec3,
        reach: f64,
        motion: &Motion,
        slack: f64,
    ) {
        self.listed.clear();
        self.entries.clear();
        self.slack = slack;
        for (place, &node) in slave.nodes.iter().enumerate() {
            let height = |x: &[Vec3]| normal.dot(&(x[node as usize] - point)) - reach;
            let spare = height(motion.x);
            if spare.min(height(motion.x_end)) <= slack {
                self.listed.push(Listed {
                    node,
                    place: place as u32,
                    entries: (0, 0),
                    spare,
                    distance: 0.0,
                    is_inside: false,
                });
            }
        }
    }

    /// Number of nodes in the list.
    pub fn len(&self) -> usize {
        self.listed.len()
    }

    /// A `range` of the nodes in the list.
    pub fn listed(&self, range: &Range<usize>) -> &[Listed] {
        &self.listed[range.clone()]
    }

    /// The faces listed for a node, ascending by number.
    pub fn entries(&self, listed: &Listed) -> &[Entry] {
        &self.entries[listed.entries.0 as usize..listed.entries.1 as usize]
    }

    /// The node, if it may meet something in a step in which the two sides have `moved` since the list was made [m].
    pub fn within_reach(
        &self,
        listed: &Listed,
        moved: f64,
    ) -> Option<Candidate<impl Iterator<Item = &Entry> + Clone>> {
        let faces = self.entries(listed).iter().filter(move |e| e.spare <= moved);
        // Add a little for rounding.
        let limit = (listed.distance + moved) * (1.0 + 1e-9);
        let may_be_inside = (listed.is_inside || listed.distance <= moved * (1.0 + 1e-9)).then_some(limit);
        (listed.spare <= moved).then_some(Candidate { node: listed.node, faces, may_be_inside })
    }
}

/// Low and high corner of the box around a surface over a step [m]; `None` if it is empty.
pub(super) type SweptBox = Option<(Vec3, Vec3)>;

/// Distance between the boxes of two surfaces over a step, less the largest reach of any face of the master [m]; `None` if a surface is
/// empty.
pub(super) fn clearance(slave: SweptBox, of_master: SweptBox, master: &Boundary) -> Option<f64> {
    let ((s_low, s_high), (m_low, m_high)) = (slave?, of_master?);
    let apart = (s_low - m_high).sup(&(m_low - s_high)).sup(&Vec3::zeros()).norm();
    Some(apart - reach(master.largest_size))
}

/// The box around a surface over a step.
pub(super) fn swept_box(boundary: &Boundary, motion: &Motion) -> SweptBox {
    let first = motion.x[*boundary.nodes.first()? as usize];
    let ends = boundary.nodes.iter().flat_map(|&n| [&motion.x[n as usize], &motion.x_end[n as usize]]);
    Some(ends.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))))
}
