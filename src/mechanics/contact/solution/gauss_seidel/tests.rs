//! Requirements on the sweeps: agreement with the dense operator, momentum, the cone, and a report where they do not
//! converge.
#![allow(clippy::unwrap_used, clippy::float_cmp, clippy::cast_sign_loss)] // tests may panic; exact equality is intended

use super::super::contact_row::squared;
use super::super::local::natural_map;
use super::*;
use crate::contact::ContactLaw;
use crate::contact::kind::Kind;
use crate::contact::solution::local::proj_coulomb_cone;
use crate::contact::stencil::Stencil;
use crate::random::Random;

impl Random {
    fn frame(&mut self) -> [Vec3; 3] {
        let n = self.vector().normalize();
        let t = n.cross(&self.vector()).normalize();
        [n, t, n.cross(&t)]
    }
}

fn contact(slave: u32, master: [u32; 4], weights: [f64; 4], frame: [Vec3; 3], gap: f64) -> Contact {
    Contact {
        pair: 0,
        kind: Kind::NODE,
        slave,
        face: 0,
        stencil: Stencil::node_on_face(slave, &master, &weights),
        frame,
        gap,
        point: Vec3::zeros(),
        drift: Vec3::zeros(),
        law: ContactLaw::Frictionless,
    }
}

/// `count` contacts among `nodes` nodes. Slaves and master faces have nodes in common, with normals in all
/// directions; for full stick, two bodies with normals within some 40° and one contact per slave instead: full stick
/// in a cluster need not have a solution.
fn random_problem(
    random: &mut Random,
    count: usize,
    nodes: u32,
    mu: f64,
) -> (Vec<Contact>, Vec<Vec3>, Vec<Vec3>) {
    let two_bodies = mu.is_infinite();
    let pick = |random: &mut Random, master: bool| {
        let fraction = 0.5 + 0.499_999 * random.next();
        let fraction = if two_bodies { 0.5 * (fraction + f64::from(u8::from(master))) } else { fraction };
        (fraction * f64::from(nodes)) as u32
    };
    let contacts = (0..count)
        .map(|k| {
            let slave = if two_bodies { k as u32 } else { pick(random, false) };
            let master = [0; 4].map(|_| {
                loop {
                    let n = pick(random, true);
                    if n != slave {
                        break n;
                    }
                }
            });
            let (a, b) = (0.5 + 0.5 * random.next(), 0.5 + 0.5 * random.next());
            let weights = [(1.0 - a) * (1.0 - b), a * (1.0 - b), a * b, (1.0 - a) * b];
            let mut frame = random.frame();
            if two_bodies {
                let n = (Vec3::z() + 0.5 * random.vector()).normalize();
                let t = n.cross(&Vec3::x()).normalize();
                frame = [n, t, n.cross(&t)];
            }
            contact(slave, master, weights, frame, 0.01 * random.next())
        })
        .collect();
    let inverse_mass = (0..nodes).map(|_| Vec3::repeat(1.0 + 0.5 * random.next())).collect();
    let v = (0..nodes).map(|_| random.vector()).collect();
    (contacts, inverse_mass, v)
}

/// C as a dense matrix (3 rows per contact, 3 columns per node).
fn dense_c(contacts: &[Contact], nodes: usize) -> nalgebra::DMatrix<f64> {
    let mut c = nalgebra::DMatrix::zeros(3 * contacts.len(), 3 * nodes);
    for (k, contact) in contacts.iter().enumerate() {
        for (i, axis) in contact.frame.iter().enumerate() {
            for d in 0..3 {
                for (node, w) in contact.stencil.each() {
                    c[(3 * k + i, 3 * node as usize + d)] += w * axis[d];
                }
            }
        }
    }
    c
}

fn stacked(v: &[Vec3]) -> nalgebra::DVector<f64> {
    nalgebra::DVector::from_iterator(3 * v.len(), v.iter().flat_map(|p| [p.x, p.y, p.z]))
}

fn under(law: ContactLaw, contacts: &[Contact]) -> Vec<Contact> {
    contacts.iter().map(|contact| Contact { law, ..contact.clone() }).collect()
}

fn run(
    contacts: &[Contact],
    mu: f64,
    inverse_mass: &[Vec3],
    h: f64,
    v: &mut [Vec3],
) -> (Vec<Reaction>, SolveReport) {
    let mut reactions = Vec::new();
    let options = Options { max_sweeps: 20_000, ..Options::default() };
    let report = solve(
        &under(ContactLaw::of(mu), contacts),
        inverse_mass,
        h,
        v,
        &mut reactions,
        &options,
        &mut Workspace::default(),
    );
    (reactions, report)
}

#[test]
fn nodal_form_agrees_with_the_dense_delassus_operator() {
    let mut random = Random(11);
    let h = 0.1;
    let mut unresolved = 0;
    for case in 0..300 {
        let mu = [0.0, 0.3, 0.7, f64::INFINITY][case % 4];
        let (mut contacts, mut inverse_mass, mut v_star) = random_problem(&mut random, 1 + case % 6, 13, mu);
        if case % 3 == 0 {
            // Fixed nodes at rest.
            inverse_mass[case % 13].y = 0.0;
            v_star[case % 13].y = 0.0;
            inverse_mass[(case + 4) % 13] = Vec3::zeros();
            v_star[(case + 4) % 13] = Vec3::zeros();
        } else {
            // A flight velocity of each node, which enters the contacts as drift.
            let flight: Vec<Vec3> = (0..13).map(|_| random.vector()).collect();
            for c in &mut contacts {
                c.drift = c.stencil.difference(&flight);
            }
        }
        let mut v = v_star.clone();
        let (reactions, report) = run(&contacts, mu, &inverse_mass, h, &mut v);
        if mu.is_infinite() && !report.converged {
            unresolved += 1;
            continue;
        }
        assert!(report.converged, "case {case}: {report:?}");
        let c = dense_c(&contacts, 13);
        let m = nalgebra::DMatrix::from_diagonal(&stacked(&inverse_mass));
        let p =
            nalgebra::DVector::from_iterator(3 * contacts.len(), reactions.iter().flat_map(|r| r.impulse));
        // v⁺ = v* + M⁻¹ Cᵀ p, …
        let expected = stacked(&v_star) + &m * c.transpose() * &p;
        assert!((expected - stacked(&v)).amax() < 1e-12);
        // … and the law at the end velocity.
        let mut q = &c * stacked(&v_star);
        for (k, contact) in contacts.iter().enumerate() {
            for i in 0..3 {
                q[3 * k + i] += contact.frame[i].dot(&contact.drift);
            }
            q[3 * k] += contact.gap.max(0.0) / h;
        }
        let w = &c * &m * c.transpose();
        let u = &w * &p + q;
        for k in 0..contacts.len() {
            let at = |a: &nalgebra::DVector<f64>| [a[3 * k], a[3 * k + 1], a[3 * k + 2]];
            let d = (0..3).map(|i| w[(3 * k + i, 3 * k + i)]).sum::<f64>() / 3.0;
            let mut u = at(&u);
            if mu == 0.0 {
                (u[1], u[2]) = (0.0, 0.0);
            }
            if w[(3 * k, 3 * k)] > 1e-9 {
                let f = natural_map(at(&p), u, mu, 1.0 / d);
                assert!(squared(f).sqrt() <= 1e-8, "case {case}, contact {k}: {f:?}");
            }
        }
    }
    // Full stick is discontinuous where contacts open; the few problems without a solution are reported as such.
    assert!(unresolved <= 4, "{unresolved} of 75");
}

#[test]
fn frictionless_solution_is_that_of_the_quadratic_programme_by_enumeration() {
    let mut random = Random(12);
    for case in 0..100 {
        let count = 1 + case % 5;
        let (contacts, inverse_mass, v_star) = random_problem(&mut random, count, 10, 0.0);
        let mut v = v_star.clone();
        let (reactions, report) = run(&contacts, 0.0, &inverse_mass, 0.1, &mut v);
        assert!(report.converged);
        let full = dense_c(&contacts, 10);
        let normal = nalgebra::DMatrix::from_fn(count, 30, |k, j| full[(3 * k, j)]);
        let w = &normal * nalgebra::DMatrix::from_diagonal(&stacked(&inverse_mass)) * normal.transpose();
        let opening = nalgebra::DVector::from_iterator(count, contacts.iter().map(|c| c.gap.max(0.0) / 0.1));
        let q = &normal * stacked(&v_star) + opening;
        // Exactly one active set gives p ≥ 0 on it and u ≥ 0 off it.
        let solution = (0..1usize << count).find_map(|set| {
            let active: Vec<usize> = (0..count).filter(|k| set >> k & 1 == 1).collect();
            let mut p = nalgebra::DVector::zeros(count);
            if !active.is_empty() {
                let a =
                    nalgebra::DMatrix::from_fn(active.len(), active.len(), |i, j| w[(active[i], active[j])]);
                let b = nalgebra::DVector::from_fn(active.len(), |i, _| -q[active[i]]);
                for (i, x) in active.iter().zip(a.lu().solve(&b)?.iter()) {
                    p[*i] = *x;
                }
            }
            let u = &w * &p + &q;
            (p.min() >= -1e-12 && u.min() >= -1e-12).then_some(p)
        });
        let p = solution.unwrap();
        for k in 0..count {
            assert!((reactions[k].impulse[0] - p[k]).abs() < 1e-8, "case {case}");
            assert_eq!(reactions[k].impulse[1..], [0.0, 0.0]);
        }
    }
}

#[test]
fn one_unknown_gives_the_bits_of_three_without_friction() {
    let mut random = Random(17);
    for case in 0..400 {
        let (mut contacts, mut inverse_mass, v_star) = random_problem(&mut random, 1 + case % 20, 25, 0.0);
        for contact in &mut contacts {
            contact.drift = random.vector();
        }
        // Some fixed axes: blocks that are no multiple of the identity.
        for node in 0..case % 9 {
            inverse_mass[2 * node][case % 3] = 0.0;
        }
        let solved = |law: ContactLaw| {
            let (mut v, mut reactions) = (v_star.clone(), Vec::new());
            let (options, mut workspace) = (Options::default(), Workspace::default());
            let report = solve(
                &under(law, &contacts),
                &inverse_mass,
                0.1,
                &mut v,
                &mut reactions,
                &options,
                &mut workspace,
            );
            // Adding +0 removes the sign of zeros and leaves all other bits.
            let bits = |x: f64| (x + 0.0).to_bits();
            let impulses: Vec<u64> = reactions.iter().flat_map(|r| r.impulse).map(bits).collect();
            let velocities: Vec<u64> = v.iter().flatten().copied().map(bits).collect();
            (report, impulses, velocities)
        };
        let (one, three) = (solved(ContactLaw::Frictionless), solved(ContactLaw::Coulomb(0.0)));
        assert_eq!(one, three, "case {case}");
    }
}

#[test]
fn two_masses_meet_as_in_an_inelastic_impact_and_momentum_is_kept() {
    // One node against the point between two others, of masses 1, 2, 2.
    let frame = [Vec3::z(), Vec3::x(), Vec3::y()];
    let contacts = [contact(0, [1, 2, 2, 2], [0.5, 0.5, 0.0, 0.0], frame, 0.0)];
    let inverse_mass = [Vec3::repeat(1.0), Vec3::repeat(0.5), Vec3::repeat(0.5)];
    let mut v = [Vec3::new(0.0, 0.0, -3.0), Vec3::zeros(), Vec3::zeros()];
    let (reactions, report) = run(&contacts, 0.4, &inverse_mass, 1e-3, &mut v);
    assert!(report.converged && report.sweeps == 1);
    // p = u/W with W = 1 + 2 · 0.25 · 0.5.
    assert!((reactions[0].impulse[0] - 3.0 / 1.25).abs() < 1e-15);
    let momentum = v[0] + 2.0 * v[1] + 2.0 * v[2];
    assert!((momentum - Vec3::new(0.0, 0.0, -3.0)).norm() < 1e-15);
    assert!((v[0] - 0.5 * (v[1] + v[2])).norm() < 1e-15);
}

#[test]
fn a_gap_lets_the_node_come_just_to_touch_and_a_negative_one_asks_for_nothing() {
    let frame = [Vec3::z(), Vec3::x(), Vec3::y()];
    let h = 1e-6;
    for (gap, expected) in [(1e-6, -1.0), (1e-5, -3.0), (0.0, 0.0), (-1e-3, 0.0)] {
        let contacts = [contact(0, [0; 4], [0.0; 4], frame, gap)];
        let mut v = [Vec3::new(0.1, 0.0, -3.0)];
        let (_, report) = run(&contacts, 0.0, &[Vec3::repeat(2.0)], h, &mut v);
        assert!(report.converged);
        assert!((v[0] - Vec3::new(0.1, 0.0, expected)).norm() < 1e-14, "gap {gap}: {}", v[0]);
    }
}

#[test]
fn open_and_immovable_contacts_leave_every_bit() {
    let mut random = Random(13);
    let frame = random.frame();
    let open = contact(0, [1, 2, 3, 4], [0.25; 4], frame, 1.0);
    let fixed = contact(5, [6, 7, 8, 9], [0.25; 4], frame, 0.0);
    let mut v: Vec<Vec3> = (0..10).map(|_| random.vector()).collect();
    let mut inverse_mass = vec![Vec3::repeat(1.0); 10];
    for m in &mut inverse_mass[5..] {
        *m = Vec3::zeros();
    }
    v[5] = -frame[0];
    let before = v.clone();
    let (reactions, report) = run(&[open, fixed], 0.3, &inverse_mass, 1e-3, &mut v);
    assert_eq!((report.sweeps, report.converged), (0, true));
    assert_eq!(v, before);
    assert_eq!(reactions, vec![Reaction::default(); 2]);
    let (_, report) = run(&[], 0.3, &[], 1e-3, &mut []);
    assert_eq!((report.sweeps, report.residual, report.converged), (0, 0.0, true));
}

#[test]
fn thousand_random_problems_converge_keep_momentum_and_obey_the_cone() {
    let mut random = Random(14);
    let mut unresolved = 0;
    for case in 0..1000 {
        let mu = [0.0, 0.1, 0.5, f64::INFINITY][case % 4];
        let (contacts, inverse_mass, v_star) = random_problem(&mut random, 1 + case % 20, 40, mu);
        let mut v = v_star.clone();
        let (reactions, report) = run(&contacts, mu, &inverse_mass, 0.1, &mut v);
        if mu.is_infinite() && !report.converged {
            unresolved += 1;
        } else {
            assert!(report.converged, "case {case}: {report:?}");
        }
        let momentum =
            |v: &[Vec3]| v.iter().zip(&inverse_mass).map(|(v, m)| v.component_div(m)).sum::<Vec3>();
        assert!((momentum(&v) - momentum(&v_star)).norm() < 1e-11);
        for r in &reactions {
            if mu.is_finite() {
                let inside = proj_coulomb_cone(r.impulse, mu);
                assert!(squared([0, 1, 2].map(|i| inside[i] - r.impulse[i])) < 1e-24);
            }
            assert!(r.impulse[0] >= 0.0);
        }
    }
    assert!(unresolved <= 12, "{unresolved} of 250");
}

#[test]
fn running_out_of_sweeps_is_said() {
    let mut random = Random(15);
    let (contacts, inverse_mass, mut v) = random_problem(&mut random, 20, 10, 0.3);
    let options = Options { max_sweeps: 2, tolerance: 1e-14, acceptable: 0.0 };
    let mut reactions = Vec::new();
    let report = solve(
        &under(ContactLaw::Coulomb(0.3), &contacts),
        &inverse_mass,
        0.1,
        &mut v,
        &mut reactions,
        &options,
        &mut Workspace::default(),
    );
    assert!(!report.converged && report.sweeps == 2 && report.residual > 1e-14, "{report:?}");
}
#[test]
fn strong_friction_that_makes_sweeps_cycle_converges_by_damping() {
    let mut random = Random(16);
    for case in 0..500 {
        let (contacts, inverse_mass, v) = random_problem(&mut random, 1 + case % 20, 40, f64::INFINITY);
        for mu in [3.0, 30.0] {
            let (_, report) = run(&contacts, mu, &inverse_mass, 0.1, &mut v.clone());
            assert!(report.converged, "case {case}, mu {mu}: {report:?}");
        }
    }
}

#[test]
fn a_pile_that_needs_many_sweeps_leaves_other_contacts_alone() {
    // A hundred masses in a row that a plane stops at one end, and forty single masses, half of which come to rest on theirs.
    let along = [Vec3::z(), Vec3::x(), Vec3::y()];
    let (pile, singles) = (100, 40);
    let on_next = |i: u32| contact(i + 1, [i; 4], [0.25; 4], along, 0.0);
    let on_plane = |node: u32, gap: f64| contact(node, [node; 4], [0.0; 4], along, gap);
    let mut contacts = vec![on_plane(0, 0.0)];
    contacts.extend((0..pile - 1).map(on_next));
    contacts.extend((0..singles).map(|i| on_plane(pile + i, if i % 2 == 0 { 0.0 } else { 1.0 })));
    let inverse_mass = vec![Vec3::repeat(1.0); (pile + singles) as usize];
    let mut v = vec![-Vec3::z(); (pile + singles) as usize];
    let (reactions, report) = run(&contacts, 0.2, &inverse_mass, 1e-3, &mut v);
    assert!(report.converged, "{report:?}");
    // All of the pile comes to rest: a contact carries the momentum of the masses behind it.
    for (i, reaction) in reactions.iter().take(pile as usize).enumerate() {
        let carried = f64::from(pile) - i as f64;
        assert!((reaction.impulse[0] - carried).abs() < 1e-6 * carried, "{i}: {reaction:?}");
    }
    for (i, reaction) in reactions[pile as usize..].iter().enumerate() {
        assert_eq!(reaction.impulse, [if i % 2 == 0 { 1.0 } else { 0.0 }, 0.0, 0.0]);
    }
    // The pile alone takes as many sweeps.
    let mut v = vec![-Vec3::z(); pile as usize];
    let (_, alone) = run(&contacts[..pile as usize], 0.2, &inverse_mass[..pile as usize], 1e-3, &mut v);
    assert!(alone.sweeps > 50 && report.sweeps < 2 * alone.sweeps, "{} and {}", alone.sweeps, report.sweeps);
}

#[test]
fn impulses_are_measured_by_the_motion_that_they_change() {
    // A light mass on a plane under a heavy one, and squeezed by a driven node: its impulses grow, and change no velocity.
    let along = [Vec3::z(), Vec3::x(), Vec3::y()];
    let on = |slave: u32, master: u32| contact(slave, [master; 4], [0.25; 4], along, 0.0);
    let contacts = [on(0, 3), on(1, 0), on(2, 0)];
    for (masses, driven) in [([1e-3, 1.0], 0.0), ([1.0, 1.0], -0.5)] {
        let inverse = masses.map(|m: f64| Vec3::repeat(1.0 / m));
        let inverse_mass = [inverse[0], inverse[1], Vec3::zeros(), Vec3::zeros()];
        let start = [Vec3::zeros(), -Vec3::z(), Vec3::z() * driven, Vec3::zeros()];
        let mut v = start;
        let mut reactions = Vec::new();
        let options = Options { tolerance: 1e-14, max_sweeps: 20, acceptable: 0.0 };
        let laws = under(ContactLaw::Coulomb(0.3), &contacts);
        let report =
            solve(&laws, &inverse_mass, 0.1, &mut v, &mut reactions, &options, &mut Workspace::default());
        // D of each contact, with free velocities of −1 or of the driven node.
        let d = [1.0 / masses[0], 1.0 / masses[0] + 1.0 / masses[1], 1.0 / masses[0]];
        let impulse: f64 = reactions.iter().zip(d).map(|(p, d)| d * squared(p.impulse)).sum();
        let closing = 1.0 / d[1] + driven * driven / d[2];
        let motion: f64 = (0..2).map(|i| masses[i] * (v[i] - start[i]).norm_squared()).sum();
        let expected = (closing.max(impulse) / closing.max(motion)).sqrt();
        let ratio = report.residual_of_motion / report.residual;
        assert!((ratio / expected - 1.0).abs() < 1e-9 && expected > 3.0, "{ratio}, {expected}: {report:?}");
    }
}
