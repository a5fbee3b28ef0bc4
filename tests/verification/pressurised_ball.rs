//! A hollow rubber ball under pressure from within and from without, slowly: thick-walled spheres of incompressible Mooney–Rivlin rubber
//! have a closed form. With ψ = C10 (I1 − 3) + C01 (I2 − 3) and λ(R) the hoop stretch, p = ∫ ψ'(λ) / (λ³ − 1) dλ from the outer to the
//! inner stretch.
//!
//! C10 = 0.55 MPa, C01 = 0.138 MPa, radii 10 and 15 mm: 581 890.454 Pa for an inner stretch of 1.25, −1 305 244.88 Pa for 0.8; and the
//! strain energy at 1.25 is 1.45568966 J. The pressure follows the faces; the bulk modulus of 1 GPa stands for incompressible, and
//! nothing holds the ball.

use crate::rig::{assert_at_most, assert_close, assert_order, plan, run};
use contuse::mechanics::tensor::Vec3;
use serde_json::json;

const INNER: f64 = 0.01;

/// The mean stretch of the inner surface and the strain energy [J] at a pressure [Pa], with so many elements around a quarter.
fn inflated(elements: u32, pressure: f64) -> (f64, f64) {
    let scene = json!({
        "name": "ball under pressure",
        "end_time_s": 1.0,
        "bodies": [{
            "name": "ball",
            "mesh": {"generator": {
                "kind": "hollow_ball", "outer_radius_m": 0.015, "inner_radius_m": INNER,
                "elements_around": elements, "elements_through": elements / 2
            }},
            "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": {
                "law": "mooney_rivlin", "c10_pa": 5.5e5, "c01_pa": 1.38e5, "bulk_modulus_pa": 1e9, "volumetric": "quadratic_ln"
            }}],
            "face_loads": [{
                "kind": "pressure", "set": "inner", "pressure_pa": pressure, "ramp": {"kind": "linear", "to_s": 1}
            }]
        }],
        "integrator": {"kind": "quasi_static", "step_s": 0.1},
        "record": {"fields": [], "field_times_s": []}
    });
    let plan = plan(&scene);
    let mut strain = 0.0;
    let (outcome, state) = run(&plan, |frame| strain = frame.energy.bodies[0].strain_j);
    assert_at_most(outcome.balance_error, 1e-6, "error of the energy balance");
    let inside: Vec<usize> =
        (0..plan.node_count()).filter(|&a| plan.X[a].norm() < INNER * (1.0 + 1e-9)).collect();
    let stretch = |a: &usize| (plan.X[*a] + state.u[*a]).norm() / INNER;
    let drift: Vec3 = state.u.iter().sum::<Vec3>() / state.u.len() as f64;
    assert_at_most(drift.norm(), 1e-7, "way of the ball as a whole [m]");
    (inside.iter().map(stretch).sum::<f64>() / inside.len() as f64, strain)
}

#[test]
fn a_hollow_ball_opens_to_the_stretch_of_its_pressure() {
    let found = [4, 8].map(|elements| inflated(elements, 581_890.454));
    assert_close(found[1].0, 1.25, 0.005, "inner stretch");
    assert_close(found[1].1, 1.455_689_66, 0.03, "strain energy [J]");
    assert_order(&found.map(|(stretch, _)| stretch - 1.25), 1.7, "inner stretch");
    assert_order(&found.map(|(_, energy)| energy / 1.455_689_66 - 1.0), 1.7, "strain energy");
}

#[test]
fn a_hollow_ball_closes_under_pressure_from_without() {
    let found = [4, 8].map(|elements| inflated(elements, -1_305_244.88).0);
    assert_close(found[1], 0.8, 0.005, "inner stretch");
    assert_order(&found.map(|stretch| stretch - 0.8), 1.7, "inner stretch");
}
