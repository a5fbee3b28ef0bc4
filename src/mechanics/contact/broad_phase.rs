//! Which faces a slave node may meet: a list made with a tree of swept boxes, and kept while nodes have moved little.
//!
//! The list only saves time. It holds every pair that the narrow phase could accept, so that its age never changes a
//! result.

use super::closest_point::Patch;
use super::narrow_phase::{DEPTH, NEAR};
use super::skin::Skin;
use crate::mechanics::tensor::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

/// Positions at both ends of a step: absolute at its start, and at its end if there were no contact [m].
#[derive(Clone, Copy)]
pub(super) struct Motion<'a> {
    pub x: &'a [Vec3],
    pub x_end: &'a [Vec3],
}

impl Motion<'_> {
    fn segment(&self, node: u32) -> Aabb {
        let (p, q) = (self.x[node as usize], self.x_end[node as usize]);
        Aabb::new(to_parry(&p.inf(&q)), to_parry(&p.sup(&q)))
    }

    /// Box of a face over the step, grown by `margin`.
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

fn to_parry(p: &Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

/// How far a node must be from a face of this size [m] before it is out of the narrow phase's reach [m].
pub fn reach(size: f64) -> f64 {
    NEAR.max(DEPTH) * size
}

/// The tree over the faces of one master surface.
#[derive(Clone, Debug)]
pub(super) struct FaceTree {
    bvh: Bvh,
}

impl FaceTree {
    pub fn new(skin: &Skin, x: &[Vec3]) -> Self {
        let motion = Motion { x, x_end: x };
        let boxes: Vec<Aabb> = skin.faces.iter().map(|f| motion.swept_face(f, 0.0)).collect();
        Self { bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes) }
    }

    /// Boxes of this step, grown by each face's reach and `slack`.
    fn refit(&mut self, skin: &Skin, motion: &Motion, slack: f64) {
        for (i, face) in skin.faces.iter().enumerate() {
            let grown = motion.swept_face(face, reach(skin.sizes[i]) + slack);
            self.bvh.insert_or_update_partially(grown, i as u32, 0.0);
        }
        self.bvh.refit_without_opt();
    }
}

/// A face of the list, with how far nodes must have moved before it matters [m].
#[derive(Clone, Copy, Debug)]
struct Entry {
    face: u32,
    /// Distance when the list was made, less the reach.
    spare: f64,
}

/// A slave node of the list.
#[derive(Clone, Copy, Debug)]
struct Listed {
    node: u32,
    /// Its place in the slave's surface.
    place: u32,
    entries: (u32, u32),
    /// The least `spare` of its entries.
    spare: f64,
}

/// Slave nodes and faces of one pair that may meet before nodes have moved by `slack`.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    listed: Vec<Listed>,
    entries: Vec<Entry>,
    slack: f64,
}

/// Faces of each slave node that there is room for.
const ROOM: usize = 16;

impl Candidates {
    /// With room for so many slave nodes.
    pub fn with_capacity(slaves: usize) -> Self {
        Self { listed: Vec::with_capacity(slaves), entries: Vec::with_capacity(ROOM * slaves), slack: 0.0 }
    }

    /// Whether the list still covers all that may meet: the largest distances [m] that nodes of the slave and of the
    /// master have moved, to either end of the step, since it was made.
    pub fn cover(&self, slave_moved: f64, master_moved: f64) -> bool {
        slave_moved + master_moved <= self.slack
    }

    /// Makes the list anew for a step. `excluded` says which faces a node never meets.
    pub fn rebuild(
        &mut self,
        slave: &Skin,
        master: &Skin,
        tree: &mut FaceTree,
        motion: &Motion,
        slack: f64,
        excluded: impl Fn(u32, u32) -> bool,
    ) {
        self.listed.clear();
        self.entries.clear();
        self.slack = slack;
        if let Some(clearance) = clearance(slave, master, motion)
            && clearance > slack
        {
            self.slack = clearance;
            return;
        }
        tree.refit(master, motion, slack);
        for (place, &node) in slave.nodes.iter().enumerate() {
            let start = self.entries.len();
            let s = motion.x[node as usize];
            for face in tree.bvh.intersect_aabb(&motion.segment(node)) {
                if !excluded(node, face) {
                    let patch = Patch::new(&master.faces[face as usize], motion.x);
                    let distance = (patch.closest(&s).point - s).norm();
                    // A hair is given away to rounding.
                    let spare = distance * (1.0 - 1e-9) - reach(master.sizes[face as usize]);
                    self.entries.push(Entry { face, spare });
                }
            }
            if self.entries.len() > start {
                let found = &mut self.entries[start..];
                found.sort_unstable_by_key(|e| e.face);
                let spare = found.iter().map(|e| e.spare).fold(f64::INFINITY, f64::min);
                let entries = (start as u32, self.entries.len() as u32);
                self.listed.push(Listed { node, place: place as u32, entries, spare });
            }
        }
    }

    /// Makes the list anew against the half space behind `point` along `normal`; `reach` [m] as in [`reach`].
    pub fn rebuild_plane(
        &mut self,
        slave: &Skin,
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
                self.listed.push(Listed { node, place: place as u32, entries: (0, 0), spare });
            }
        }
    }

    /// The nodes that may meet something in a step, each with its faces in ascending order. `slave_moved(place, node)` and
    /// `master_moved` [m] as in [`Candidates::cover`].
    pub fn within_reach(
        &self,
        slave_moved: impl Fn(usize, u32) -> f64,
        master_moved: f64,
    ) -> impl Iterator<Item = (u32, impl Iterator<Item = u32> + Clone)> {
        self.listed.iter().filter_map(move |l| {
            let moved = slave_moved(l.place as usize, l.node) + master_moved;
            let entries = &self.entries[l.entries.0 as usize..l.entries.1 as usize];
            let faces = entries.iter().filter(move |e| e.spare <= moved).map(|e| e.face);
            (l.spare <= moved).then_some((l.node, faces))
        })
    }
}

/// How far the boxes of two surfaces over a step are apart, beyond what any face reaches [m]; `None` if a surface is
/// empty.
fn clearance(slave: &Skin, master: &Skin, motion: &Motion) -> Option<f64> {
    let (s_low, s_high) = swept_box(slave, motion)?;
    let (m_low, m_high) = swept_box(master, motion)?;
    let apart = (s_low - m_high).sup(&(m_low - s_high)).sup(&Vec3::zeros()).norm();
    Some(apart - reach(master.largest_size))
}

fn swept_box(skin: &Skin, motion: &Motion) -> Option<(Vec3, Vec3)> {
    let first = motion.x[*skin.nodes.first()? as usize];
    let ends = skin.nodes.iter().flat_map(|&n| [&motion.x[n as usize], &motion.x_end[n as usize]]);
    Some(ends.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))))
}
