//! Nodes against faces: the [`Contact`]s of slave nodes with master faces and planes.
//!
//! The rules, for each slave node and each master:
//! - *One face per node and master surface*, except in a valley of another surface, all of whose sides hold the node
//!   (`SIDE` in `finder.rs`): held by the closest side alone, it would slide into the other, and pushing it out again
//!   would do work in every step. The exception applies neither to contacts found by the first time of impact nor
//!   where one face per node is asked for.
//! - A node near a face ([`NEAR`] of the face's size outside, [`DEPTH`] of it inside) is held by the closest face
//!   that is opposed to the slave, in the geometry at the start of the step. A node deeper inside a closed surface is
//!   held by the closest of all faces, which determines its side; in self-contact, and behind an open surface, it is
//!   no contact.
//! - In self-contact a node is deeper than [`BAND`] behind a face only if the surface winds around the place just
//!   outside the node ([`super::winding`]), so that it lies in another part of the body. Otherwise the face is the
//!   far side of the node's own part, which a crushed body does not touch.
//! - Where node and face move by more than [`NEAR`] relative to each other, the first time of impact decides
//!   ([`super::time_of_impact`]): face, normal and weights are those of that time, and the gap is that at the start
//!   along that normal. So no node tunnels, whatever the speed.
//! - Self-contact never pairs a node with faces around it, with their neighbours unless folded onto it, or with the
//!   far side of its own wall at the start of the run, and only with faces opposed to the node's own normal.
//! - Here slave nodes meet master faces only; master nodes in slave faces, and edges, are in [`super::guard`].
//!
//! The result depends on the positions alone, never on the age of the list of the broad phase.

use super::bodies::meeting;
pub use super::broad_phase::reach;
use super::broad_phase::{FaceTree, SweptBox, swept_box};
use super::detector::{DetectionError, Detector, Motion};
use super::finder::Finder;
use super::mirror_image::meet_images;
pub use super::narrow_phase::{BAND, DEPTH, NEAR};
use super::pair::{Moved, PairState, slack};
use super::part::{LEAST, Part, divide, parts_for};
use super::surfaces::PairSurfaces;
use crate::contact::pairs::Pairs;
use crate::contact::{Contact, Master, Surface};
use crate::tensor::Vec3;
use crate::threads::Threads;
use std::sync::Arc;

/// Slack of the list of a surface against itself, as a fraction of its mean face size. The nearest relevant faces are
/// one face away, so hardly any is listed, and hardly any is checked while the surface moves by less relative to
/// itself.
const OWN_SLACK: f64 = 1.0;

/// Number of pairs up to which each has memory for its full list from the start.
const FEW_PAIRS: usize = 64;

/// One of the surfaces of which every two are a pair.
#[derive(Clone, Copy, Debug)]
struct Near {
    surface: usize,
    /// How far its nodes may move before the pairs in reach are found anew [m].
    slack: f64,
}

/// Finds the contacts of slave nodes; stores a list of candidates.
#[derive(Clone, Debug)]
pub struct NodeToFace {
    surfaces: PairSurfaces,
    /// Listed pairs, and those of every two surfaces whose boxes met when the lists were made, ascending by number.
    states: Vec<PairState>,
    /// Buffers of pairs that are no longer near.
    idle: Vec<PairState>,
    /// The surfaces of which every two are a pair, as of the last search for those in reach.
    near: Vec<Near>,
    /// Whether all sides of a valley hold a node.
    holds_valleys: bool,
    /// Tree over the faces of each surface that is the master of another one, refitted where one of its pairs needs a list.
    trees: Vec<Option<FaceTree>>,
    /// Room for the boxes of the surfaces, and for the slack of each tree [m], negative where no pair needs it.
    boxes: Vec<SweptBox>,
    slacks: Vec<f64>,
    /// Whether a surface meets more than itself.
    meets_others: Vec<bool>,
    /// Positions of each surface's nodes when the lists were made.
    snapshots: Vec<Vec<Vec3>>,
    /// Displacement of each surface in the present step.
    moved: Vec<Moved>,
    /// Slack of lists of self-contact, as a fraction of the mean face size.
    own_slack: f64,
    /// Parts of the list of each pair of two surfaces in turn.
    parts: Vec<Part>,
    threads: Threads,
}

impl NodeToFace {
    /// For the pairs of meshes and planes; `x` [m] are the positions of all nodes *at the start of the run* (also for a
    /// restart). Pairs with a rigid side are left to [`super::rigid_detection`].
    pub fn new(surfaces: &[Surface], pairs: &Pairs, x: &[Vec3]) -> Self {
        Self::of(PairSurfaces::new(surfaces, pairs, x), x)
    }

    /// As [`NodeToFace::new`], of surfaces that are known.
    pub(super) fn of(surfaces: PairSurfaces, x: &[Vec3]) -> Self {
        let PairSurfaces { boundaries, pairs } = &surfaces;
        let (are_few, rest) = (pairs.len() <= FEW_PAIRS, Arc::from(x));
        let states: Vec<PairState> =
            pairs.listed().filter_map(|p| PairState::new(p, boundaries, &rest, are_few)).collect();
        let moved = vec![Moved::default(); boundaries.len()];
        let others = || states.iter().filter(|pair| pair.own.is_none());
        let mut trees: Vec<Option<FaceTree>> = vec![None; boundaries.len()];
        let mut meets_others = vec![true; boundaries.len()];
        for pair in states.iter().filter(|pair| pair.own.is_some()) {
            meets_others[pair.slave] = false;
        }
        let of_others = others().filter_map(|pair| pair.side.master());
        for master in of_others.chain(pairs.every_two().surfaces()) {
            meets_others[master] = true;
            trees[master].get_or_insert_with(|| FaceTree::new(&boundaries[master], x));
        }
        for pair in others() {
            meets_others[pair.slave] = true;
        }
        let most_nodes = boundaries.iter().map(|boundary| boundary.nodes.len()).max().unwrap_or(0);
        Self {
            boxes: Vec::with_capacity(boundaries.len()),
            slacks: Vec::with_capacity(boundaries.len()),
            trees,
            meets_others,
            surfaces,
            states,
            idle: Vec::new(),
            near: Vec::new(),
            holds_valleys: true,
            snapshots: Vec::new(),
            moved,
            own_slack: OWN_SLACK,
            parts: parts_for(most_nodes),
            threads: Threads::ONE,
        }
    }

    /// Searches long lists on several threads.
    #[must_use]
    pub fn on(self, threads: &Threads) -> Self {
        Self { threads: threads.clone(), ..self }
    }

    /// Checks for self-contact in every step, even where nothing can have come near since the last one.
    #[must_use]
    pub fn with_self_contact_in_every_step(mut self) -> Self {
        self.own_slack = 0.0;
        self
    }

    /// Holds a node by the closest face alone, in a valley too.
    #[must_use]
    pub(super) fn with_one_face_per_node(self) -> Self {
        Self { holds_valleys: false, ..self }
    }

    /// Appends the contacts, in the order of [`Contact::key`]; returns whether the lists of the broad phase were rebuilt.
    ///
    /// # Errors
    /// [`DetectionError::NotFinite`]; nothing is appended then.
    pub fn find(&mut self, motion: &Motion, contacts: &mut Vec<Contact>) -> Result<bool, DetectionError> {
        let rebuilt = self.update_lists(motion)?;
        let holds_valleys = self.holds_valleys;
        let Self { surfaces, states, trees, snapshots, moved, parts: of_others, threads, .. } = self;
        let boundaries = &surfaces.boundaries;
        for pair in states.iter_mut() {
            let master_moved = match &pair.own {
                Some(own) => Moved { since_list: own.since_list, in_step: own.in_step },
                None => pair.side.master().map_or(Moved::default(), |master| moved[master]),
            };
            let mut parts = std::mem::take(if pair.own.is_some() { &mut pair.parts } else { of_others });
            let count = pair.candidates.len();
            if pair.own.is_none() {
                divide(&mut parts, count);
            }
            let snapshot = &snapshots[pair.slave];
            let motion = *motion;
            let finder = Finder { pair, boundaries, trees, snapshot, motion, master_moved, holds_valleys };
            let threads = if count > LEAST { &*threads } else { &Threads::ONE };
            threads.for_each(&mut parts, |part| finder.find(part));
            let first = contacts.len();
            for part in &mut parts {
                contacts.append(&mut part.contacts);
            }
            if pair.own.is_some() {
                let found = contacts.len();
                meet_images(&boundaries[pair.slave], pair.number, &motion, contacts);
                if contacts.len() > found {
                    contacts[first..].sort_unstable_by_key(Contact::key);
                }
            }
            *(if pair.own.is_some() { &mut pair.parts } else { &mut *of_others }) = parts;
        }
        Ok(rebuilt)
    }

    /// Rebuilds lists that no longer cover this step; returns whether any was.
    fn update_lists(&mut self, motion: &Motion) -> Result<bool, DetectionError> {
        let mut rebuilt = self.update_lists_of_others(motion)?;
        let Self { surfaces, states, own_slack, .. } = self;
        let boundaries = &surfaces.boundaries;
        for pair in states.iter_mut().filter(|pair| pair.own.is_some()) {
            let slave = pair.slave;
            let updated = pair.update_own_list(boundaries, motion, *own_slack * boundaries[slave].mean_size);
            rebuilt |= updated.ok_or(DetectionError::NotFinite { surface: slave })?;
        }
        Ok(rebuilt)
    }

    /// Updates the lists of pairs of two surfaces, or of a surface and a plane: all or none.
    fn update_lists_of_others(&mut self, motion: &Motion) -> Result<bool, DetectionError> {
        if !self.snapshots.is_empty() {
            self.measure_motion(motion)?;
            let covered = self.states.iter().filter(|pair| pair.own.is_none()).all(|pair| {
                let of_master = pair.side.master().map_or(0.0, |master| self.moved[master].since_list);
                pair.candidates.cover(self.moved[pair.slave].since_list, of_master)
            });
            if covered && self.near.iter().all(|near| self.moved[near.surface].since_list <= near.slack) {
                return Ok(false);
            }
        }
        let boundaries = self.surfaces.boundaries.clone();
        self.snapshots.resize_with(boundaries.len(), Vec::new);
        for (boundary, snapshot) in boundaries.iter().zip(&mut self.snapshots) {
            snapshot.clear();
            snapshot.extend(boundary.nodes.iter().map(|&n| motion.x[n as usize]));
        }
        self.measure_motion(motion)?;
        self.boxes.clear();
        self.boxes.extend(boundaries.iter().map(|boundary| swept_box(boundary, motion)));
        self.find_near_pairs();
        // Which pairs are near, and how far their lists reach; then one tree for all pairs of a master.
        let Self { states, trees, boxes, slacks, moved, .. } = self;
        slacks.clear();
        slacks.resize(boundaries.len(), -1.0);
        for pair in states.iter_mut().filter(|pair| pair.own.is_none()) {
            let of_master = pair.side.master().map_or(0.0, |master| moved[master].in_step);
            let in_step = moved[pair.slave].in_step + of_master;
            if let Some((master, slack)) = pair.begin_list(&boundaries, boxes, motion, in_step) {
                slacks[master] = slacks[master].max(slack);
            }
        }
        for ((tree, boundary), slack) in trees.iter_mut().zip(boundaries.iter()).zip(slacks.iter()) {
            if let (Some(tree), true) = (tree, *slack >= 0.0) {
                tree.refit(boundary, motion, *slack);
            }
        }
        for pair in states.iter_mut().filter(|pair| pair.own.is_none()) {
            pair.fill_list(&boundaries, trees, motion);
        }
        Ok(true)
    }

    /// Of every two surfaces, takes up the pairs that may come within reach before one of the two has moved by its slack.
    fn find_near_pairs(&mut self) {
        let PairSurfaces { boundaries, pairs } = &self.surfaces;
        let every = pairs.every_two();
        if every.is_empty() {
            return;
        }
        // The others follow the listed ones.
        let listed = self.states.partition_point(|state| (state.number as usize) < pairs.unlisted().start);
        self.idle.extend(self.states.drain(listed..));
        self.near.clear();
        self.near.extend(every.surfaces().map(|surface| {
            let boundary = &boundaries[surface];
            Near { surface, slack: slack(self.moved[surface].in_step, boundary.mean_size) }
        }));
        let grown = |near: &Near| {
            let [low, high] =
                self.boxes[near.surface].map_or([Vec3::repeat(f64::INFINITY); 2], |(l, h)| [l, h]);
            // Faces reach a part of their size, edges a part of their length.
            let edges = NEAR * (high - low).norm();
            let reach = near.slack + reach(boundaries[near.surface].largest_size) + edges;
            [low.add_scalar(-reach), high.add_scalar(reach)]
        };
        let boxes: Vec<[Vec3; 2]> = self.near.iter().map(grown).collect();
        for (first, second) in meeting(&boxes) {
            let number = pairs.unlisted().start + every.number(first, second);
            let pair = pairs.get(number);
            let Master::Surface(master) = pair.master else { continue };
            self.states.push(PairState::of_two(number, [pair.slave, master], self.idle.pop()));
        }
    }

    fn measure_motion(&mut self, motion: &Motion) -> Result<(), DetectionError> {
        for (surface, boundary) in self.surfaces.boundaries.iter().enumerate() {
            // Surfaces that may meet only themselves are measured by their relative motion instead.
            if !self.meets_others[surface] {
                continue;
            }
            let (mut since_list, mut in_step): (f64, f64) = (0.0, 0.0);
            let mut check = 0.0;
            for (&node, old) in boundary.nodes.iter().zip(&self.snapshots[surface]) {
                let (x, x_end) = (motion.x[node as usize], motion.x_end[node as usize]);
                let start = (x - old).norm_squared();
                let end = (x_end - old).norm_squared();
                let step = (x_end - x).norm_squared();
                // Plain comparisons drop a NaN, which shows in the sum.
                since_list = if start > since_list { start } else { since_list };
                since_list = if end > since_list { end } else { since_list };
                in_step = if step > in_step { step } else { in_step };
                check += start + step;
            }
            if !check.is_finite() {
                return Err(DetectionError::NotFinite { surface });
            }
            self.moved[surface] = Moved { since_list: since_list.sqrt(), in_step: in_step.sqrt() };
        }
        Ok(())
    }

    /// The surfaces of its pairs.
    pub(super) fn surfaces(&self) -> &PairSurfaces {
        &self.surfaces
    }

    /// Number and slave surface of each listed or near pair, and its master surface unless that is a plane.
    pub(super) fn sides(&self) -> impl Iterator<Item = (usize, usize, Option<usize>)> {
        self.states.iter().map(|p| (p.number as usize, p.slave, p.side.master()))
    }

    /// Number, slave and master surface of each listed or near pair of two different surfaces.
    pub(super) fn pairs_of_two(&self) -> impl Iterator<Item = (u32, [usize; 2])> {
        let others = self.states.iter().filter(|pair| pair.own.is_none());
        others.filter_map(|pair| Some((pair.number, [pair.slave, pair.side.master()?])))
    }
}

impl Detector for NodeToFace {
    fn detect(&mut self, motion: &Motion, contacts: &mut Vec<Contact>) -> Result<(), DetectionError> {
        self.find(motion, contacts).map(|_| ())
    }
}

#[cfg(test)]
mod tests;
