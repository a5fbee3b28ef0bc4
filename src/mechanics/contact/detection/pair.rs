//! A contact pair in detection: its sides, and the candidates that the broad phase lists for it.

use super::boundary::Boundary;
use super::broad_phase::{Candidates, FaceTree, SweptBox, clearance, reach};
use super::detector::Motion;
use super::frame::local_frame;
use super::part::{Part, divide, parts_for};
use super::self_contact::{Exclusions, OwnMotion};
use crate::contact::{ContactPair, Master};
use crate::tensor::Vec3;
use std::sync::Arc;

/// Number of steps of the present motion for which a list is made, within the bounds below.
const STEPS_PER_LIST: f64 = 12.0;
/// Bounds of the slack of a list, as fractions of the mean face size.
const SLACK_BOUNDS: (f64, f64) = (0.25, 1.0);

/// A pair, with the data that detection stores for it.
#[derive(Clone, Debug)]
pub(super) struct PairState {
    /// Number of the pair.
    pub number: u32,
    /// Index of the slave's surface.
    pub slave: usize,
    /// The obstacle that the slave must not enter.
    pub side: Side,
    /// Slave nodes and master faces that may meet.
    pub candidates: Candidates,
    /// Whether the list was begun and must be filled.
    must_fill: bool,
    /// Motion of the surface relative to itself, in self-contact.
    pub own: Option<OwnMotion>,
    /// Parts of the list, in self-contact: they remember which of their nodes are far from everything.
    pub parts: Vec<Part>,
}

/// Distance [m] by which a list reaches farther than a step of so much motion [m], for faces of this mean size [m].
pub(super) fn slack(in_step: f64, size: f64) -> f64 {
    (STEPS_PER_LIST * in_step).clamp(SLACK_BOUNDS.0 * size, SLACK_BOUNDS.1 * size)
}

/// A master, prepared for detection.
#[derive(Clone, Debug)]
pub(super) enum Side {
    /// Against itself with a tree of its own, and the faces that are excluded.
    Surface {
        master: usize,
        itself: Option<(FaceTree, Exclusions)>,
    },
    Plane {
        point: Vec3,
        frame: [Vec3; 3],
        size: f64,
    },
}

/// Largest displacements of the nodes of a surface.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moved {
    /// Since the lists were made, to either end of the step [m].
    pub since_list: f64,
    /// Within the step [m].
    pub in_step: f64,
}

impl Side {
    /// Index of the master's surface, `None` for a plane.
    pub fn master(&self) -> Option<usize> {
        match self {
            Self::Surface { master, .. } => Some(*master),
            Self::Plane { .. } => None,
        }
    }
}

impl PairState {
    /// State of a pair at the start, with memory for a full list if it is one of few; `None` for a rigid master.
    pub fn new(
        (number, pair): (usize, &ContactPair),
        boundaries: &[Boundary],
        x: &Arc<[Vec3]>,
        is_one_of_few: bool,
    ) -> Option<Self> {
        let side = match pair.master {
            Master::Rigid(_) => return None,
            Master::Surface(master) => Side::Surface {
                master,
                itself: (master == pair.slave)
                    .then(|| (FaceTree::new(&boundaries[master], x), Exclusions::new(x))),
            },
            Master::Plane { point, normal } => Side::Plane {
                point,
                frame: local_frame(&normal, &Vec3::zeros()),
                size: boundaries[pair.slave].mean_size,
            },
        };
        let slaves = if is_one_of_few { boundaries[pair.slave].nodes.len() } else { 0 };
        let candidates = Candidates::with_capacity(slaves);
        let own = (side.master() == Some(pair.slave)).then(OwnMotion::default);
        let parts = if own.is_some() { parts_for(slaves) } else { Vec::new() };
        let (number, slave) = (number as u32, pair.slave);
        Some(Self { number, slave, side, candidates, must_fill: false, own, parts })
    }

    /// The state of a pair of two surfaces, in the buffers of another one if there is such.
    pub fn of_two(number: usize, [slave, master]: [usize; 2], buffers: Option<Self>) -> Self {
        let candidates = buffers.map_or_else(|| Candidates::with_capacity(0), |state| state.candidates);
        let (number, side) = (number as u32, Side::Surface { master, itself: None });
        Self { number, slave, side, candidates, must_fill: false, own: None, parts: Vec::new() }
    }

    /// For a surface against itself: rebuilds the list with the given `slack` [m] if it does not cover this step, and
    /// returns whether it did. `None` if a position is not finite.
    pub fn update_own_list(&mut self, boundaries: &[Boundary], motion: &Motion, slack: f64) -> Option<bool> {
        let (boundary, own) = (&boundaries[self.slave], self.own.as_mut()?);
        if own.has_started() {
            if !own.measure(boundary, motion) {
                return None;
            }
            if self.candidates.cover(own.since_list, 0.0) {
                return Some(false);
            }
        }
        own.restart(boundary, motion);
        if !own.measure(boundary, motion) {
            return None;
        }
        if let Side::Surface { itself: Some((tree, exclusions)), .. } = &mut self.side {
            tree.refit(boundary, motion, slack);
            let excluded = |node, face| exclusions.contain(boundary, node, face);
            self.candidates.begin(slack, None);
            self.candidates.fill(boundary, boundary, tree, motion, excluded);
        }
        divide(&mut self.parts, self.candidates.len());
        self.parts.iter_mut().for_each(Part::restart);
        Some(true)
    }

    /// Begins a new list against another surface, or makes that against a plane. Returns the master and the slack [m] of a list that must
    /// be filled. `in_step` [m]: upper bound of the relative motion of the two sides in this step; `boxes` of all surfaces.
    pub fn begin_list(
        &mut self,
        boundaries: &[Boundary],
        boxes: &[SweptBox],
        motion: &Motion,
        in_step: f64,
    ) -> Option<(usize, f64)> {
        let slave = &boundaries[self.slave];
        match &self.side {
            Side::Surface { master: index, .. } => {
                let master = &boundaries[*index];
                let slack = slack(in_step, master.mean_size);
                let clearance = clearance(boxes[self.slave], boxes[*index], master);
                self.must_fill = self.candidates.begin(slack, clearance);
                self.must_fill.then_some((*index, slack))
            }
            Side::Plane { point, frame, size } => {
                self.candidates.rebuild_plane(
                    slave,
                    point,
                    &frame[0],
                    reach(*size),
                    motion,
                    slack(in_step, *size),
                );
                None
            }
        }
    }

    /// Fills the list that was begun, if it must be, by the `trees` of the masters.
    pub fn fill_list(&mut self, boundaries: &[Boundary], trees: &[Option<FaceTree>], motion: &Motion) {
        let master = self.side.master().filter(|_| std::mem::take(&mut self.must_fill));
        if let Some((master, tree)) = master.and_then(|master| Some((master, trees[master].as_ref()?))) {
            let (slave, master) = (&boundaries[self.slave], &boundaries[master]);
            self.candidates.fill(slave, master, tree, motion, |_, _| false);
        }
    }
}
