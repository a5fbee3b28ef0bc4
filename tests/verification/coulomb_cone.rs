//! Coulomb's cone: its projection, and saved one-contact problems of other codes.

use crate::record::assert_at_most;
use contuse::mechanics::contact::solution::local::{Local, LocalOperator, natural_map, proj_coulomb_cone};
use contuse::mechanics::contact::solution::slip::solve_contact;
use serde_json::Value;

/// W, q, μ of a saved problem with one contact, and the file.
fn read_problem(name: &str) -> (LocalOperator, Local, f64, Value) {
    let path = format!("{}/tests/data/contact_problems/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let number = |v: &Value| v.as_f64().unwrap();
    let w = &file["W"]["v"];
    let W = std::array::from_fn(|i| std::array::from_fn(|j| number(&w[3 * i + j])));
    let q = std::array::from_fn(|i| number(&file["q"][i]));
    let mu = number(&file["mu"][0]);
    (W, q, mu, file)
}

fn norm(a: Local) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Scaled and plain residual of a reaction: ρ = 1/D with D = tr W / 3 in units of the problem; and ρ = 1.
fn residuals(W: &LocalOperator, q: Local, mu: f64, r: Local) -> (f64, f64) {
    let u = std::array::from_fn(|i| W[i][0] * r[0] + W[i][1] * r[1] + W[i][2] * r[2] + q[i]);
    let d = (W[0][0] + W[1][1] + W[2][2]) / 3.0;
    let scaled =
        norm(natural_map(r, u, mu, 1.0 / d)) * d.sqrt() / (norm(r) * d.sqrt()).max(norm(q) / d.sqrt());
    let plain = norm(natural_map(r, u, mu, 1.0)) / norm(q).max(norm(r)).max(norm(u));
    (scaled, plain)
}

#[test]
fn projection_of_the_worked_example() {
    // μ = 0.5, r* = (t = (3, 4), n = 2) → t = (1.08, 1.44), n = 3.6.
    let p = proj_coulomb_cone([2.0, 3.0, 4.0], 0.5);
    for (got, expected) in p.into_iter().zip([3.6, 1.08, 1.44]) {
        assert_at_most(got - expected, 1e-15, "projection of the worked example, error");
    }
    assert_at_most(p[1].hypot(p[2]) - 0.5 * p[0], 1e-15, "distance from the cone");
}

#[test]
fn saved_problem_of_siconos_is_solved_to_rounding() {
    let (W, q, mu, _) = read_problem("01_FC3D_1c");
    let r = solve_contact(&W, q, mu);
    let (scaled, plain) = residuals(&W, q, mu, r);
    assert_at_most(scaled, 1e-14, "scaled residual");
    assert_at_most(plain, 1e-14, "plain residual");
    // It slips: on the cone, with the velocity against the drag.
    assert_at_most(r[1].hypot(r[2]) - mu * r[0], 1e-15, "distance from the cone");
}

#[test]
fn generated_problem_has_the_reaction_of_four_other_solvers() {
    let (W, q, mu, file) = read_problem("g01_hex_1c");
    let r = solve_contact(&W, q, mu);
    let (scaled, plain) = residuals(&W, q, mu, r);
    assert_at_most(scaled, 1e-14, "scaled residual");
    assert_at_most(plain, 1e-14, "plain residual");
    for (i, got) in r.into_iter().enumerate() {
        let reference = file["reference"]["r"][i].as_f64().unwrap();
        assert_at_most(got - reference, 1e-14, &format!("reaction {i} against other solvers, error"));
    }
}
