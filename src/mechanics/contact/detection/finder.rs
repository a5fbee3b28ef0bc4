//! The contacts of one pair in one step: each slave node against the faces retained by the broad phase.

use super::boundary::Boundary;
use super::broad_phase::{Candidate, Entry, FaceTree, Listed};
use super::closest_point::Patch;
use super::detector::Motion;
use super::frame::local_frame;
use super::narrow_phase::{BAND, NEAR, OPPOSED, Proximity, choose_face, eval_proximity, eval_within};
use super::pair::{Moved, PairState, Side};
use super::part::Part;
use super::self_contact::OwnMotion;
use super::time_of_impact::{Impact, Search};
use super::winding::winding_number;
use crate::contact::kind::{Identity, Kind};
use crate::contact::stencil::Stencil;
use crate::contact::{Contact, ContactLaw};
use crate::tensor::Vec3;
use std::cell::OnceCell;

/// Gap below which node and face touch, as a fraction of the face's size.
const TOUCH: f64 = 1e-6;
/// Offset of the place outside a node towards the middle of a face, per unit of its distance along the node's normal.
/// Below 1 it stays on its side of a plane surface, whatever the orientation; at a corner of right angles 0.82 keep
/// it over the face.
const INWARDS: f64 = 0.9;
/// Cosine between the normals of node and face below which they are opposed.
const WELL_OPPOSED: f64 = -0.5;

/// Cosine between the normals of two faces above which a node held by one is not also held by the other: it slides on
/// smoothly.
pub const VALLEY: f64 = 0.9;

/// A further face at the node, in a valley; frictionless, since the distribution of friction between two opposing sides is not
/// determined, and sweeps do not find it.
pub(super) const SIDE: Kind = Kind { has_friction: false, identity: Identity::Normal, ..Kind::NODE };

/// Finds the contacts of one pair in one step.
pub(super) struct Finder<'a> {
    pub pair: &'a PairState,
    pub boundaries: &'a [Boundary],
    /// Trees of the masters of other surfaces.
    pub trees: &'a [Option<FaceTree>],
    /// Positions of the slave's nodes when the list was made; not in self-contact.
    pub snapshot: &'a [Vec3],
    pub motion: Motion<'a>,
    pub master_moved: Moved,
    /// Whether all sides of a valley of another surface hold a node, or the closest alone.
    pub holds_valleys: bool,
}

impl Finder<'_> {
    /// Finds the contacts of a part of the list.
    pub fn find(&self, part: &mut Part) {
        part.contacts.clear();
        match self.pair.side {
            Side::Plane { point, frame, size } => {
                for listed in self.pair.candidates.listed(&part.range) {
                    if self.pair.candidates.within_reach(listed, self.moved(listed)).is_some() {
                        part.contacts.extend(self.against_plane(listed.node, &point, &frame, size));
                    }
                }
            }
            Side::Surface { master, ref itself } => {
                let own = itself.as_ref().map(|(tree, _)| tree);
                let Some(tree) = own.or(self.trees[master].as_ref()) else { return };
                self.find_on_surface((&self.boundaries[master], tree), part);
            }
        }
    }

    fn find_on_surface(&self, (master, tree): (&Boundary, &FaceTree), part: &mut Part) {
        let Part { range, contacts, inactive_until, search } = part;
        let candidates = &self.pair.candidates;
        for (i, listed) in candidates.listed(range).iter().enumerate() {
            let moved = match &self.pair.own {
                Some(own) => match self.moved_in_reach(own, listed, &mut inactive_until[i]) {
                    Some(moved) => moved,
                    None => continue,
                },
                None => self.moved(listed) + self.master_moved.since_list,
            };
            let Some(candidate) = candidates.within_reach(listed, moved) else { continue };
            let faces = candidate.faces.clone().map(|entry| entry.face);
            let found = self.against_surface((master, tree), candidate, search);
            let first = contacts.len();
            if let Some((contact, is_impact)) = found {
                contacts.push(contact);
                if !is_impact && self.holds_valleys && self.pair.own.is_none() {
                    self.add_sides_of_valley(master, faces, first, contacts);
                }
            }
        }
    }

    /// Displacement [m] of a listed node of another surface since the list was made, to either end of the step.
    fn moved(&self, listed: &Listed) -> f64 {
        let (x, x_end) = (self.motion.x[listed.node as usize], self.motion.x_end[listed.node as usize]);
        let old = self.snapshot[listed.place as usize];
        (x - old).norm_squared().max((x_end - old).norm_squared()).sqrt()
    }

    /// In self-contact: upper bound of the displacement [m] of a node relative to its listed faces since the list was made, to either end
    /// of the step; `None` if it can reach none of them in this step.
    fn moved_in_reach(&self, own: &OwnMotion, listed: &Listed, inactive_until: &mut f64) -> Option<f64> {
        if own.travel + own.closing < *inactive_until {
            return None;
        }
        // From where the node is now, as far as the surface must move relative to itself before the first face matters.
        let boundary = &self.boundaries[self.pair.slave];
        let (mut spare, mut moved) = (f64::INFINITY, 0.0_f64);
        for entry in self.pair.candidates.entries(listed) {
            let relative = own.relative_to(boundary, listed.place as usize, entry.face, self.motion.x);
            spare = spare.min(entry.spare - relative);
            moved = moved.max(relative);
        }
        *inactive_until = own.travel + spare;
        (spare <= own.closing).then_some((moved + own.closing).min(own.since_list))
    }

    fn against_plane(&self, node: u32, point: &Vec3, frame: &[Vec3; 3], size: f64) -> Option<Contact> {
        let gap = |x: &[Vec3]| frame[0].dot(&(x[node as usize] - point));
        let (start, end) = (gap(self.motion.x), gap(self.motion.x_end));
        (start.min(end) <= NEAR * size).then_some(Contact {
            pair: self.pair.number,
            kind: Kind::NODE,
            slave: node,
            face: u32::MAX,
            stencil: Stencil::of_node(node),
            frame: *frame,
            gap: start,
            point: self.motion.x[node as usize],
            drift: Vec3::zeros(),
            law: ContactLaw::Frictionless,
        })
    }

    /// The contact of a slave node with one of `faces`, and whether it was found by its time of impact.
    fn against_surface<'a>(
        &self,
        (master, tree): (&Boundary, &FaceTree),
        Candidate { node, faces, may_be_inside }: Candidate<impl Iterator<Item = &'a Entry> + Clone>,
        search: &mut Search,
    ) -> Option<(Contact, bool)> {
        let Motion { x, x_end, .. } = self.motion;
        let (s, s_end) = (x[node as usize], x_end[node as usize]);
        let slave = &self.boundaries[self.pair.slave];
        let same_surface = std::ptr::eq(slave, master);
        let normal = OnceCell::new();
        // Faces beside those around the node meet it where the surface is folded onto itself; elsewhere they are its
        // neighbours.
        let is_folded = |face: u32| {
            let patch = Patch::new(&master.faces[face as usize], x);
            normal.get_or_init(|| slave.node_normal(node, x)).dot(&patch.normal(&[0.25; 4])) < WELL_OPPOSED
        };
        let far = faces.clone().filter(|entry| !entry.is_beside).map(|entry| entry.face);
        let faces = faces.filter(|entry| !entry.is_beside || is_folded(entry.face)).map(|entry| entry.face);
        // The closest face at the start of the step; in self-contact one in front instead, if this one is not really
        // entered.
        let mut near = choose_face(master, &faces, &s, || slave.node_normal(node, x), x);
        if near.is_some_and(|p| p.gap < 0.0 && self.is_behind_in_name_only((master, tree), node, &p)) {
            let in_front = |face: &u32| eval_proximity(master, *face, &s, x).is_some_and(|p| p.gap >= 0.0);
            near = choose_face(master, &faces.clone().filter(in_front), &s, || slave.node_normal(node, x), x);
        }
        // A node deep inside a closed surface is held by the closest of all faces.
        if near.is_none()
            && let Some(limit) = may_be_inside
            && master.is_closed
            && !same_surface
            && let Some(p) = tree.closest(master, &s, x, limit).filter(|p| p.gap < 0.0)
        {
            return Some((self.near_contact(master, node, &p), false));
        }
        // Faces that move far relative to the node; in the usual step there are none.
        let fast =
            |face: &u32| self.relative_motion(master, *face, node) > NEAR * master.sizes[*face as usize];
        let bound = (s_end - s).norm() + self.master_moved.in_step;
        let mut quick =
            far.filter(|f| bound > NEAR * master.sizes[*f as usize] * (1.0 - 1e-9)).filter(fast).peekable();
        if quick.peek().is_none() {
            return near.map(|p| (self.near_contact(master, node, &p), false));
        }
        // Their first impact.
        let mut first: Option<(Impact, u32)> = None;
        for face in quick {
            let nodes = &master.faces[face as usize];
            let (start, end) = (Patch::new(nodes, x), Patch::new(nodes, x_end));
            let before = first.map_or(f64::INFINITY, |(hit, _)| hit.tau);
            if let Some(hit) = search.first_impact(&start, &end, &s, &s_end, before)
                && !(same_surface && self.faces_away(master, face, &hit, node))
            {
                first = Some((hit, face));
            }
        }
        // Which faces move fast depends on which are listed; the result must not. So a face that itself moves little
        // holds the node as in the usual step, whatever another face does far from it.
        let near = near.filter(|p| self.holds(master, p, node, fast(&p.face), first.is_some()));
        match (near, first) {
            (Some(p), _) => Some((self.near_contact(master, node, &p), false)),
            (None, Some((hit, face))) => Some((self.impact_contact(master, node, face, &hit), true)),
            (None, None) => None,
        }
    }

    /// Adds the other faces that hold the node of the contact at `first`, by face: in a valley a node held by one
    /// side alone slides into the other, step by step. There the two sides are in front of each other; on a ridge the
    /// closest face suffices.
    fn add_sides_of_valley(
        &self,
        master: &Boundary,
        faces: impl Iterator<Item = u32>,
        first: usize,
        contacts: &mut Vec<Contact>,
    ) {
        let x = self.motion.x;
        let node = contacts[first].slave;
        let s = x[node as usize];
        let held_along = contacts[first].frame[0];
        let patch = |face: u32| Patch::new(&master.faces[face as usize], x);
        let middle = |face: u32| patch(face).point(&[0.25; 4]);
        let own = OnceCell::new();
        // Most faces continue the held one smoothly.
        for face in faces.filter(|&face| held_along.dot(&patch(face).normal(&[0.25; 4])) < VALLEY) {
            let Some(p) = eval_within(master, face, &s, x, None).filter(|p| !p.beyond) else { continue };
            let stands_before = |held: &Contact| {
                let n = &held.frame[0];
                let (on_face, on_held) = (s - p.normal * p.gap, s - n * held.gap);
                n.dot(&p.normal) < VALLEY
                    && n.dot(&(middle(face) - on_held)) > 0.0
                    && p.normal.dot(&(middle(held.face) - on_face)) > 0.0
            };
            let is_opposed = || {
                let own = own.get_or_init(|| self.boundaries[self.pair.slave].node_normal(node, x));
                *own == Vec3::zeros() || own.dot(&p.normal) < OPPOSED
            };
            if p.gap <= NEAR * master.sizes[face as usize]
                && contacts[first..].iter().all(stands_before)
                && is_opposed()
            {
                contacts.push(Contact { kind: SIDE, ..self.near_contact(master, node, &p) });
            }
        }
        contacts[first..].sort_unstable_by_key(|contact| contact.face);
    }

    /// Whether a node behind a face of its own surface lies in the same part of the body as the face: then the
    /// surface winds neither around the place just outside the node nor, where the two are well opposed, around the
    /// place behind it as seen from the face. Nearer than [`BAND`] both are taken to touch.
    ///
    /// The place outside the node is also shifted slightly towards the middle of the face, so that coincident edges
    /// do not leave the decision to rounding.
    fn is_behind_in_name_only(
        &self,
        (master, tree): (&Boundary, &FaceTree),
        node: u32,
        p: &Proximity,
    ) -> bool {
        let Some(own) = self.pair.own.as_ref() else { return false };
        // Behind a face beside its own the node is in the wedge of a sharp edge, unless a fold has closed on it.
        let is_beside = master.is_beside(node, p.face);
        if !master.is_closed {
            return is_beside;
        }
        // A thin layer is resolved by its own size, not by that of the large faces on it.
        let x = self.motion.x;
        let size = master.sizes[p.face as usize].min(master.shortest_edge_at(node, x));
        if p.gap >= -BAND * size && !is_beside {
            return false;
        }
        let (normal, patch) = (master.node_normal(node, x), Patch::new(&master.faces[p.face as usize], x));
        let inwards = patch.point(&[0.25; 4]) - patch.point(&p.weights);
        let inwards = inwards.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let winds_around = |away: Vec3| {
            let place = x[node as usize] + away * (NEAR * size);
            winding_number(master, tree, (&place, &away), (x, &own.shift)) > 0
        };
        // If a face beside the node's own has closed on it, that is where the node's own normal points; any other
        // direction may lead into the body around a corner.
        if is_beside {
            return !winds_around(normal);
        }
        let is_entered = winds_around(normal + inwards * INWARDS)
            || (normal.dot(&p.normal) < WELL_OPPOSED && winds_around(-p.normal));
        !is_entered
    }

    /// Upper bound of the relative motion of node and face in the step [m].
    fn relative_motion(&self, master: &Boundary, face: u32, node: u32) -> f64 {
        let step = |n: u32| self.motion.x_end[n as usize] - self.motion.x[n as usize];
        let own = step(node);
        let corners = master.faces[face as usize].iter();
        corners.map(|&corner| (own - step(corner)).norm_squared()).fold(0.0, f64::max).sqrt()
    }

    /// Whether the face at the start of a step with fast faces still holds the node: it closes and moves little, or
    /// touches and closes, or stays open and no impact follows. The plane of a face, continued beyond it, must not
    /// stop a node that passes by.
    fn holds(&self, master: &Boundary, p: &Proximity, node: u32, is_fast: bool, is_hit: bool) -> bool {
        let change = |n: u32| self.motion.x_end[n as usize] - self.motion.x[n as usize];
        let face = &master.faces[p.face as usize];
        let point: Vec3 = face.iter().zip(&p.weights).map(|(&n, &w)| change(n) * w).sum();
        let closing = p.normal.dot(&(change(node) - point));
        let touches = p.gap <= TOUCH * master.sizes[p.face as usize];
        if touches && closing < 0.0 {
            return true;
        }
        let ends_open = p.gap + closing >= 0.0;
        if ends_open { !is_hit } else { !is_fast }
    }

    fn faces_away(&self, master: &Boundary, face: u32, hit: &Impact, node: u32) -> bool {
        let patch = Patch::between(&master.faces[face as usize], self.motion.x, self.motion.x_end, hit.tau);
        master.node_normal(node, self.motion.x).dot(&patch.normal(&patch.weights(hit.a, hit.b))) >= 0.0
    }

    fn near_contact(&self, master: &Boundary, node: u32, p: &Proximity) -> Contact {
        let nodes = master.faces[p.face as usize];
        let (along, _) = Patch::new(&nodes, self.motion.x).tangents(&p.weights);
        self.contact(master, node, p.face, &p.weights, local_frame(&p.normal, &along), p.gap)
    }

    fn impact_contact(&self, master: &Boundary, node: u32, face: u32, hit: &Impact) -> Contact {
        let Motion { x, x_end, .. } = self.motion;
        let nodes = master.faces[face as usize];
        let then = Patch::between(&nodes, x, x_end, hit.tau);
        let weights = then.weights(hit.a, hit.b);
        let normal = then.normal(&weights);
        let gap = normal.dot(&(x[node as usize] - Patch::new(&nodes, x).point(&weights)));
        let (along, _) = then.tangents(&weights);
        self.contact(master, node, face, &weights, local_frame(&normal, &along), gap)
    }

    fn contact(
        &self,
        master: &Boundary,
        slave: u32,
        face: u32,
        weights: &[f64; 4],
        frame: [Vec3; 3],
        gap: f64,
    ) -> Contact {
        let point = self.motion.x[slave as usize];
        let stencil = Stencil::node_on_face(slave, &master.faces[face as usize], weights);
        let (pair, drift, law) = (self.pair.number, Vec3::zeros(), ContactLaw::Frictionless);
        Contact { pair, kind: Kind::NODE, slave, face, stencil, frame, gap, point, drift, law }
    }
}
