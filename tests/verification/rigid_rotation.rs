//! A finite rigid rotation causes no stress, no energy and no force.

use crate::rig::{assert_at_most, plan, run};
use contuse::mechanics::tensor::{Mat3, Vec3};
use nalgebra::{Rotation3, Unit};
use serde_json::{Value, json};

/// A small ball turned by 137° about a skew axis, at rest.
fn scene(material: &Value, formulation: &str) -> Value {
    let R = Rotation3::from_axis_angle(&Unit::new_normalize(Vec3::new(1.0, 2.0, 3.0)), 137_f64.to_radians());
    let rows: Vec<Vec<f64>> = (0..3).map(|i| (0..3).map(|j| R[(i, j)]).collect()).collect();
    json!({
        "name": "turned",
        "end_time_s": 1e-4,
        "bodies": [{
            "name": "ball",
            "mesh": {"generator": {"kind": "solid_ball", "radius_m": 0.015, "elements_around": 2, "elements_through": 2}},
            "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": material, "formulation": formulation}],
            "initial_deformation": {"kind": "affine", "center_m": [0.1, 0, 0], "deformation_gradient": rows}
        }]
    })
}

#[test]
fn a_turned_body_stays_at_rest_without_stress_or_energy() {
    let bulk = 1e6;
    let laws = [
        json!({"law": "mooney_rivlin", "c10_pa": 4e4, "c01_pa": 1e4, "bulk_modulus_pa": bulk}),
        json!({"law": "neo_hookean", "c10_pa": 4e4, "bulk_modulus_pa": bulk}),
        json!({"law": "coupled_neo_hookean", "mu_pa": 1e5, "lambda_pa": bulk}),
        json!({
            "law": "holzapfel_gasser_ogden", "c_pa": 3e4, "k1_pa": 2e4, "k2": 0.8, "kappa": 0.1,
            "fibres": {"angles_deg": [29.0, -29.0]}, "bulk_modulus_pa": bulk
        }),
    ];
    let coupled = |law: &Value| law["law"] == "coupled_neo_hookean";
    let cases = laws
        .iter()
        .flat_map(|law| [(law, "reduced"), (law, if coupled(law) { "full" } else { "mean_dilatation" })]);
    for (law, formulation) in cases {
        let plan = plan(&scene(law, formulation));
        let law = format!("{} {formulation}", law["law"].as_str().unwrap());
        // The strain of a rotation is a difference of numbers of order 1, so stress is a few roundings of the bulk modulus.
        let check_points = |u: &[Vec3], tolerance: f64, what: &str| {
            let mut worst = Vec3::zeros();
            for block in &plan.blocks {
                block.for_each_point(&plan.X, u, &mut |_, _, point| {
                    let strain = (point.F.transpose() * point.F - Mat3::identity()).norm();
                    let energy = point.psi.abs() / bulk;
                    worst = worst.zip_map(&Vec3::new(point.cauchy.norm() / bulk, energy, strain), f64::max);
                });
            }
            assert_at_most(worst.x, tolerance, &format!("{what}: stress over K [-], {law}"));
            assert_at_most(worst.y, tolerance * tolerance, &format!("{what}: energy over K [-], {law}"));
            assert_at_most(worst.z, tolerance, &format!("{what}: FᵀF − I, norm, {law}"));
        };
        check_points(&plan.initial_u, 1e-13, "at the start");

        let mut fastest = 0.0_f64;
        let (outcome, state) = run(&plan, |frame| {
            fastest = frame.v_after.iter().map(Vec3::norm).fold(fastest, f64::max);
        });
        assert!(outcome.steps > 5);
        // Waves of a strain of one rounding travel at 40 m/s.
        assert_at_most(fastest, 1e-11, &format!("fastest node [m/s], {law}"));
        check_points(&state.u, 1e-12, "at the end");
    }
}
