use super::super::narrow_phase::eval_proximity;
use super::*;
use crate::contact::detection::detectors::{ContactModel, Detectors};
use crate::contact::pairs::Pairs;
use crate::contact::solution::gauss_seidel::{Options, Workspace, solve};
use crate::contact::{ContactPair, Discretisation, Master, Reaction, Surface};

/// A box of n³ cells, given its corner `at` and its size, rotated about its centre; its boundary surface.
fn cube(at: Vec3, size: f64, n: u32, turn: &nalgebra::Rotation3<f64>, x: &mut Vec<Vec3>) -> Surface {
    let base = x.len() as u32;
    let middle = at + Vec3::repeat(0.5 * size);
    let m = n + 1;
    let all: Vec<[u32; 3]> = (0..m * m * m).map(|i| [i % m, i / m % m, i / m / m]).collect();
    let on_boundary = |ijk: &[u32; 3]| ijk.iter().any(|i| *i == 0 || *i == n);
    let mut number = vec![u32::MAX; all.len()];
    let mut nodes = Vec::new();
    for (place, ijk) in all.iter().enumerate().filter(|(_, ijk)| on_boundary(ijk)) {
        number[place] = base + nodes.len() as u32;
        nodes.push(number[place]);
        let X = at + Vec3::from(ijk.map(|i| f64::from(i) * size / f64::from(n)));
        x.push(middle + turn * (X - middle));
    }
    let mut faces = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let node = |a: u32, b: u32| {
                        let mut ijk = [0; 3];
                        (ijk[axis], ijk[(axis + 1) % 3], ijk[(axis + 2) % 3]) = (side, a, b);
                        number[(ijk[0] + m * (ijk[1] + m * ijk[2])) as usize]
                    };
                    let face = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
                    faces.push(if side == 0 { [face[0], face[3], face[2], face[1]] } else { face });
                }
            }
        }
    }
    Surface::new(nodes, faces)
}

fn pair(slave: usize, master: usize) -> ContactPair {
    ContactPair { slave, master: Master::Surface(master), law: ContactLaw::Frictionless }
}

/// All contacts of a step, including those of slave nodes.
fn contacts_of(surfaces: &[Surface], x0: &[Vec3], x: &[Vec3], x_end: &[Vec3]) -> Vec<Contact> {
    let mut contacts = Vec::new();
    detectors(surfaces, x0).detect(&Motion::of_nodes(x, x_end), &mut contacts).unwrap();
    contacts
}

/// The detectors of two surfaces, at the start of the run.
fn detectors(surfaces: &[Surface], x: &[Vec3]) -> Detectors {
    let (pairs, discretisation) = ([pair(0, 1)].into_iter().collect(), Discretisation::TwoPass);
    let always_searches_self_contact = false;
    let model =
        ContactModel { surfaces, pairs: &pairs, rigid: &[], discretisation, always_searches_self_contact, x };
    Detectors::new(&model, 0, &Threads::ONE)
}

fn plain() -> nalgebra::Rotation3<f64> {
    nalgebra::Rotation3::identity()
}

/// Steps with nodes of equal masses, without forces; the second surface has an initial velocity. The nodes of each
/// surface move as one: what contact gives to some of them is distributed to the others until nothing closes any
/// more.
fn fly(surfaces: &[Surface], x: &mut [Vec3], velocity: Vec3, h: f64, steps: usize) {
    let mut detectors = detectors(surfaces, x);
    let inverse_mass = vec![Vec3::repeat(1.0); x.len()];
    let mut v = vec![Vec3::zeros(); x.len()];
    surfaces[1].nodes.iter().for_each(|&node| v[node as usize] = velocity);
    let mut contacts = Vec::new();
    for _ in 0..steps {
        let x_end: Vec<Vec3> = x.iter().zip(&v).map(|(x, v)| x + v * h).collect();
        detectors.detect(&Motion::of_nodes(x, &x_end), &mut contacts).unwrap();
        for _ in 0..if contacts.is_empty() { 0 } else { 200 } {
            let mut reactions = vec![Reaction::default(); contacts.len()];
            let report = solve(
                &contacts,
                &inverse_mass,
                h,
                &mut v,
                &mut reactions,
                &Options::default(),
                &mut Workspace::default(),
            );
            assert!(report.converged);
            for Surface { nodes, .. } in surfaces {
                let mean = nodes.iter().map(|&node| v[node as usize]).sum::<Vec3>() / nodes.len() as f64;
                for &node in nodes {
                    v[node as usize] = mean;
                }
            }
        }
        x.iter_mut().zip(&v).for_each(|(x, v)| *x += v * h);
    }
}

#[test]
fn a_corner_of_the_coarse_surface_is_stopped_by_the_middle_of_a_slave_face_at_any_speed() {
    let turn = nalgebra::Rotation3::rotation_between(&Vec3::repeat(-1.0), &-Vec3::z()).unwrap();
    for speed in [1.0_f64, 30.0, 1000.0] {
        let mut x = Vec::new();
        // Its only node is the corner that points down; no node of the floor is near it.
        let floor = cube(Vec3::new(-1.5, -1.5, -3.0), 3.0, 3, &plain(), &mut x);
        let top = cube(Vec3::new(-0.5, -0.5, 0.5), 1.0, 1, &turn, &mut x);
        let from = x.clone();
        let lowest = top.nodes.iter().map(|&n| x[n as usize].z).fold(f64::INFINITY, f64::min);
        assert!(lowest > 0.0);
        // One step that would carry it through, or many small ones.
        let steps = if speed > 10.0 { 1 } else { 400 };
        let h = 8.0 / speed / f64::from(steps);
        fly(&[floor.clone(), top.clone()], &mut x, Vec3::new(0.0, 0.0, -speed), h, steps as usize);
        let boundary = super::super::boundary::Boundary::new(&floor, &from);
        for &node in &top.nodes {
            let s = &x[node as usize];
            let below = floor
                .faces
                .iter()
                .enumerate()
                .filter_map(|(i, _)| eval_proximity(&boundary, i as u32, s, &x));
            let nearest = below.min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap();
            assert!(nearest.gap > -0.05, "at {speed} m/s node {node} ends {} inside", -nearest.gap);
        }
    }
}

#[test]
fn crossed_edges_do_not_pass_each_other_at_any_speed() {
    // Two long bars with square sections stand on edge, crosswise: only their edges meet, far from all nodes.
    let bar = |at: Vec3, along: usize, x: &mut Vec<Vec3>| {
        let first = x.len();
        let surface = cube(Vec3::repeat(-0.5), 1.0, 1, &plain(), x);
        let edge_down = nalgebra::Rotation3::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_4);
        let about_z =
            nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), if along == 0 { 0.03 } else { 1.5 });
        for x in &mut x[first..] {
            *x = at + about_z * (edge_down * Vec3::new(6.0 * x.x, x.y, x.z));
        }
        surface
    };
    for (speed, steps) in [(1.0_f64, 300), (50.0, 3), (1000.0, 1)] {
        let mut x = Vec::new();
        let lower = bar(Vec3::zeros(), 0, &mut x);
        let upper = bar(Vec3::new(0.1, 0.2, 1.6), 1, &mut x);
        let (middle, top) =
            (|x: &[Vec3], s: &Surface| s.nodes.iter().map(|&n| x[n as usize].z).sum::<f64>() / 8.0, &upper);
        let h = 6.0 / speed / f64::from(steps);
        fly(&[lower.clone(), upper.clone()], &mut x, Vec3::new(0.0, 0.0, -speed), h, steps as usize);
        let apart = middle(&x, top) - middle(&x, &lower);
        // The edges touch where the centres are √2 apart.
        assert!((apart - 2.0_f64.sqrt()).abs() < 0.01, "at {speed} m/s the middles are {apart} apart");
    }
}

#[test]
fn what_slave_nodes_hold_constrains_nothing_more() {
    let mut x = Vec::new();
    let floor = cube(Vec3::new(-1.5, -1.5, -3.0), 3.0, 6, &plain(), &mut x);
    let top = cube(Vec3::new(-0.4, -0.6, 0.0), 1.0, 1, &plain(), &mut x);
    let contacts = contacts_of(&[floor, top], &x, &x, &x);
    assert!(!contacts.is_empty() && contacts.iter().all(|c| c.kind == Kind::NODE), "{contacts:?}");
}

#[test]
fn a_node_far_inside_is_held_by_the_closest_face_of_all_at_any_age_of_the_list() {
    let mut x = Vec::new();
    let small = cube(Vec3::new(0.4, 0.3, 0.55), 0.1, 1, &plain(), &mut x);
    let big = cube(Vec3::zeros(), 1.0, 4, &plain(), &mut x);
    let surfaces = [small.clone(), big];
    let (pairs, mut contacts): (Pairs, _) = ([pair(0, 1)].into_iter().collect(), Vec::new());
    let mut aged = NodeToFace::new(&surfaces, &pairs, &x);
    for k in 0..40 {
        let mut moved = x.clone();
        let way = Vec3::new(0.0, 0.0, 0.4 - 0.02 * f64::from(k));
        small.nodes.iter().for_each(|&node| moved[node as usize] += way);
        contacts.clear();
        aged.detect(&Motion::of_nodes(&moved, &moved), &mut contacts).unwrap();
        let from_aged = std::mem::take(&mut contacts);
        NodeToFace::new(&surfaces, &pairs, &x)
            .detect(&Motion::of_nodes(&moved, &moved), &mut contacts)
            .unwrap();
        assert_eq!(from_aged, contacts, "step {k}");
        for &node in &small.nodes {
            let s = moved[node as usize];
            let depth = s.iter().flat_map(|c| [*c, 1.0 - c]).fold(f64::INFINITY, f64::min);
            let held = contacts.iter().find(|c| c.slave == node);
            if depth > 1e-9 {
                let held = held.unwrap();
                assert!((held.gap + depth).abs() < 1e-12, "{} for {depth}", held.gap);
                assert!(held.frame[0].amax() > 1.0 - 1e-12);
            }
        }
    }
}
