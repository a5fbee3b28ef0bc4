//! Slave nodes that start inside the other body: found before a run, with place and depth.

use super::closest_point::Patch;
use super::detection::Detector;
use super::narrow_phase::{DEPTH, eval_proximity};
use super::skin::Skin;
use crate::mechanics::tensor::Vec3;

/// Depths below this share of the face's size are rounding.
pub const TOLERANCE: f64 = 1e-6;

/// A slave node inside its master.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Index of the pair.
    pub pair: usize,
    /// Node (global).
    pub node: u32,
    /// Where it is [m].
    pub place: Vec3,
    /// How deep below the closest point of the master's surface [m].
    pub depth: f64,
}

/// All slave nodes that are inside their master at the positions `x` [m], beyond rounding, by pair and node.
///
/// Inside is told by the pseudo-normal at the closest point of the whole surface (Bærentzen & Aanæs 2005), at any depth;
/// for self-contact only down to the depth that contact would hold.
pub fn initial_overlaps(detector: &Detector, x: &[Vec3]) -> Vec<Overlap> {
    let mut overlaps = Vec::new();
    for (pair, (slave, master)) in detector.sides().enumerate() {
        for &node in &detector.skin(slave).nodes {
            let place = x[node as usize];
            let (depth, size) = match (detector.plane(pair), master) {
                (Some((point, normal, size)), _) => (-normal.dot(&(place - point)), size),
                (None, Some(master)) => {
                    let skin = detector.skin(master);
                    let allowed = |face: u32| !detector.excludes(pair, node, face);
                    let Some((gap, size)) = signed_gap(skin, &place, allowed, x) else { continue };
                    if slave == master && gap < -DEPTH * size {
                        continue;
                    }
                    (-gap, size)
                }
                (None, None) => continue,
            };
            if depth > TOLERANCE * size {
                overlaps.push(Overlap { pair, node, place, depth });
            }
        }
    }
    overlaps
}

/// Signed distance of a point from the closest face that speaks for it, with that face's size.
fn signed_gap(skin: &Skin, s: &Vec3, allowed: impl Fn(u32) -> bool, x: &[Vec3]) -> Option<(f64, f64)> {
    let mut best: Option<(f64, f64, f64)> = None;
    for (i, face) in skin.faces.iter().enumerate() {
        let patch = Patch::new(face, x);
        let centre = patch.corners.iter().sum::<Vec3>() * 0.25;
        let radius = patch.corners.iter().map(|c| (c - centre).norm()).fold(0.0, f64::max);
        if best.is_some_and(|(distance, ..)| (s - centre).norm() - radius > distance) || !allowed(i as u32) {
            continue;
        }
        if let Some(p) = eval_proximity(skin, i as u32, s, x)
            && best.is_none_or(|(distance, ..)| p.distance < distance)
        {
            best = Some((p.distance, p.gap, skin.sizes[i]));
        }
    }
    best.map(|(_, gap, size)| (gap, size))
}
