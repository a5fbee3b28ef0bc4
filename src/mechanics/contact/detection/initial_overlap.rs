//! Slave nodes that start inside the other body: found before a run, with position and depth.

use super::boundary::Boundary;
use super::closest_point::Patch;
use super::detector::Motion;
use super::narrow_phase::eval_proximity;
use super::node_to_face::NodeToFace;
use crate::contact::Contact;
use crate::tensor::Vec3;

/// Depths below this fraction of the face's size are rounding.
pub const TOLERANCE: f64 = 1e-6;

/// A slave node inside its master.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Index of the pair.
    pub pair: usize,
    /// Global number of the slave node.
    pub node: u32,
    /// Position of the node [m].
    pub place: Vec3,
    /// Depth below the closest point of the master's surface [m].
    pub depth: f64,
}

/// All slave nodes that are inside their master at the positions `x` [m], beyond rounding, by pair and node.
///
/// The pseudo-normal at the closest point of the whole surface determines the side (Bærentzen & Aanæs 2005), at any
/// depth; in self-contact, nodes held by detection count as inside. Positions that are not finite do not overlap.
pub fn initial_overlaps(detector: &mut NodeToFace, x: &[Vec3]) -> Vec<Overlap> {
    let mut overlaps = overlaps_with_itself(detector, x);
    let surfaces = detector.surfaces();
    for (pair, slave, master) in detector.sides().filter(|(_, s, m)| *m != Some(*s)) {
        for &node in &surfaces.boundaries[slave].nodes {
            let place = x[node as usize];
            let (depth, size) = match (surfaces.plane(pair), master) {
                (Some((point, normal, size)), _) => (-normal.dot(&(place - point)), size),
                (None, Some(master)) => {
                    let boundary = &surfaces.boundaries[master];
                    let Some((gap, size)) = signed_gap(boundary, &place, x) else { continue };
                    (-gap, size)
                }
                (None, None) => continue,
            };
            if depth > TOLERANCE * size {
                overlaps.push(Overlap { pair, node, place, depth });
            }
        }
    }
    overlaps.sort_by_key(|overlap| (overlap.pair, overlap.node));
    overlaps
}

fn overlaps_with_itself(detector: &mut NodeToFace, x: &[Vec3]) -> Vec<Overlap> {
    let of_itself: Vec<bool> = detector.sides().map(|(_, slave, master)| master == Some(slave)).collect();
    let mut contacts = Vec::new();
    // Positions that are not finite are reported elsewhere, with the values that cause them.
    let found = of_itself.contains(&true) && detector.find(&Motion::of_nodes(x, x), &mut contacts).is_ok();
    let is_inside = |contact: &&Contact| {
        let (pair, face) = (contact.pair as usize, contact.face as usize);
        of_itself[pair] && -contact.gap > TOLERANCE * detector.surfaces().slave(pair).sizes[face]
    };
    let overlap = |contact: &Contact| Overlap {
        pair: contact.pair as usize,
        node: contact.slave,
        place: contact.point,
        depth: -contact.gap,
    };
    if found { contacts.iter().filter(is_inside).map(overlap).collect() } else { Vec::new() }
}

/// Signed distance of a point from the closest face with a valid projection, with that face's size.
fn signed_gap(boundary: &Boundary, s: &Vec3, x: &[Vec3]) -> Option<(f64, f64)> {
    let mut best: Option<(f64, f64, f64)> = None;
    for (i, face) in boundary.faces.iter().enumerate() {
        let patch = Patch::new(face, x);
        let centre = patch.corners.iter().sum::<Vec3>() * 0.25;
        let radius = patch.corners.iter().map(|c| (c - centre).norm()).fold(0.0, f64::max);
        if best.is_some_and(|(distance, ..)| (s - centre).norm() - radius > distance) {
            continue;
        }
        if let Some(p) = eval_proximity(boundary, i as u32, s, x)
            && best.is_none_or(|(distance, ..)| p.distance < distance)
        {
            best = Some((p.distance, p.gap, boundary.sizes[i]));
        }
    }
    best.map(|(_, gap, size)| (gap, size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactLaw, ContactPair, Master, Surface};

    fn cube(at: Vec3, size: f64, x: &mut Vec<Vec3>) -> Surface {
        let base = x.len() as u32;
        for [a, b, c] in
            [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
        {
            x.push(at + Vec3::new(f64::from(a), f64::from(b), f64::from(c)) * size);
        }
        let faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
            .map(|f| f.map(|n| n + base));
        Surface::new((base..base + 8).collect(), faces.to_vec())
    }

    #[test]
    fn overlap_is_found_with_place_and_depth_at_any_depth_and_touching_is_none() {
        for (lower, depths) in [(0.0, vec![]), (-1e-8, vec![]), (0.1, vec![0.1; 4]), (0.4, vec![0.4; 4])] {
            let mut x = Vec::new();
            let below = cube(Vec3::zeros(), 1.0, &mut x);
            let above = cube(Vec3::new(0.45, 0.45, 1.0 - lower), 0.1, &mut x);
            let pairs = [
                ContactPair { slave: 1, master: Master::Surface(0), law: ContactLaw::Frictionless },
                ContactPair {
                    slave: 0,
                    master: Master::Plane { point: Vec3::zeros(), normal: Vec3::z() },
                    law: ContactLaw::Frictionless,
                },
            ];
            let mut detector = NodeToFace::new(&[below, above], &pairs.into_iter().collect(), &x);
            let found = initial_overlaps(&mut detector, &x);
            // The upper cube is 0.1 high: sunk by 0.4, all its nodes are inside.
            let lowest: Vec<f64> =
                found.iter().filter(|o| o.node < 12).map(|o| (o.depth * 1e9).round() / 1e9).collect();
            assert_eq!(lowest, depths, "sunk by {lower}");
            assert!(found.iter().all(|o| o.pair == 0 && o.place == x[o.node as usize]));
        }
    }
}
