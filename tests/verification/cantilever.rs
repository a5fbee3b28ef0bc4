//! A slender cantilever with few elements through its thickness, against Euler–Bernoulli theory: a test of shear and volumetric locking.
//!
//! L = 0.2, b = h = 0.01, μ = 1e5, ρ = 1000 (SI): `f₁ = 0.559596 √(E I/(ρ A L⁴))`, E = 9Kμ/(3K + μ). Shear and rotary inertia
//! lower it by half a per cent; the clamp, which also prevents the contraction of its section, raises it by about as much.

use crate::rig::{assert_at_most, assert_close, assert_order, plan_with, run_on};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::block::Block;
use contuse::step::{Ending, State};
use serde_json::{Value, json};

/// A mesh of hexahedra as one of another kind of cell.
type Split = fn(Mesh) -> Mesh;

const L: f64 = 0.2;
const H: f64 = 0.01;
const MU: f64 = 1e5;
const RHO: f64 = 1000.0;
/// Root of cosh k cos k = −1.
const K1: f64 = 1.875_104_068_7;

fn exact(bulk_modulus: f64) -> f64 {
    let E = 9.0 * bulk_modulus * MU / (3.0 * bulk_modulus + MU);
    K1 * K1 / std::f64::consts::TAU * (E * H * H / 12.0 / (RHO * L.powi(4))).sqrt()
}

/// n elements in the height and the width.
fn beam(n: u32, length: u32) -> Mesh {
    Block::uniform(Vec3::zeros(), Vec3::new(L, H, H), [length, n, n], "block").generate().unwrap()
}

fn scene(formulation: &Value, bulk_modulus: f64) -> Value {
    let mut scene = json!({
        "name": "cantilever",
        "end_time_s": 0.8 / exact(bulk_modulus),
        "bodies": [{
            "name": "beam",
            "mesh": {"file": {"name": "beam.msh"}},
            "fixed": [{"set": "x_min"}],
            "parts": [{
                "part": "block", "density_kg_per_m3": RHO,
                "material": {"law": "neo_hookean", "c10_pa": 0.5 * MU, "bulk_modulus_pa": bulk_modulus}
            }]
        }],
        "integrator": {"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "record": {"fields": [], "field_times_s": []}
    });
    if !formulation.is_null() {
        scene["bodies"][0]["parts"][0]["formulation"] = formulation.clone();
    }
    scene
}

/// First frequency [Hz], from the motion's part in the first mode, which passes zero after half a period; largest fraction of the
/// stabilisation in the strain energy, and the balance's error.
fn look(mesh: Mesh, formulation: &Value, bulk_modulus: f64) -> (f64, f64, f64) {
    let plan = plan_with(&scene(formulation, bulk_modulus), Some(mesh));
    let shape: Vec<f64> = plan.X.iter().map(|X| first_mode(X.x / L)).collect();
    // Sent off in the first mode, so slowly that all stays linear.
    let mut state = State::new(&plan);
    for (v, shape) in state.v.iter_mut().zip(&shape) {
        v.y = 1e-7 * shape;
    }
    let (mut before, mut half_period, mut fraction) = ((0.0, 0.0), None, 0.0_f64);
    let (outcome, _) = run_on(&plan, state, 1, |frame| {
        let u = |a: usize| frame.u[a].dot(&Vec3::y());
        let q: f64 = (0..plan.node_count()).map(|a| plan.mass[a] * u(a) * shape[a]).sum();
        let (t0, q0) = before;
        if q0 > 0.0 && q <= 0.0 && half_period.is_none() {
            half_period = Some(t0 + (frame.time - t0) * q0 / (q0 - q));
        }
        before = (frame.time, q);
        let body = &frame.energy.bodies[0];
        fraction = fraction.max(if body.strain_j > 0.0 { body.hourglass_j / body.strain_j } else { 0.0 });
    });
    assert_eq!(outcome.ending, Ending::Finished, "{outcome:#?}");
    (0.5 / half_period.unwrap(), fraction, outcome.balance_error)
}

/// Shape of the first mode of a cantilever at s = x/L.
fn first_mode(s: f64) -> f64 {
    let ratio = (K1.sinh() - K1.sin()) / (K1.cosh() + K1.cos());
    let k = K1 * s;
    k.cosh() - k.cos() - ratio * (k.sinh() - k.sin())
}

#[test]
fn one_reduced_element_through_the_thickness_bends_as_a_beam_up_to_incompressibility() {
    for bulk_modulus in [2e5, 1e7, 1e9] {
        let (frequency, fraction, balance) = look(beam(1, 10), &json!("reduced"), bulk_modulus);
        assert_close(
            frequency,
            exact(bulk_modulus),
            0.02,
            &format!("first frequency [Hz], K = {bulk_modulus:e} Pa"),
        );
        // With one element through the thickness the stabilisation *is* the bending, and the ledger says so.
        assert!(fraction > 0.5, "K = {bulk_modulus}: {fraction}");
        assert_at_most(balance, 0.01, "error of the energy balance");
    }
    // Why it is worth having: mean dilatation does not lock in volume, but in shear.
    let (frequency, fraction, _) = look(beam(1, 10), &json!("mean_dilatation"), 1e7);
    assert!(frequency / exact(1e7) > 1.3 && fraction == 0.0, "{}", frequency / exact(1e7));
}

#[test]
fn tetrahedra_of_ten_nodes_bend_as_a_beam() {
    let bulk_modulus = 2e5;
    let error = |n: u32, formulation: &Value| {
        let mesh = beam(n, 10 * n).split_to_tetrahedra().to_quadratic_tetrahedra();
        let (frequency, _, balance) = look(mesh, formulation, bulk_modulus);
        assert_at_most(balance, 0.01, "error of the energy balance, tetrahedra of ten nodes");
        frequency / exact(bulk_modulus) - 1.0
    };
    let full = error(1, &json!("full"));
    assert_at_most(full, 0.02, "relative error, fully integrated tetrahedra of ten nodes, one in the height");
    // With one pressure each, an element does not resist a change of volume that is linear in it: one in the height is too soft.
    let errors = [1, 2].map(|n| error(n, &Value::Null));
    println!("full {full}, mean dilatation {errors:?}");
    assert_order(&errors, 1.6, "first frequency, tetrahedra of ten nodes, 1 to 2 in the height");
    assert_at_most(errors[1], 0.03, "relative error, tetrahedra of ten nodes, two in the height");
}

#[test]
fn linear_elements_converge_to_the_beam() {
    let bulk_modulus = 2e5;
    let cases: [(&str, Split); 2] = [
        ("wedges", |mesh| mesh.split_to_wedges()),
        ("tetrahedra of four nodes", |mesh| mesh.split_to_tetrahedra()),
    ];
    for (what, cells) in cases {
        let errors = [2, 4].map(|n| {
            let (frequency, _, balance) = look(cells(beam(n, 10 * n)), &Value::Null, bulk_modulus);
            assert_at_most(balance, 0.01, &format!("error of the energy balance, {what}"));
            frequency / exact(bulk_modulus) - 1.0
        });
        println!("{what}: {errors:?}");
        assert_order(&errors, 1.6, &format!("first frequency, {what}, 2 to 4 elements in the height"));
        assert_at_most(errors[1], 0.25, &format!("relative error, {what}, four elements in the height"));
    }
}
