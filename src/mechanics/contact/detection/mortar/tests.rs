//! Requirements on averages: a uniform pressure is transferred, straight and curved, and no row has a moment.
#![allow(clippy::unwrap_used)] // tests may panic

use super::{AVERAGED, Mortar};
use crate::contact::detection::closest_point::Patch;
use crate::contact::detection::detector::{Detector, Motion};
use crate::contact::detection::node_to_face::NodeToFace;
use crate::contact::kind::Kind;
use crate::contact::{Contact, ContactLaw, ContactPair, Discretisation, Master, Surface};
use crate::tensor::Vec3;
use std::f64::consts::FRAC_PI_3;

/// A sheet of n × m faces, `place` of (0 … 1, 0 … 1), reversed if `turned`.
fn sheet(n: u32, m: u32, turned: bool, x: &mut Vec<Vec3>, place: impl Fn(f64, f64) -> Vec3) -> Surface {
    let base = x.len() as u32;
    for j in 0..=m {
        for i in 0..=n {
            x.push(place(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
        }
    }
    let at = |i: u32, j: u32| base + j * (n + 1) + i;
    let cells = (0..m).flat_map(|j| (0..n).map(move |i| (i, j)));
    let faces = cells.map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        if turned { [a, d, c, b] } else { [a, b, c, d] }
    });
    Surface::new((base..x.len() as u32).collect(), faces.collect())
}

fn contacts(slave: Surface, master: Surface, x: &[Vec3], by: Discretisation) -> Vec<Contact> {
    let (master, law) = ([slave, master], ContactLaw::Frictionless);
    let pair = ContactPair { slave: 0, master: Master::Surface(1), law };
    let mut found = Vec::new();
    let nodes = NodeToFace::new(&master, &[pair].into_iter().collect(), x);
    let mut detector: Box<dyn Detector> =
        if by == Discretisation::Mortar { Box::new(Mortar::new(nodes)) } else { Box::new(nodes) };
    detector.detect(&Motion::of_nodes(x, x), &mut found).unwrap();
    found
}

/// Gauss points and weights on 0 … 1.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Nodal loads of a pressure of 1 on the faces, `∫ N n dA`, by 3 × 3 points.
fn loads(surface: &Surface, x: &[Vec3]) -> Vec<Vec3> {
    let mut loads = vec![Vec3::zeros(); x.len()];
    for face in &surface.faces {
        let patch = Patch::new(face, x);
        for (a, w_a) in GAUSS {
            for (b, w_b) in GAUSS {
                let shape = patch.weights(a, b);
                let (u, v) = patch.tangents(&shape);
                for (&node, n) in face.iter().zip(shape) {
                    loads[node as usize] -= u.cross(&v) * (n * w_a * w_b);
                }
            }
        }
    }
    loads
}

/// Largest error of the load on a master node, relative to the load there, for a pressure of 1 on the slave, over the
/// nodes that `look` selects.
fn error(
    (slave, master): (Surface, Surface),
    x: &[Vec3],
    by: Discretisation,
    look: impl Fn(&Vec3) -> bool,
) -> f64 {
    let (from, wanted) = (loads(&slave, x), loads(&master, x));
    let nodes = master.nodes.clone();
    let mut got = vec![Vec3::zeros(); x.len()];
    for contact in contacts(slave, master, x, by) {
        // The reaction that balances a pressure on the other side of the slave node.
        let p = contact.frame[0] * contact.frame[0].dot(&from[contact.slave as usize]);
        for (node, w) in contact.stencil.master() {
            got[node as usize] += p * w;
        }
    }
    let miss = |n: &u32| {
        let n = *n as usize;
        (got[n] - wanted[n]).norm() / wanted[n].norm()
    };
    nodes.iter().filter(|n| look(&x[**n as usize])).map(miss).fold(0.0, f64::max)
}

fn flat(slave: u32, master: u32, by: Discretisation) -> f64 {
    let mut x = Vec::new();
    // The slave's inner lines are curved, so that no face is a rectangle.
    let bend = |a: f64, b: f64| {
        let s = |t: f64| (std::f64::consts::PI * t).sin();
        Vec3::new(a + 0.04 * s(2.0 * a) * s(b), b + 0.05 * s(a) * s(2.0 * b), 0.0)
    };
    let above = sheet(slave, slave, true, &mut x, bend);
    let below = sheet(master, master, false, &mut x, |a, b| Vec3::new(a, b, 0.0));
    error((above, below), &x, by, |_| true)
}

/// A 60° sector of two shells of radius 1, with 3 : 2 elements or vice versa; the master extends beyond the slave.
fn curved(slave: u32, master: u32, by: Discretisation) -> f64 {
    let mut x = Vec::new();
    let on = |angle: f64, y: f64| Vec3::new(angle.sin(), y, -angle.cos());
    let outer = sheet(slave, slave / 2, false, &mut x, |a, b| on(FRAC_PI_3 * (a - 0.5), b));
    let inner = sheet(master, master / 2, true, &mut x, |a, b| on(FRAC_PI_3 * (a - 0.5), b));
    // The outer shell faces inwards, the inner one outwards; nodes at the two straight ends have half a load.
    error((outer, inner), &x, by, |p| p.x.abs() < 0.4)
}

#[test]
fn a_uniform_pressure_is_passed_on_between_flat_meshes() {
    for (slave, master) in [(6, 4), (9, 7), (12, 12), (4, 6), (5, 9)] {
        let nodes = flat(slave, master, Discretisation::NodeToSurface);
        let mortar = flat(slave, master, Discretisation::Mortar);
        println!("flat {slave} on {master}: nodes {nodes:.4}, mortar {mortar:.5}");
        assert!(mortar < 0.02, "{slave} on {master}: {mortar}");
    }
}

#[test]
fn a_uniform_pressure_is_passed_on_between_curved_meshes() {
    for (slave, master) in [(12, 8), (18, 12), (8, 12)] {
        let nodes = curved(slave, master, Discretisation::NodeToSurface);
        let mortar = curved(slave, master, Discretisation::Mortar);
        println!("curved {slave} on {master}: nodes {nodes:.4}, mortar {mortar:.5}");
        assert!(mortar < 0.02, "{slave} on {master}: {mortar}");
    }
}

#[test]
fn no_row_moves_or_turns_the_two_bodies_together() {
    let mut x = Vec::new();
    let wave =
        |a: f64, b: f64, lift: f64| Vec3::new(a, b, 0.02 * (6.0 * a + 1.0).sin() * (5.0 * b).cos() + lift);
    let above = sheet(9, 8, true, &mut x, |a, b| wave(a, b, 0.001));
    let below = sheet(7, 7, false, &mut x, |a, b| wave(a, b, 0.0));
    let found = contacts(above, below, &x, Discretisation::Mortar);
    let averaged: Vec<&Contact> = found.iter().filter(|c| c.kind == AVERAGED).collect();
    assert!(averaged.len() > 40, "{} of {}", averaged.len(), found.len());
    for c in averaged {
        let sum: f64 = c.stencil.weights().iter().sum();
        assert!(sum.abs() < 1e-13, "{sum}");
        let between = c.stencil.difference(&x);
        assert!(between.cross(&c.frame[0]).norm() < 1e-14, "{between}");
        assert!((c.gap - c.frame[0].dot(&between)).abs() < 1e-15);
    }
}

#[test]
fn a_slave_too_coarse_for_a_stencil_keeps_its_nodes() {
    let mut x = Vec::new();
    let above = sheet(3, 3, true, &mut x, |a, b| Vec3::new(0.1 + 0.8 * a, 0.1 + 0.8 * b, 0.0));
    let below = sheet(20, 20, false, &mut x, |a, b| Vec3::new(a, b, 0.0));
    let found = contacts(above, below, &x, Discretisation::Mortar);
    assert_eq!(found.len(), 16);
    assert!(found.iter().all(|c| c.kind == Kind::NODE && c.gap.abs() < 1e-12));
}
