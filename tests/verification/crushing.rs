//! Crushed elements: compression to a fifth of the height and back, shear to a stretch of four, and a ball dead centre on gel.
//!
//! Where the faces at the sides are free the state is homogeneous, and energy and force are those of the law at a point, whatever the
//! formulation; the work is recovered on unloading.

use crate::rig::{assert_at_most, assert_close, plan, plan_with, run};
use contuse::mechanics::material::{Path, eval_path};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::block::Block;
use contuse::plan::Plan;
use contuse::step::Frame;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// Edge of the specimens [m].
const EDGE: f64 = 0.01;
/// Duration of the load and of its way back, each [s]: slow against the period of some 5 ms.
const LOADING: f64 = 0.05;

const FORMULATIONS: [&str; 3] = ["full", "mean_dilatation", "reduced"];

/// Name and law, K some hundred times μ; what fibres there are lie along x.
fn laws() -> [(&'static str, Value); 4] {
    [
        ("neo-Hookean", json!({"law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": 6e6})),
        (
            "Mooney–Rivlin",
            json!({"law": "mooney_rivlin", "c10_pa": 2.5e4, "c01_pa": 5e3, "bulk_modulus_pa": 6e6}),
        ),
        ("coupled neo-Hookean", json!({"law": "coupled_neo_hookean", "mu_pa": 6e4, "lambda_pa": 1e6})),
        (
            "HGO",
            json!({
                "law": "holzapfel_gasser_ogden", "c_pa": 3e4, "k1_pa": 1e4, "k2": 0.1, "kappa": 0.1,
                "fibres": {"angles_deg": [0.0]}, "bulk_modulus_pa": 6e6
            }),
        ),
    ]
}

fn integrators() -> [Value; 3] {
    [
        json!({"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0}),
        json!({"kind": "implicit", "step_s": LOADING / 40.0, "theta": 0.6}),
        json!({"kind": "quasi_static", "step_s": LOADING / 40.0}),
    ]
}

/// A cube of n³ elements.
fn cube(n: u32) -> Mesh {
    Block::uniform(Vec3::zeros(), Vec3::repeat(EDGE), [n; 3], "block").generate().unwrap()
}

/// The cube, its face x_max or y_max moved by `displacement` and back; `held` as in a scene.
fn scene(
    (material, formulation): (&Value, &str),
    held: &Value,
    prescribed: &Value,
    integrator: &Value,
) -> Value {
    let mut prescribed = prescribed.clone();
    // Half a wave of a cosine each way: a jump of the velocity would leave an undamped cube swinging.
    let times: Vec<f64> = (0..=80).map(|i| f64::from(i) / 40.0 * LOADING).collect();
    let factors: Vec<f64> = times.iter().map(|t| 0.5 - 0.5 * (PI * t / LOADING).cos()).collect();
    prescribed["ramp"] = json!({"kind": "table", "times_s": times, "factors": factors});
    json!({
        "name": "crushing",
        "end_time_s": 2.0 * LOADING,
        "bodies": [{
            "name": "cube",
            "mesh": {"file": {"name": "cube"}},
            "fixed": held,
            "prescribed": [prescribed],
            "parts": [{
                "part": "block", "density_kg_per_m3": 1000.0, "material": material, "formulation": formulation,
                "fibre_frame": {"kind": "constant", "axis": [1, 0, 0], "plane": [0, 1, 0]}
            }]
        }],
        "integrator": integrator,
        "record": {"fields": [], "field_times_s": [LOADING]}
    })
}

/// Strain energy at the end of the loading and at the end [J], and the largest error of the balance, which is within its gate.
fn energies(scene: &Value, mesh: Mesh) -> [f64; 3] {
    let (mut loaded, mut last) = (0.0, 0.0);
    let (outcome, _) = run(&plan_with(scene, Some(mesh)), |frame| {
        last = frame.energy.bodies[0].strain_j;
        if (frame.time - LOADING).abs() < 1e-9 * LOADING {
            loaded = last;
        }
    });
    [loaded, last, outcome.balance_error]
}

#[test]
fn compression_to_a_fifth_and_back_is_that_of_the_law() {
    let held = json!([
        {"set": "x_min", "axes": ["x"]}, {"set": "y_min", "axes": ["y"]}, {"set": "z_min", "axes": ["z"]}
    ]);
    let pressed = json!({"set": "x_max", "axes": ["x"], "displacement_m": [-0.8 * EDGE, 0, 0]});
    let stretches: Vec<f64> = (0..=40).map(|i| 1.0 - 0.02 * f64::from(i)).collect();
    for (name, material) in laws() {
        for formulation in FORMULATIONS {
            // What has no mean dilatation of its own is integrated fully.
            if (name, formulation) == ("coupled neo-Hookean", "mean_dilatation") {
                continue;
            }
            // A block of several may wrinkle below half its height (Biot 1963): one-point elements do so before they are at a fifth.
            let [explicit, implicit, quasi_static] = integrators();
            let mut runs = vec![(explicit.clone(), 1, 1e-3), (implicit, 1, 1e-3), (quasi_static, 1, 1e-5)];
            if formulation != "reduced" {
                runs.push((explicit, 3, 1e-3));
            }
            for (integrator, n, tolerance) in runs {
                let scene = scene((&material, formulation), &held, &pressed, &integrator);
                let law = plan_with(&scene, Some(cube(n))).blocks[0].parameters.material;
                let path = eval_path(&law, &[[1.0, 0.0, 0.0]], Path::Uniaxial, &stretches).unwrap();
                let exact = path.last().unwrap().stress.psi * EDGE.powi(3);
                let [loaded, left, balance_error] = energies(&scene, cube(n));
                let what = format!("{name}, {formulation}, {}, {n}³", integrator["kind"].as_str().unwrap());
                assert_close(loaded, exact, tolerance, &format!("{what}: energy at a fifth"));
                assert_at_most(left / exact, 1e-2, &format!("{what}: energy that stays"));
                assert_at_most(balance_error, 0.01, &format!("{what}: error of the energy balance"));
            }
        }
    }
}

/// γ with the principal stretch 4.
const SHEAR: f64 = 4.0 - 0.25;

#[test]
fn shear_to_a_stretch_of_four_is_that_of_the_law_and_comes_back() {
    let held = json!([{"set": "y_min"}]);
    let sheared = json!({"set": "y_max", "displacement_m": [SHEAR * EDGE, 0, 0]});
    let [quasi_static, explicit] = [&integrators()[2], &integrators()[0]];
    let (name, material) = &laws()[0];
    for formulation in FORMULATIONS {
        // One element: its deformation is given.
        let scene = scene((material, formulation), &held, &sheared, quasi_static);
        let [loaded, left, _] = energies(&scene, cube(1));
        // ψ = C10 (I1 − 3) with I1 = 3 + γ².
        assert_close(
            loaded,
            3e4 * SHEAR * SHEAR * EDGE.powi(3),
            1e-9,
            &format!("{name}, {formulation}: energy"),
        );
        assert_at_most(left / loaded, 1e-9, &format!("{name}, {formulation}: energy that stays"));
    }
    for formulation in FORMULATIONS {
        for integrator in [quasi_static, explicit] {
            let scene = scene((material, formulation), &held, &sheared, integrator);
            let [loaded, left, balance_error] = energies(&scene, cube(4));
            let what = format!("{formulation}, {}, 4³", integrator["kind"].as_str().unwrap());
            // Its ends are free: it takes less than the homogeneous shear of its faces.
            assert!(loaded < 3e4 * SHEAR * SHEAR * EDGE.powi(3), "{what}: {loaded}");
            assert_at_most(left / loaded, 1e-3, &format!("{what}: energy that stays"));
            assert_at_most(balance_error, 0.01, &format!("{what}: error of the energy balance"));
        }
    }
}

/// A rigid ball of 72 mm and 160 g at 12 m/s on a block of gel, its centre `aside` of the block's [m].
fn ball_on_gel(formulation: &str, aside: f64, speed: f64) -> Value {
    json!({
        "name": "ball on gel",
        "end_time_s": 0.006,
        "bodies": [
            {
                "name": "ball", "role": "projectile",
                "rigid": {"shape": {"kind": "ball", "radius_m": 0.036}, "mass_kg": 0.16, "center_m": [aside, 0, 0.085]},
                "velocity_m_per_s": [0, 0, -speed]
            },
            {
                "name": "gel", "role": "tissue",
                "mesh": {"generator": {
                    "kind": "block", "min_m": [-0.08, -0.08, 0], "max_m": [0.08, 0.08, 0.048], "elements": [20, 20, 12]
                }},
                "parts": [{
                    "part": "*", "density_kg_per_m3": 1000.0, "formulation": formulation,
                    "material": {"law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": 5e7}
                }],
                "fixed": [{"set": "z_min"}]
            }
        ],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": []}
    })
}

/// Largest displacement of the gel [m], largest penalty energy over the largest strain energy, and the error of the balance.
fn impact(scene: &Value) -> [f64; 3] {
    let (mut deflection, mut penalty, mut strain) = (0.0_f64, 0.0_f64, 0.0_f64);
    let deepest = |plan: &Plan, frame: &Frame| {
        plan.bodies[1].nodes.clone().map(|node| -frame.u[node as usize].z).fold(0.0, f64::max)
    };
    let plan = plan(scene);
    let (outcome, _) = run(&plan, |frame| {
        deflection = deflection.max(deepest(&plan, frame));
        penalty = penalty.max(frame.energy.bodies[1].hourglass_j);
        strain = strain.max(frame.energy.bodies[1].strain_j);
    });
    [deflection, penalty / strain, outcome.balance_error]
}

#[test]
fn a_ball_dead_centre_on_gel_runs_to_its_end_as_one_that_is_a_little_aside() {
    // In perfect symmetry the edge on the axis passes through zero while its elements are well.
    for formulation in ["mean_dilatation", "reduced"] {
        let [centre, aside] = [0.0, 1e-6].map(|aside| impact(&ball_on_gel(formulation, aside, 12.0)));
        // The dent wrinkles late, at its deepest, in a way that rounding decides: over seven offsets from 0 to 0.1 mm the deflection by mean
        // dilatation scatters by 0.5 to 0.7 %, with `reduced` by as much.
        assert_close(centre[0], aside[0], 1e-2, &format!("{formulation}: deflection at 12 m/s"));
        for [_, penalty, balance_error] in [centre, aside] {
            assert_at_most(balance_error, 0.01, &format!("{formulation}: error of the energy balance"));
            if formulation == "mean_dilatation" {
                // 0.8 % was measured: the faces of the gel are held between their nodes, too.
                assert_at_most(penalty, 1e-2, "fraction of the corner penalty in the strain energy");
            }
        }
    }
}
