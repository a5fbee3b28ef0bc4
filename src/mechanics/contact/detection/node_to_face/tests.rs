//! Requirements on detection: nothing tunnels, nothing is missed, and nothing depends on the age of the list.
#![allow(clippy::unwrap_used, clippy::float_cmp, clippy::cast_sign_loss)] // tests may panic; exact equality is intended

use super::*;
use crate::contact::stencil::weighted;
use crate::contact::{ContactLaw, ContactPair, Surface};

mod many_bodies;
mod mirror_image;
mod self_contact;
mod valley;

/// A flat box of n × n × m cells, as a closed surface appended to `x`; `place` maps its unit cube.
fn block(n: u32, m: u32, x: &mut Vec<Vec3>, place: impl Fn(Vec3) -> Vec3) -> Surface {
    let base = x.len() as u32;
    let at = |i: u32, j: u32, k: u32| base + (k * (n + 1) + j) * (n + 1) + i;
    let fraction = |i: u32, n: u32| f64::from(i) / f64::from(n);
    for k in 0..=m {
        for j in 0..=n {
            for i in 0..=n {
                x.push(place(Vec3::new(fraction(i, n), fraction(j, n), fraction(k, m))));
            }
        }
    }
    let mut faces = Vec::new();
    for a in 0..n {
        for b in 0..n {
            faces.push([at(a, b, 0), at(a, b + 1, 0), at(a + 1, b + 1, 0), at(a + 1, b, 0)]);
            faces.push([at(a, b, m), at(a + 1, b, m), at(a + 1, b + 1, m), at(a, b + 1, m)]);
        }
        for k in 0..m {
            faces.push([at(a, 0, k), at(a + 1, 0, k), at(a + 1, 0, k + 1), at(a, 0, k + 1)]);
            faces.push([at(a, n, k), at(a, n, k + 1), at(a + 1, n, k + 1), at(a + 1, n, k)]);
            faces.push([at(0, a, k), at(0, a, k + 1), at(0, a + 1, k + 1), at(0, a + 1, k)]);
            faces.push([at(n, a, k), at(n, a + 1, k), at(n, a + 1, k + 1), at(n, a, k + 1)]);
        }
    }
    let mut nodes: Vec<u32> = faces.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    Surface::new(nodes, faces)
}

/// A lone slave node without faces.
fn node(x: &mut Vec<Vec3>, at: Vec3) -> Surface {
    x.push(at);
    Surface::new(vec![x.len() as u32 - 1], Vec::new())
}

fn pair(slave: usize, master: Master) -> ContactPair {
    ContactPair { slave, master, law: ContactLaw::Frictionless }
}

fn detect(surfaces: &[Surface], pairs: &[ContactPair], x: &[Vec3], x_end: &[Vec3]) -> Vec<Contact> {
    find(&mut new(surfaces, pairs, x), x, x_end).0
}

fn new(surfaces: &[Surface], pairs: &[ContactPair], x: &[Vec3]) -> NodeToFace {
    NodeToFace::new(surfaces, &pairs.iter().copied().collect(), x)
}

/// The contacts of a step, and whether lists were rebuilt.
fn find(detector: &mut NodeToFace, x: &[Vec3], x_end: &[Vec3]) -> (Vec<Contact>, bool) {
    let mut contacts = Vec::new();
    let rebuilt = detector.find(&Motion::of_nodes(x, x_end), &mut contacts).unwrap();
    (contacts, rebuilt)
}

/// The gap at the end of the step by the linear constraint.
fn linear_gap(c: &Contact, x: &[Vec3], x_end: &[Vec3]) -> f64 {
    let step = |n: u32| x_end[n as usize] - x[n as usize];
    c.gap + c.frame[0].dot(&weighted(c.stencil.each(), step))
}

fn assert_frames(contacts: &[Contact]) {
    for c in contacts {
        let [n, t1, t2] = c.frame;
        assert!((n.norm() - 1.0).abs() < 1e-14 && (t1.norm() - 1.0).abs() < 1e-14);
        assert!(n.dot(&t1).abs() < 1e-14 && (n.cross(&t1) - t2).norm() < 1e-14);
    }
}

#[test]
fn node_falling_on_a_moving_warped_face_is_stopped_on_it() {
    let mut x = vec![
        Vec3::new(0.0, 0.0, 0.0),
        Vec3::new(1.0, 0.0, 0.2),
        Vec3::new(1.0, 1.0, -0.1),
        Vec3::new(0.0, 1.0, 0.1),
    ];
    let face = Surface::new(vec![0, 1, 2, 3], vec![[0, 1, 2, 3]]);
    let slave = node(&mut x, Vec3::new(0.4, 0.7, 0.6));
    let mut x_end: Vec<Vec3> = x.iter().map(|p| p + Vec3::new(0.02, 0.01, 0.1)).collect();
    x_end[4] = Vec3::new(0.5, 0.6, -0.5);
    let found = detect(&[slave, face], &[pair(0, Master::Surface(1))], &x, &x_end);
    assert_eq!(found.len(), 1);
    assert_frames(&found);
    let c = &found[0];
    assert!(c.gap > 0.0 && linear_gap(c, &x, &x_end) < 0.0);
    // At the time of impact the node is on the face with these weights.
    let tau = c.gap / (c.gap - linear_gap(c, &x, &x_end));
    let at = |n: u32| x[n as usize] + (x_end[n as usize] - x[n as usize]) * tau;
    let point = -weighted(c.stencil.master(), at);
    assert!((point - at(4)).norm() < 1e-12);
}

#[test]
fn nothing_tunnels_through_a_thin_plate_at_any_speed() {
    let mut x = Vec::new();
    let plate = block(8, 1, &mut x, |p| Vec3::new(0.08 * p.x, 0.08 * p.y, 0.0005 * p.z));
    let bullet = node(&mut x, Vec3::new(0.0331, 0.0457, 0.012));
    let slave = x.len() - 1;
    for speed in [10.0, 1000.0, 1e5] {
        // 25 µs: at 1000 m/s the node starts above and ends 13 mm below the plate.
        let mut x_end = x.clone();
        x_end[slave] += Vec3::new(0.1, -0.2, -1.0) * speed * 25e-6;
        let found = detect(&[bullet.clone(), plate.clone()], &[pair(0, Master::Surface(1))], &x, &x_end);
        assert_eq!(found.len(), usize::from(x_end[slave].z < 0.0), "{speed} m/s");
        for c in &found {
            assert!((c.frame[0] - Vec3::z()).norm() < 1e-12, "the front face stops it");
            assert!((c.gap - 0.0115).abs() < 1e-12);
        }
    }
    // Fired from below, it meets the lower face.
    let mut below = x.clone();
    below[slave].z = -0.012;
    let mut x_end = below.clone();
    x_end[slave].z = 0.013;
    let found = detect(&[bullet, plate], &[pair(0, Master::Surface(1))], &below, &x_end);
    assert!((found[0].frame[0] + Vec3::z()).norm() < 1e-12);
}

#[test]
fn gap_is_continuous_when_a_node_slides_over_the_edges_of_faces() {
    // A roof-like convex fold of 10° along y at x = 1 and a concave one at x = 2.
    let mut x = Vec::new();
    let heights = [0.0, 0.0, -0.176, -0.176];
    for (i, z) in heights.into_iter().enumerate() {
        x.push(Vec3::new(i as f64, 0.0, z));
        x.push(Vec3::new(i as f64, 1.0, z));
    }
    let faces: Vec<[u32; 4]> = (0..3).map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).collect();
    let sheet = Surface::new((0..8).collect(), faces);
    let slave = node(&mut x, Vec3::zeros());
    for clearance in [0.0, 1e-9, 1e-3] {
        let mut last: Option<f64> = None;
        for k in 1..3000 {
            let at = f64::from(k) * 1e-3;
            // Follow the surface at a constant height above it.
            let z = if at < 1.0 {
                0.0
            } else if at < 2.0 {
                -0.176 * (at - 1.0)
            } else {
                -0.176
            };
            x[8] = Vec3::new(at, 0.4, z + clearance);
            let found = detect(&[slave.clone(), sheet.clone()], &[pair(0, Master::Surface(1))], &x, &x);
            assert_eq!(found.len(), 1, "x = {at}");
            let gap = found[0].gap;
            if let Some(last) = last {
                assert!((gap - last).abs() <= 0.02 * clearance + 1e-15, "x = {at}: {last} then {gap}");
            }
            last = Some(gap);
        }
    }
}

#[test]
fn a_sharp_convex_edge_ends_the_contact_and_open_borders_make_no_phantom() {
    let mut x = Vec::new();
    let cube = block(2, 2, &mut x, |p| p);
    let is_top = |face: &&[u32; 4]| face.iter().all(|&n| x[n as usize].z == 1.0);
    let open = Surface::new(cube.nodes.clone(), cube.faces.iter().filter(is_top).copied().collect());
    let slave = node(&mut x, Vec3::zeros());
    let at = x.len() - 1;
    for (master, in_the_middle) in [(cube, Some(-0.5)), (open, None)] {
        let mut gap_at = |p: Vec3| {
            x[at] = p;
            detect(&[slave.clone(), master.clone()], &[pair(0, Master::Surface(1))], &x, &x)
                .first()
                .map(|c| c.gap)
        };
        // On and just inside the rim, it is held by the top; also slightly beyond (rounding).
        for y in [0.7, 1.0, 1.0 + 1e-12] {
            let gap = gap_at(Vec3::new(0.3, y, 1.0 + 1e-4)).unwrap();
            assert!((gap - 1e-4).abs() < 1e-12, "{gap}");
        }
        // Well beyond the rim and below the top: nothing below the plane of the top is a penetration.
        let beside = gap_at(Vec3::new(0.3, 1.02, 0.999));
        assert!(beside.is_none_or(|gap| gap > 0.019), "{beside:?}");
        assert_eq!(gap_at(Vec3::new(0.3, 1.4, 0.99)), None);
        // Deep inside it is held by the closest of all faces; a sheet has no inside.
        assert_eq!(gap_at(Vec3::new(0.5, 0.5, 0.5)), in_the_middle);
        // Slightly inside it is held with a negative gap.
        assert!((gap_at(Vec3::new(0.3, 0.6, 0.99)).unwrap() + 0.01).abs() < 1e-12);
    }
}

#[test]
fn aligned_bars_touch_on_their_whole_ends() {
    let mut x = Vec::new();
    let left = block(2, 4, &mut x, |p| Vec3::new(p.z * 10.0 - 10.0, p.x, p.y));
    let right = block(2, 4, &mut x, |p| Vec3::new(p.z * 10.0, p.x, p.y));
    for shift in [0.0, 1e-13, -1e-13, 1e-4] {
        // Also when the end of the slave is slightly inside, and slightly wider.
        for depth in [0.0, 1e-12, 1e-5] {
            let mut y = x.clone();
            for &n in &left.nodes {
                let p = &mut y[n as usize];
                p.x += depth;
                p.y += shift * (p.y - 0.5);
                p.z += shift * (p.z - 0.5);
            }
            let found = detect(&[left.clone(), right.clone()], &[pair(0, Master::Surface(1))], &y, &y);
            assert_eq!(found.len(), 9, "shift {shift}, depth {depth}");
            assert_frames(&found);
            for c in &found {
                assert!((c.frame[0] + Vec3::x()).norm() < 1e-9, "{c:?}");
                assert!((c.gap + depth).abs() < 1e-14, "{c:?}");
            }
        }
    }
}

#[test]
fn stacked_blocks_of_other_meshes_touch_with_every_slave_node() {
    let mut x = Vec::new();
    let floor = block(3, 1, &mut x, |p| Vec3::new(3.0 * p.x - 1.0, 3.0 * p.y - 1.0, p.z - 1.0));
    let middle = block(5, 2, &mut x, |p| p);
    let top = block(4, 2, &mut x, |p| Vec3::new(0.2 + 0.7 * p.x, 0.1 + 0.7 * p.y, 1.0 + p.z));
    let pairs = [pair(1, Master::Surface(0)), pair(2, Master::Surface(1))];
    let found = detect(&[floor, middle, top], &pairs, &x, &x);
    assert_eq!(found.iter().filter(|c| c.pair == 0).count(), 36);
    assert_eq!(found.iter().filter(|c| c.pair == 1).count(), 25);
    assert!(found.iter().all(|c| c.gap.abs() < 1e-15 && (c.frame[0] - Vec3::z()).norm() < 1e-14));
    assert!(found.is_sorted_by_key(Contact::key));
}

#[test]
fn planes_hold_all_that_come_near() {
    let mut x = Vec::new();
    let cube = block(2, 2, &mut x, |p| p + Vec3::new(0.0, 0.0, 0.01));
    let floor = Master::Plane { point: Vec3::zeros(), normal: Vec3::z() };
    let still = detect(std::slice::from_ref(&cube), &[pair(0, floor)], &x, &x);
    assert_eq!(still.len(), 9);
    assert!(
        still
            .iter()
            .all(|c| (c.gap - 0.01).abs() < 1e-15 && c.face == u32::MAX && c.stencil.nodes().len() == 1)
    );
    let x_end: Vec<Vec3> = x.iter().map(|p| p - Vec3::new(0.0, 0.0, 5.0)).collect();
    assert_eq!(detect(&[cube], &[pair(0, floor)], &x, &x_end).len(), 26);
}

#[test]
fn the_age_of_the_list_never_shows() {
    let mut x = Vec::new();
    let ground = block(8, 2, &mut x, |p| Vec3::new(p.x, p.y, 0.25 * p.z - 0.25));
    let first_slave = x.len();
    let ball = block(6, 6, &mut x, |p| {
        let c = p * 2.0 - Vec3::repeat(1.0);
        Vec3::new(0.5, 0.5, 0.32) + c * (0.3 * c.amax() / c.norm().max(1e-9))
    });
    let surfaces = [ground, ball];
    let pairs =
        [pair(1, Master::Surface(0)), pair(1, Master::Plane { point: Vec3::zeros(), normal: Vec3::z() })];
    let mut aged = new(&surfaces, &pairs, &x);
    let start = x.clone();
    let (mut total, mut rebuilt) = (0, 0);
    for step in 0..200 {
        let t = f64::from(step);
        let mut x_end = x.clone();
        for (i, p) in x_end.iter_mut().enumerate() {
            let speed = if i >= first_slave {
                Vec3::new(0.002 * (0.1 * t).sin(), 0.001, -0.0004)
            } else {
                Vec3::zeros()
            };
            *p += speed + Vec3::new(p.y, p.z, p.x) * (2e-4 * (0.3 * t + i as f64).sin());
        }
        // Occasionally, a step that would carry the ball far, from the same position.
        let slow_end = x_end.clone();
        if step % 7 == 3 {
            for p in &mut x_end[first_slave..] {
                *p += Vec3::new(0.05, -0.03, -0.2);
            }
        }
        let (from_aged, is_new) = find(&mut aged, &x, &x_end);
        assert_eq!(from_aged, find(&mut new(&surfaces, &pairs, &start), &x, &x_end).0, "step {step}");
        rebuilt += usize::from(is_new);
        total += from_aged.len();
        x = slow_end;
    }
    assert!(total > 2000 && rebuilt < 60, "{total} contacts, {rebuilt} lists");
}

#[test]
fn a_far_face_that_moves_fast_does_not_let_go_of_a_node() {
    // A node approaches a face slowly; faces half a size from it move away fast. An old list contains those too.
    let mut x = Vec::new();
    let ground = block(8, 1, &mut x, |p| Vec3::new(p.x, p.y, 0.25 * p.z - 0.25));
    let surfaces = [ground, node(&mut x, Vec3::new(0.5625, 0.5625, 0.001))];
    let (pairs, slave) = ([pair(1, Master::Surface(0))], x.len() - 1);
    let mut moved = x.clone();
    for p in &mut moved {
        p.x += 0.03;
    }
    let mut end = moved.clone();
    end[slave].z -= 0.003;
    for (p, old) in end[..slave].iter_mut().zip(&x) {
        p.x += if (old.x - 0.5625).abs().max((old.y - 0.5625).abs()) > 0.1 { 0.02 } else { 0.0 };
    }
    let mut aged = new(&surfaces, &pairs, &x);
    find(&mut aged, &x, &moved);
    let (contacts, rebuilt) = find(&mut aged, &moved, &end);
    assert!(!rebuilt && contacts.len() == 1, "{contacts:?}");
    assert_eq!(contacts, find(&mut new(&surfaces, &pairs, &x), &moved, &end).0);
}

#[test]
fn random_motion_gives_finite_contacts_and_broken_positions_an_error() {
    let mut x = Vec::new();
    let a = block(3, 3, &mut x, |p| p);
    let b = block(4, 4, &mut x, |p| p * 0.7 + Vec3::new(0.1, 0.2, 1.01));
    let surfaces = [a, b];
    let pairs = [pair(1, Master::Surface(0)), pair(0, Master::Surface(0))];
    let mut detector = new(&surfaces, &pairs, &x);
    for step in 0..300 {
        let shake = |i: usize, k: f64| {
            ((i as f64 * 12.9898 + f64::from(step) * 78.233 + k).sin() * 43758.5453).fract()
        };
        let size = [1e-6, 1e-3, 0.1, 2.0][step as usize % 4];
        let random = |i: usize, s: f64| Vec3::new(shake(i, s), shake(i, s + 1.0), shake(i, s + 2.0)) * size;
        let y: Vec<Vec3> = x.iter().enumerate().map(|(i, p)| p + random(i, 0.0)).collect();
        let y_end: Vec<Vec3> = y.iter().enumerate().map(|(i, p)| p + random(i, 5.0)).collect();
        let (contacts, _) = find(&mut detector, &y, &y_end);
        assert_frames(&contacts);
        for c in &contacts {
            assert!(
                c.gap.is_finite() && (c.stencil.master().map(|(_, w)| w).sum::<f64>() + 1.0).abs() < 1e-9,
                "{c:?}"
            );
        }
    }
    x[3].y = f64::NAN;
    let error = detector.detect(&Motion::of_nodes(&x, &x), &mut Vec::new()).unwrap_err();
    assert_eq!(error, DetectionError::NotFinite { surface: 0 });
}

#[test]
fn whoever_would_end_inside_a_deforming_block_is_stopped() {
    use crate::contact::detection::initial_overlap::initial_overlaps;
    let mut x = Vec::new();
    let target = block(4, 4, &mut x, |p| p);
    let count = x.len();
    let mut bullets = Surface::new(Vec::new(), Vec::new());
    for k in 0..60 {
        bullets.nodes.push((count + k) as u32);
        x.push(Vec3::zeros());
    }
    let surfaces = [target, bullets];
    let pairs = [pair(1, Master::Surface(0))];
    let random = |i: usize, k: usize| ((i as f64 * 12.9898 + k as f64 * 78.233).sin() * 43_758.545_3).fract();
    let mut reference = x.clone();
    reference.truncate(count);
    let (mut stopped, mut inside) = (0, 0);
    for round in 0..100 {
        let vector = |i: usize, k: usize| {
            Vec3::new(random(i, 7 * round + k), random(i, 7 * round + k + 1), random(i, 7 * round + k + 2))
        };
        // Warped faces that move and rotate while the bullets fly through from all sides.
        let mut x_end = x.clone();
        for i in 0..count {
            x[i] = reference[i] + vector(i, 0) * 0.04;
            x_end[i] = x[i] + vector(i, 3) * 0.04 + Vec3::new(0.1 * x[i].y, 0.2, -0.1 * x[i].x);
        }
        for i in count..x.len() {
            let from = vector(i, 0).normalize() * 1.5;
            x[i] = Vec3::repeat(0.5) + from;
            x_end[i] = Vec3::repeat(0.5) - from * (0.5 + 0.5 * random(i, round)) + vector(i, 3) * 0.3;
        }
        let mut detector = new(&surfaces, &pairs, &x);
        let (contacts, _) = find(&mut detector, &x, &x_end);
        assert_frames(&contacts);
        for overlap in initial_overlaps(&mut detector, &x_end) {
            let held = contacts.iter().find(|c| c.slave == overlap.node);
            assert!(
                held.is_some_and(|c| linear_gap(c, &x, &x_end) < 0.0),
                "{overlap:?} in round {round}: {held:?}"
            );
            inside += 1;
        }
        stopped += contacts.len();
    }
    assert!(inside > 500 && stopped > inside, "{inside} would end inside, {stopped} are stopped");
}

#[test]
fn a_node_in_front_of_one_face_is_not_behind_the_edge_of_its_neighbour() {
    // Beside a block, lower than its top: for the top alone, the edge's normal places it inside.
    let mut x = Vec::new();
    let master = block(1, 1, &mut x, |p| p);
    let outside = Vec3::new(1.02, 0.5, 1.0 - 0.06);
    let slave = node(&mut x, outside);
    let found = detect(&[slave, master], &[pair(0, Master::Surface(1))], &x, &x);
    assert!(found.iter().all(|c| c.gap > 0.0), "{found:?}");
    // Beyond the reach of the faces, nothing holds it.
    *x.last_mut().unwrap() = Vec3::new(1.055, 0.5, 1.0 - 0.057);
    let master = block(1, 1, &mut Vec::new(), |p| p);
    let slave = Surface::new(vec![x.len() as u32 - 1], Vec::new());
    assert_eq!(detect(&[slave, master], &[pair(0, Master::Surface(1))], &x, &x), []);
}

#[test]
fn a_fold_of_two_faces_meets_itself_once_it_is_narrow() {
    // Two faces with a common edge at x = 0 are closed like a book from flat to 2°; their outer sides are opposed.
    let contacts = |angle: f64| {
        let (sin, cos) = (0.5 * angle).to_radians().sin_cos();
        let x: Vec<Vec3> = [-1.0, 0.0, 1.0]
            .into_iter()
            .flat_map(|side: f64| [0.0, 1.0].map(|y| Vec3::new(side * sin, y, side.abs() * cos)))
            .collect();
        let surface = Surface::new((0..6).collect(), vec![[0, 2, 3, 1], [2, 4, 5, 3]]);
        let flat: Vec<Vec3> =
            x.iter().enumerate().map(|(i, x)| Vec3::new((i / 2) as f64 - 1.0, x.y, 0.0)).collect();
        let pairs = [pair(0, Master::Surface(0))];
        let surfaces = [surface];
        find(&mut new(&surfaces, &pairs, &flat).with_self_contact_in_every_step(), &x, &x).0
    };
    for open in [180.0, 120.0, 90.0, 60.0, 20.0] {
        assert!(contacts(open).is_empty(), "{open}°: {:?}", contacts(open));
    }
    let mut nodes: Vec<u32> = contacts(2.0).iter().map(|contact| contact.slave).collect();
    nodes.sort_unstable();
    assert_eq!(nodes, [0, 1, 4, 5]);
}
