//! Mortar contact: the gap of a slave node as a mean over the faces around it, with dual shape functions.
//!
//! With N_B the shape functions of a slave face, N_C those of the master below it, and Φ_A the dual ones (biorthogonal,
//! `∫ Φ_A N_B = δ_AB ∫ N_B`; Wohlmuth 2000), the row of slave node A is
//!
//! ```text
//! D_A = Σ_faces ∫ N_A dA,   w_C = Σ_faces ∫ Φ_A N_C dA / D_A,   g_A = n_A · (x_A − Σ w_C x_C)
//! ```
//!
//! so there is one row per slave node, as in node-to-surface contact, and a uniform pressure on the slave is
//! transferred to the master as a uniform one. Integrals are over the segments of the slave face
//! ([`super::segments`]), so kinks of the master do not disturb them. Dual functions are constructed on the part of a
//! face above the master (Cichosz & Bischoff 2011).
//!
//! Σ w_C = 1 conserves linear momentum. Then the weights are changed by the least linear function that makes `x_A − Σ
//! w_C x_C` parallel to n_A, so that impulses along n_A have no moment. Tangential ones have that of their gap, as in
//! node-to-surface contact.
//!
//! A node keeps its node-to-surface row where less than half of an adjacent face opposed to the master is above it,
//! where the node arrives fast from afar, and where a row would have more nodes than a stencil
//! ([`crate::contact::stencil::MOST_NODES`]), as with a slave much coarser than its master.

use super::boundary::{Boundary, NONE, corner_count};
use super::closest_point::Patch;
use super::detector::{DetectionError, Detector, Motion};
use super::frame::local_frame;
use super::narrow_phase::NEAR;
use super::node_to_face::NodeToFace;
use super::segments::{OPPOSED, for_each_segment_point};
use crate::contact::Contact;
use crate::contact::kind::{Gap, Kind};
use crate::contact::stencil::Stencil;
use crate::tensor::Vec3;
use nalgebra::{Matrix4, Vector4};

/// Largest number of master nodes below a face or around a node.
const MOST_BELOW: usize = 36;
/// Least fraction of a face above the master: on less, shape functions are nearly linearly dependent.
const LEAST_COVERED: f64 = 0.5;

/// The mean over the faces around a slave node: at most one contact per node and pair.
const AVERAGED: Kind = Kind { gap: Gap::ConstantWeights, ..Kind::NODE };

/// Finds the contacts of slave nodes with master faces and planes, and averages those of two meshes.
pub(super) struct Mortar {
    nodes: NodeToFace,
    averager: Averager,
}

impl Mortar {
    /// Averages what `nodes` find.
    pub fn new(nodes: NodeToFace) -> Self {
        let slaves = nodes.surfaces().boundaries.iter();
        let most = slaves.map(|boundary| boundary.faces.len()).max().unwrap_or(0);
        Self { averager: Averager::for_faces(most), nodes: nodes.with_one_face_per_node() }
    }
}

impl Detector for Mortar {
    fn detect(&mut self, motion: &Motion, contacts: &mut Vec<Contact>) -> Result<(), DetectionError> {
        let before = contacts.len();
        self.nodes.detect(motion, contacts)?;
        let surfaces = self.nodes.surfaces();
        for of_pair in contacts[before..].chunk_by_mut(|a, b| a.pair == b.pair) {
            let pair = of_pair[0].pair as usize;
            let slave = surfaces.slave(pair);
            if let Some(master) = surfaces.master(pair).filter(|master| !std::ptr::eq(slave, *master)) {
                self.averager.average(slave, master, motion.x, of_pair);
            }
        }
        Ok(())
    }
}

/// Integrals over a slave face.
#[derive(Clone, Debug)]
struct FaceMoments {
    normal: Vec3,
    /// `∫ N_A` for each corner A [m²].
    own: Vector4<f64>,
    /// `∫ Φ_A N_C` [m²] for the master nodes C and each corner A.
    below: [(u32, Vector4<f64>); MOST_BELOW],
    count: usize,
}

/// Averages the contacts of one pair of surfaces after the other; its buffers persist.
struct Averager {
    moments: Vec<Option<FaceMoments>>,
    /// Index in `moments` of each slave face, `NONE` if it has none yet.
    places: Vec<u32>,
    /// Slave faces with an entry in `moments`.
    faces: Vec<u32>,
}

impl Averager {
    /// Buffers for slave surfaces of at most `count` faces.
    fn for_faces(count: usize) -> Self {
        Self {
            moments: Vec::with_capacity(count),
            places: vec![NONE; count],
            faces: Vec::with_capacity(count),
        }
    }

    /// Replaces the contacts of the pair, sorted by slave node, by averages where possible, at the positions `x` [m].
    fn average(&mut self, slave: &Boundary, master: &Boundary, x: &[Vec3], contacts: &mut [Contact]) {
        for contact in contacts.iter().filter(|c| is_near(c, master)) {
            for &face in slave.faces_around(contact.slave) {
                if self.places[face as usize] == NONE {
                    self.places[face as usize] = self.moments.len() as u32;
                    self.faces.push(face);
                    self.moments.push(moments(slave, master, face, contact.face, x));
                }
            }
        }
        for contact in contacts.iter_mut().filter(|c| is_near(c, master)) {
            self.average_one(slave, x, contact);
        }
        self.moments.clear();
        for face in self.faces.drain(..) {
            self.places[face as usize] = NONE;
        }
    }

    /// Replaces one contact; `None` leaves it as it is.
    fn average_one(&self, slave: &Boundary, x: &[Vec3], contact: &mut Contact) -> Option<()> {
        // Sum the integrals of the faces around the node that are opposed to the master.
        let (mut area, mut normal) = (0.0, Vec3::zeros());
        let mut below = [(0_u32, 0.0); MOST_BELOW];
        let mut count = 0;
        for &face in slave.faces_around(contact.slave) {
            let corners = &slave.faces[face as usize];
            let turned = Patch::new(corners, x).normal(&[0.25; 4]);
            if turned.dot(&contact.frame[0]) > OPPOSED {
                continue;
            }
            let moments = self.moments[self.places[face as usize] as usize].as_ref()?;
            let corner = corners.iter().position(|&n| n == contact.slave)?;
            area += moments.own[corner];
            normal -= moments.normal * moments.own[corner];
            for (node, integrals) in &moments.below[..moments.count] {
                let at = below[..count].iter().position(|(n, _)| n == node).unwrap_or(count);
                let sum = below.get_mut(at)?;
                *sum = (*node, sum.1 + integrals[corner]);
                count = count.max(at + 1);
            }
        }
        // Weights and gap along the mean normal.
        let normal = normal.try_normalize(0.0)?;
        let below = &mut below[..count];
        for (_, w) in below.iter_mut() {
            *w /= area;
        }
        align(below, &x[contact.slave as usize], &normal, x)?;
        let stencil = Stencil::new([(contact.slave, 1.0)], below.iter().copied())?;
        let gap = normal.dot(&stencil.difference(x));
        if !gap.is_finite() {
            return None;
        }
        let frame = local_frame(&normal, &contact.frame[1]);
        (contact.kind, contact.stencil, contact.frame, contact.gap) = (AVERAGED, stencil, frame, gap);
        Some(())
    }
}

/// Whether the node is near its face at the start, rather than met later in the step.
fn is_near(contact: &Contact, master: &Boundary) -> bool {
    contact.gap <= NEAR * master.sizes[contact.face as usize]
}

/// Changes weights by the least linear function of position such that `x_A − Σ w x` is parallel to n; their sum is
/// unchanged.
fn align(below: &mut [(u32, f64)], x_a: &Vec3, n: &Vec3, x: &[Vec3]) -> Option<()> {
    // Positions in the tangential plane relative to node A, their weighted mean and resultant.
    let [_, t1, t2] = local_frame(n, &Vec3::zeros());
    let flat = |node: u32| {
        let from = x_a - x[node as usize];
        [t1.dot(&from), t2.dot(&from)]
    };
    let (mut size, mut mean, mut miss) = (0.0, [0.0; 2], [0.0; 2]);
    for &(node, w) in below.iter() {
        size += w.abs();
        for (i, s) in flat(node).into_iter().enumerate() {
            mean[i] += w.abs() * s;
            miss[i] += w * s;
        }
    }
    let mean = mean.map(|m| m / size);
    // The moments about the mean determine the linear function.
    let centred = |node: u32| {
        let s = flat(node);
        [s[0] - mean[0], s[1] - mean[1]]
    };
    let [mut s11, mut s12, mut s22] = [0.0; 3];
    for &(node, w) in below.iter() {
        let s = centred(node);
        s11 += w.abs() * s[0] * s[0];
        s12 += w.abs() * s[0] * s[1];
        s22 += w.abs() * s[1] * s[1];
    }
    let det = s11 * s22 - s12 * s12;
    if det.is_nan() || det <= 1e-6 * s11 * s22 {
        return None;
    }
    let by = [(s22 * miss[0] - s12 * miss[1]) / det, (s11 * miss[1] - s12 * miss[0]) / det];
    for (node, w) in below.iter_mut() {
        let s = centred(*node);
        *w -= w.abs() * (by[0] * s[0] + by[1] * s[1]);
    }
    Some(())
}

/// Integrals over a slave face, `None` where too little of it is above the master; `start` is a face near it.
fn moments(slave: &Boundary, master: &Boundary, face: u32, start: u32, x: &[Vec3]) -> Option<FaceMoments> {
    let corners = &slave.faces[face as usize];
    let patch = Patch::new(corners, x);
    let normal = patch.normal(&[0.25; 4]);
    let mut found =
        FaceMoments { normal, own: Vector4::zeros(), below: [(0, Vector4::zeros()); MOST_BELOW], count: 0 };
    let (mut mass, mut covered) = (Matrix4::zeros(), 0.0);
    // Integrate over the segments.
    let all = for_each_segment_point(&patch, &normal, master, start, x, |point| {
        let nodes = &master.faces[point.face as usize];
        let below = Patch::new(nodes, x);
        let (shape, _) = patch.along(&point.place, &normal)?;
        let (weights, _) = below.along(&point.place, &normal)?;
        // Parts that are opposed but far apart do not touch.
        if (below.point(&weights) - patch.point(&shape)).norm() > slave.sizes[face as usize] {
            return Some(());
        }
        let own = Vector4::from(shape);
        found.own += own * point.area;
        mass += own * own.transpose() * point.area;
        covered += point.area;
        nodes
            .iter()
            .zip(weights)
            .filter(|(_, w)| *w != 0.0)
            .try_for_each(|(&node, w)| found.add(node, own * (w * point.area)))
    })?;
    if covered < LEAST_COVERED * all {
        return None;
    }
    // A triangle has no fourth shape function.
    if corner_count(corners) == 3 {
        mass[(3, 3)] = 1.0;
    }
    // Coefficients of the dual functions.
    let dual = Matrix4::from_diagonal(&found.own) * mass.try_inverse()?;
    let count = found.count;
    found.below[..count].iter_mut().for_each(|(_, integrals)| *integrals = dual * *integrals);
    Some(found)
}

impl FaceMoments {
    fn add(&mut self, node: u32, integrals: Vector4<f64>) -> Option<()> {
        let below = &mut self.below;
        let at = below[..self.count].iter().position(|(n, _)| *n == node).unwrap_or(self.count);
        let sum = below.get_mut(at)?;
        *sum = (node, sum.1 + integrals);
        self.count = self.count.max(at + 1);
        Some(())
    }
}

#[cfg(test)]
mod tests;
