//! The lowest breathing mode of a solid elastic sphere (Lamb 1882): `u_r ∝ j₁(k r)`.
//!
//! E = 1 MPa, ν = 0.3, ρ = 1000 kg/m³, a = 10 mm: 1559.242514 Hz, k a = 2.6703 with c = √((λ + 2μ)/ρ).

use crate::rig::{assert_close, assert_order, plan_with, run};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::solid_ball::SolidBall;
use serde_json::{Value, json};
use std::f64::consts::TAU;

const FREQUENCY: f64 = 1_559.242_514;
const RADIUS: f64 = 0.01;
const E: f64 = 1e6;
const NU: f64 = 0.3;

/// The ball of hexahedra.
fn ball(n: u32) -> Mesh {
    let (elements_around, elements_through) = (n, n / 2);
    SolidBall {
        center_m: [0.0; 3],
        radius_m: RADIUS,
        elements_around,
        elements_through,
        grading: 1.0,
        is_quarter: false,
    }
    .generate()
    .unwrap()
}

/// μ and λ [Pa].
const LAME: [f64; 2] = [E / (2.0 * (1.0 + NU)), NU * E / ((1.0 + NU) * (1.0 - 2.0 * NU))];

/// A law that elements integrate fully, and one of the same moduli for elements with a pressure.
fn laws() -> [Value; 2] {
    let [mu, lambda] = LAME;
    let bulk = lambda + 2.0 / 3.0 * mu;
    [
        json!({"law": "coupled_neo_hookean", "mu_pa": mu, "lambda_pa": lambda}),
        json!({"law": "neo_hookean", "c10_pa": 0.5 * mu, "bulk_modulus_pa": bulk}),
    ]
}

/// Frequency of the mode [Hz], found by projecting the displacement on its exact shape.
fn look(mesh: Mesh, law: &Value) -> f64 {
    let [mu, lambda] = LAME;
    let scene = json!({
        "name": "breathing sphere",
        "end_time_s": 1.1 / FREQUENCY,
        "bodies": [{
            "name": "sphere",
            "mesh": {"file": {"name": "ball.msh"}},
            "parts": [{
                "part": "ball", "density_kg_per_m3": 1000.0, "material": law
            }],
            // Strains of 10⁻⁵: what is not linear is of that size.
            "initial_deformation": {
                "kind": "affine", "center_m": [0, 0, 0], "deformation_gradient": [[1.00001, 0, 0], [0, 1.00001, 0], [0, 0, 1.00001]]
            }
        }],
        // Half the usual step: the sudden release excites the highest modes, whose energy a long first step integrates badly.
        "integrator": {"kind": "explicit", "safety_factor": 0.45, "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "record": {"fields": [], "field_times_s": []}
    });
    let plan = plan_with(&scene, Some(mesh));
    let k = TAU * FREQUENCY / ((lambda + 2.0 * mu) / 1000.0).sqrt();
    let shape: Vec<Vec3> =
        plan.X.iter().map(|X| X * (spherical_bessel_1(k * X.norm()) / X.norm().max(1e-30))).collect();
    let mut amplitude = Vec::new();
    run(&plan, |frame| {
        let q = (0..plan.node_count()).map(|a| plan.mass[a] * frame.u[a].dot(&shape[a])).sum::<f64>();
        amplitude.push((frame.time, q));
    });
    // A cosine: zero after a quarter and after three quarters of the period.
    let zeros: Vec<f64> = amplitude
        .windows(2)
        .filter(|w| w[0].1 * w[1].1 < 0.0)
        .map(|w| w[0].0 + (w[1].0 - w[0].0) * w[0].1 / (w[0].1 - w[1].1))
        .collect();
    0.5 / (zeros[1] - zeros[0])
}

fn spherical_bessel_1(x: f64) -> f64 {
    if x < 1e-3 { x / 3.0 } else { x.sin() / (x * x) - x.cos() / x }
}

#[test]
fn frequency_of_the_breathing_mode() {
    let [coarse, fine] = [6, 12].map(|n| look(ball(n), &laws()[0]));
    assert_close(fine, FREQUENCY, 3e-4, "frequency [Hz], 12 elements a quarter");
    assert_order(&[coarse, fine].map(|f| f / FREQUENCY - 1.0), 1.6, "frequency, 6 to 12 elements a quarter");
}

#[test]
fn frequency_with_tetrahedra_of_ten_nodes() {
    let of = |n| look(ball(n).split_to_tetrahedra().to_quadratic_tetrahedra(), &laws()[0]);
    let [coarse, fine] = [4, 8].map(of);
    assert_close(fine, FREQUENCY, 1e-2, "frequency [Hz], tetrahedra of ten nodes, 8 a quarter");
    assert_order(
        &[coarse, fine].map(|f| f / FREQUENCY - 1.0),
        1.6,
        "frequency, tetrahedra of ten nodes, 4 to 8 a quarter",
    );
}

#[test]
fn frequency_with_tetrahedra_of_four_nodes() {
    for (law, what) in laws().iter().zip(["full integration", "averaged pressure"]) {
        let [coarse, fine] = [6, 12].map(|n| look(ball(n).split_to_tetrahedra(), law));
        println!("{what}: {coarse} {fine}");
        assert_close(
            fine,
            FREQUENCY,
            1e-2,
            &format!("frequency [Hz], tetrahedra of four nodes, {what}, 12 a quarter"),
        );
        assert_order(
            &[coarse, fine].map(|f| f / FREQUENCY - 1.0),
            1.6,
            &format!("frequency, tetrahedra of four nodes, {what}, 6 to 12 a quarter"),
        );
    }
}
