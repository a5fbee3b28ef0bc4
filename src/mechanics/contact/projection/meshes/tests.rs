#![allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact equality is intended

use super::*;
use crate::contact::detection::detector::{Detector as _, Motion};
use crate::contact::detection::node_to_face::NodeToFace;
use crate::contact::{ContactLaw, ContactPair, Master, Surface};

fn nodes(inverse_mass: &[Vec3]) -> MovableNodes<'_> {
    static NO_FOLLOWERS: std::sync::LazyLock<Followers> = std::sync::LazyLock::new(Followers::default);
    MovableNodes { inverse_mass, followers: &NO_FOLLOWERS }
}

/// A unit face of masses 2 under a node of mass 1 that is `depth` inside, and the contact between them.
fn pressed(depth: f64, inverse_mass: [f64; 2]) -> (Vec<Vec3>, Vec<Vec3>, PairSurfaces, Vec<Contact>) {
    let mut x: Vec<Vec3> =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
    x.push(Vec3::new(0.5, 0.25, -depth));
    let mut masses = vec![Vec3::repeat(inverse_mass[0]); 4];
    masses.push(Vec3::repeat(inverse_mass[1]));
    let master = Surface::new(vec![0, 1, 2, 3], vec![[0, 1, 2, 3]]);
    let slave = Surface::new(vec![4], Vec::new());
    let pair = ContactPair { slave: 1, master: Master::Surface(0), law: ContactLaw::Frictionless };
    let (surfaces, pairs) = ([master, slave], [pair].into_iter().collect());
    let mut detector = NodeToFace::new(&surfaces, &pairs, &x);
    let mut contacts = Vec::new();
    detector.detect(&Motion::of_nodes(&x, &x), &mut contacts).unwrap();
    let surfaces = PairSurfaces::new(&surfaces, &pairs, &x);
    (x, masses, surfaces, contacts)
}

#[test]
fn a_small_penetration_is_removed_about_the_centre_of_mass() {
    let (before, masses, surfaces, contacts) = pressed(0.001, [0.5, 1.0]);
    let mut x = before.clone();
    let mut moved = Vec::new();
    let report = project_positions(&contacts, &surfaces, (nodes(&masses), 1.0), &mut x, &mut moved);
    assert_eq!(report.corrected, 1);
    assert!((report.deepest - 0.001).abs() < 1e-15 && report.left <= 1e-8);
    let centre = |x: &[Vec3]| x.iter().zip(&masses).map(|(x, m)| x.component_div(m)).sum::<Vec3>();
    assert!((centre(&x) - centre(&before)).norm() < 1e-15);
    // The recorded displacements are those applied.
    let mut replayed = before;
    for (node, step) in moved {
        replayed[node as usize] += step;
    }
    assert_eq!(replayed, x);
}

#[test]
fn the_cap_holds_and_fixed_sides_stay() {
    let (before, masses, surfaces, contacts) = pressed(0.05, [0.0, 1.0]);
    let mut x = before.clone();
    let mut moved = Vec::new();
    let report = project_positions(&contacts, &surfaces, (nodes(&masses), 1.0), &mut x, &mut moved);
    assert!((x[4].z + 0.05 - CAP).abs() < 1e-14 && report.left > 0.04);
    assert_eq!(x[..4], before[..4]);
    // Immovable nodes do not move, and all values stay finite.
    let mut x = before.clone();
    let report =
        project_positions(&contacts, &surfaces, (nodes(&[Vec3::zeros(); 5]), 1.0), &mut x, &mut moved);
    assert_eq!((report.corrected, x, moved.len()), (0, before, 0));
}

#[test]
fn open_contacts_stay() {
    let (before, masses, surfaces, contacts) = pressed(-0.01, [0.5, 1.0]);
    let mut x = before.clone();
    let mut moved = vec![(0, Vec3::zeros())];
    let report = project_positions(&contacts, &surfaces, (nodes(&masses), 1.0), &mut x, &mut moved);
    assert_eq!((contacts.len(), report, x, moved.len()), (1, ProjectionReport::default(), before, 0));
}
