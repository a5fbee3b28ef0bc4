//! The exact solution of one contact against the law, and the projection against its definition.
#![allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact equality is intended

use super::*;
use crate::contact::solution::slip::solve_contact;
use crate::random::Random;

impl Random {
    /// `A Aᵀ + shift I`.
    fn operator(&mut self, rank: usize, shift: f64) -> LocalOperator {
        let columns: Vec<Local> = (0..rank).map(|_| self.numbers()).collect();
        let mut w = [[0.0; 3]; 3];
        for (i, row) in w.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x = columns.iter().map(|a| a[i] * a[j]).sum::<f64>() + if i == j { shift } else { 0.0 };
            }
        }
        w
    }
}

fn apply(W: &LocalOperator, r: Local, q: Local) -> Local {
    [0, 1, 2].map(|i| W[i][0] * r[0] + W[i][1] * r[1] + W[i][2] * r[2] + q[i])
}

fn norm(a: Local) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// ‖D^½ F‖ / max(‖D^½ r‖, ‖D^−½ q‖) with D = tr W / 3 and ρ = 1/D.
fn scaled_residual(W: &LocalOperator, q: Local, mu: f64, r: Local) -> f64 {
    let d = (W[0][0] + W[1][1] + W[2][2]) / 3.0;
    let f = natural_map(r, apply(W, r, q), mu, 1.0 / d);
    norm(f) * d.sqrt() / (norm(r) * d.sqrt()).max(norm(q) / d.sqrt())
}

#[test]
fn projection_matches_the_worked_example_and_the_three_cases() {
    let p = proj_coulomb_cone([2.0, 3.0, 4.0], 0.5);
    for (got, expected) in p.into_iter().zip([3.6, 1.08, 1.44]) {
        assert!((got - expected).abs() <= 4.0 * f64::EPSILON, "{p:?}");
    }
    assert!((p[1].hypot(p[2]) - 0.5 * p[0]).abs() <= 4.0 * f64::EPSILON);
    assert_eq!(proj_coulomb_cone([2.0, 0.3, 0.4], 0.5), [2.0, 0.3, 0.4]);
    assert_eq!(proj_coulomb_cone([-2.0, 3.0, 0.0], 0.5), [0.0; 3]);
    assert_eq!(proj_coulomb_cone([0.0; 3], 0.5), [0.0; 3]);
    // For μ = 0 the cone is the half line of normal reactions.
    assert_eq!(proj_coulomb_cone([2.0, 3.0, 4.0], 0.0), [2.0, 0.0, 0.0]);
    assert_eq!(proj_coulomb_cone([-2.0, 0.0, 0.0], 0.0), [0.0; 3]);
}

#[test]
fn projection_is_idempotent_and_orthogonal() {
    let mut random = Random(1);
    for _ in 0..5000 {
        let (a, mu) = (random.numbers(), 1.5 * random.next().abs());
        let p = proj_coulomb_cone(a, mu);
        let again = proj_coulomb_cone(p, mu);
        let step = [a[0] - p[0], a[1] - p[1], a[2] - p[2]];
        assert!(norm([again[0] - p[0], again[1] - p[1], again[2] - p[2]]) <= 1e-14);
        // Moreau: the difference is in the polar cone and orthogonal to the projection.
        assert!((step[0] * p[0] + step[1] * p[1] + step[2] * p[2]).abs() <= 1e-14);
        assert!(mu * step[1].hypot(step[2]) <= -step[0] + 1e-14);
    }
}

#[test]
fn exact_solution_satisfies_the_law_for_random_operators() {
    let mut random = Random(2);
    let mut counts = [0; 3];
    for i in 0..20_000 {
        let shift = [1.0, 1e-2, 1e-5][i % 3];
        let W = random.operator(3, shift);
        let (q, mu) = (random.numbers(), [0.01, 0.3, 0.8, 2.0, 10.0, 1e-6, 1e6][i % 7]);
        let r = solve_contact(&W, q, mu);
        let u = apply(&W, r, q);
        let error = scaled_residual(&W, q, mu, r);
        // The measure multiplies the rounding of u_t by μ, which matters only for extreme μ.
        assert!(
            error <= f64::max(1e-12, 1e-15 * mu),
            "case {i}: residual {error:e}, W = {W:?}, q = {q:?}, mu = {mu}, r = {r:?}"
        );
        // Complementarity: r · ũ = 0, r in the cone, ũ in its dual.
        let slip = u[1].hypot(u[2]);
        let work = r[0] * (u[0] + mu * slip) + r[1] * u[1] + r[2] * u[2];
        let scale = norm(r).max(1.0) * (1.0 + mu);
        assert!(work.abs() <= 1e-11 * scale, "case {i}: r · ũ = {work:e}");
        assert!(r[1].hypot(r[2]) <= mu * r[0] + 1e-12 * scale);
        counts[if r[0] == 0.0 { 0 } else { 1 + usize::from(slip > 1e-9) }] += 1;
    }
    assert!(counts.iter().all(|&c| c > 1000), "open, stick, slip: {counts:?}");
}

#[test]
fn isotropic_closed_form_is_the_general_solution() {
    let mut random = Random(3);
    for i in 0..5000 {
        let w = 10f64.powf(6.0 * random.next());
        let (q, mu) = (random.numbers(), [0.0, 0.2, 1.0, f64::INFINITY][i % 4]);
        let W = [[w, 0.0, 0.0], [0.0, w, 0.0], [0.0, 0.0, w]];
        let (a, b) = (solve_isotropic(w, q, mu), solve_contact(&W, q, mu));
        assert!(norm([a[0] - b[0], a[1] - b[1], a[2] - b[2]]) <= 1e-14 * norm(q) / w, "{a:?} against {b:?}");
        assert!(scaled_residual(&W, q, mu, a) <= 1e-14);
    }
}

#[test]
fn singular_and_empty_operators_give_finite_reactions() {
    let mut random = Random(4);
    for i in 0..5000 {
        let W = random.operator(i % 3, 0.0);
        for mu in [0.0, 0.5, 3.0, f64::INFINITY] {
            let r = solve_contact(&W, random.numbers(), mu);
            assert!(r.iter().all(|x| x.is_finite()), "rank {}, mu {mu}: {r:?}", i % 3);
        }
    }
    // Fixed along t2 while sliding along it: full drag against that motion, and nothing along t1.
    let W = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]];
    let r = solve_contact(&W, [-4.0, 0.0, 1.0], 0.5);
    assert!(norm([r[0] - 2.0, r[1], r[2] + 1.0]) <= 1e-12, "{r:?}");
}

#[test]
fn several_slip_roots_give_the_one_of_strongest_drag() {
    // Strong coupling and friction: the excess has three roots. The largest λ must be found.
    let W = [[1.0, 0.0, 0.9], [0.0, 1.0, 0.0], [0.9, 0.0, 1.0]];
    let mut random = Random(5);
    for _ in 0..2000 {
        let q = [-random.next().abs(), 0.1 * random.next(), 3.0 * random.next()];
        let r = solve_contact(&W, q, 4.0);
        assert!(scaled_residual(&W, q, 4.0, r) <= 1e-12);
        let u = apply(&W, r, q);
        let found = u[1].hypot(u[2]) / r[1].hypot(r[2]);
        if u[1].hypot(u[2]) < 1e-9 {
            continue;
        }
        // Beyond the λ found, the cone condition must hold everywhere.
        for k in 1..200 {
            let lambda = found * 1.0001 * 1.05f64.powi(k);
            let s22 = 1.0 - 0.81;
            let b = [-q[1], -q[2] + 0.9 * q[0]];
            let t = [b[0] / (1.0 + lambda), b[1] / (s22 + lambda)];
            assert!(
                t[0].hypot(t[1]) <= 4.0 * (-q[0] - 0.9 * t[1]) + 1e-9,
                "a larger root than {found} exists"
            );
        }
    }
}
