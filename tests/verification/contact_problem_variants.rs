//! Contact problems beyond the saved ones: strong friction, and packings of spheres.

use contuse::mechanics::contact::solution::delassus::{Block, Delassus};
use contuse::mechanics::contact::solution::problem::ContactProblem;
use contuse::mechanics::contact::solution::solvers::{Options, SolveReport, solve};
use contuse::mechanics::tensor::{Mat3, Vec3};
use contuse::record::read_contact_problem;
use std::path::Path;

fn solve_from_rest(problem: &ContactProblem, most: usize) -> (Vec<f64>, SolveReport) {
    let mut r = vec![0.0; problem.q().len()];
    let report = solve(problem, &mut r, &Options { max_iterations: Some(most), ..Options::default() });
    (r, report)
}

/// Where the solution counts as converged, nothing approaches and nothing pulls, however large μ.
#[test]
fn strong_friction_hides_no_approach() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/contact_problems");
    let mut converged = 0;
    for name in
        ["01_FC3D_1c", "05_TwoRods1", "06_Rover1039", "12_OneObject-i1028", "21_Confeti-ex13", "g01_hex_1c"]
    {
        let bytes = std::fs::read(folder.join(format!("{name}.json"))).unwrap();
        let given = read_contact_problem(&bytes, "").unwrap().problem;
        for mu in [1e2, 1e4, 1e5, 1e7, 1e9, f64::INFINITY] {
            let mu = vec![mu; given.contacts()];
            let problem = ContactProblem::new(given.W().clone(), given.q().to_vec(), mu.clone()).unwrap();
            let (r, report) = solve_from_rest(&problem, 2000);
            if !report.converged {
                continue;
            }
            converged += 1;
            // In the units of each contact, relative to all of them, as in the scaled error.
            let (d, u) = (problem.scales(), problem.velocity(&r));
            let size = |x: &[f64], power: f64| {
                x.iter().enumerate().map(|(i, x)| x * x * d[i / 3].powf(power)).sum::<f64>().sqrt()
            };
            let largest = size(problem.q(), -1.0).max(size(&r, 1.0));
            for c in 0..problem.contacts() {
                let approach = -u[3 * c] / d[c].sqrt() / largest;
                let pull = -r[3 * c] * d[c].sqrt() / largest;
                assert!(approach <= 1.1e-8 && pull <= 1.1e-8, "{name}, μ {}: {approach:e}, {pull:e}", mu[c]);
            }
        }
    }
    assert!(converged >= 15, "{converged}");
}

/// Spheres of radius ½, mass 1 in close layers, a little out of place, that fall and spin: the impacts between them and with the floor.
fn packing(across: usize, mu: f64) -> ContactProblem {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    // Places and velocities (of the centre, of rotation).
    let mut spheres = Vec::new();
    for (i, j, k) in (0..across.pow(3)).map(|n| (n % across, n / across % across, n / across / across)) {
        let shift = 0.5 * (k % 2) as f64;
        let place = Vec3::new(i as f64 + shift, j as f64 + shift, k as f64 * 0.5_f64.sqrt());
        let mut vector = |size: f64| Vec3::new(random(), random(), random()) * size;
        spheres.push((place + vector(0.03), vector(0.2) - Vec3::new(0.0, 0.0, 0.5), vector(0.5)));
    }
    // Contacts: spheres closer than 1.02, and the floor.
    let mut contacts = Vec::new();
    for (a, (place, ..)) in spheres.iter().enumerate() {
        if place.z < 0.1 {
            contacts.push((a, None, Vec3::z()));
        }
        for (b, (other, ..)) in spheres.iter().enumerate().skip(a + 1) {
            let between = place - other;
            if between.norm() < 1.02 {
                contacts.push((a, Some(b), between.normalize()));
            }
        }
    }
    // Rows of one contact for one sphere: of its velocity and of its rotation, whose inertia is 1/10.
    let rows = |(a, b, normal): &(usize, Option<usize>, Vec3), sphere: usize| {
        let sign = if sphere == *a {
            1.0
        } else if Some(sphere) == *b {
            -1.0
        } else {
            return None;
        };
        let other = if normal.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
        let t = normal.cross(&other).normalize();
        let frame = Mat3::from_columns(&[*normal, t, normal.cross(&t)]).transpose();
        // v + ω × arm, the arm along the normal, inwards.
        Some((frame * sign, frame * -(normal * -0.5).cross_matrix()))
    };
    let (mut blocks, mut q) = (Vec::new(), Vec::new());
    for (c, contact) in contacts.iter().enumerate() {
        let both = [Some(contact.0), contact.1];
        let velocity = both
            .iter()
            .flatten()
            .filter_map(|s| rows(contact, *s).map(|(v, w)| v * spheres[*s].1 + w * spheres[*s].2));
        q.extend(velocity.fold(Vec3::zeros(), |sum, v| sum + v).iter());
        for (d, other) in contacts.iter().enumerate() {
            let product = |s: &usize| {
                let ((v, w), (v2, w2)) = (rows(contact, *s)?, rows(other, *s)?);
                Some(v * v2.transpose() + w * w2.transpose() * 10.0)
            };
            let products: Vec<Mat3> = both.iter().flatten().filter_map(product).collect();
            if !products.is_empty() {
                let sum: Mat3 = products.iter().sum();
                let block: Block = std::array::from_fn(|i| std::array::from_fn(|j| sum[(i, j)]));
                blocks.push((c, d, block));
            }
        }
    }
    let count = contacts.len();
    ContactProblem::new(Delassus::from_blocks(count, blocks).unwrap(), q, vec![mu; count]).unwrap()
}

/// Sweeps and Newton steps in turn solve what either alone does not.
#[test]
fn packings_of_spheres_are_solved() {
    for (across, mu) in [(4, 0.5), (5, 0.5), (6, 0.3)] {
        let problem = packing(across, mu);
        let (r, report) = solve_from_rest(&problem, 20_000);
        assert!(report.converged, "{} contacts, μ {mu}: {report:?}", problem.contacts());
        assert!(problem.error_scaled(&r) <= 1e-8);
    }
}
