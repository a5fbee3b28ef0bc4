//! Equilibrium without mass: closed forms, the ledger, support of a body, and preload before a run.

use crate::rig::{assert_at_most, assert_close, contact_force, plan, run, run_on};
use contuse::mechanics::tensor::Vec3;
use contuse::step::{Ending, Energy, FailureCause, State};
use serde_json::{Value, json};

const MU: f64 = 1e5;

/// A unit cube of 2×2×2 elements of a coupled neo-Hookean law, held against rigid motion at three sides of symmetry.
fn cube(integrator: &Value) -> Value {
    json!({
        "name": "cube",
        "end_time_s": 1.0,
        "bodies": [{
            "name": "cube",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [1, 1, 1], "elements": [2, 2, 2]}},
            "fixed": [
                {"set": "x_min", "axes": ["x"]}, {"set": "y_min", "axes": ["y"]}, {"set": "z_min", "axes": ["z"]}
            ],
            "parts": [{"part": "block", "density_kg_per_m3": 1000.0, "material": {
                "law": "coupled_neo_hookean", "mu_pa": MU, "lambda_pa": 2.0 * MU
            }}]
        }],
        "integrator": integrator,
        "record": {"fields": [], "field_times_s": []}
    })
}

fn quasi_static(step: f64) -> Value {
    json!({"kind": "quasi_static", "step_s": step, "newton_tolerance": 1e-10})
}

/// ψ = μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)² with λ = 2 μ: side stretch b of free sides at the stretch a, stress P and ψ.
fn uniaxial(a: f64) -> (f64, f64, f64) {
    // P_b = μ (b − 1/b) + 2 μ ln J / b = 0
    let mut b = 1.0_f64;
    for _ in 0..50 {
        let f = b * b - 1.0 + 2.0 * (a * b * b).ln();
        b -= f / (2.0 * b + 4.0 / b);
    }
    let ln_j = (a * b * b).ln();
    let energy = MU * (0.5 * (a * a + 2.0 * b * b - 3.0) - ln_j + ln_j * ln_j);
    (b, MU * (a - 1.0 / a + 2.0 * ln_j / a), energy)
}

#[test]
fn a_stretched_cube_has_the_stress_and_the_energy_of_its_law() {
    let (a, steps) = (1.5, 10);
    let mut scene = cube(&quasi_static(1.0 / f64::from(steps)));
    scene["bodies"][0]["prescribed"] =
        json!([{"set": "x_max", "axes": ["x"], "displacement_m": [a - 1.0, 0, 0]}]);
    let (outcome, state, energy) = last(&scene);
    let (b, _, strain) = uniaxial(a);
    let plan = plan(&scene);
    let corner = (0..plan.node_count()).find(|n| plan.X[*n] == Vec3::new(1.0, 1.0, 1.0)).unwrap();
    let corner = (state.u[corner] - Vec3::new(a - 1.0, b - 1.0, b - 1.0)).norm();
    assert_at_most(corner, 1e-9, "place of the corner, error [m]");
    assert_close(energy.bodies[0].strain_j, strain, 1e-9, "strain energy");
    // Work by the mean of the forces at both ends of each load step: off by a fraction of 1/steps² of what the law curves.
    assert_close(energy.external_work_j, strain, 2e-3, "work of the prescribed displacement");
    assert_at_most(outcome.balance_error, 1e-8, "error of the energy balance");
    assert_eq!(energy.bodies[0].kinetic_j, 0.0);
}

/// The last energies of a run, which must finish.
fn last(scene: &Value) -> (contuse::step::Outcome, State, Energy) {
    let mut energy = Energy::default();
    let (outcome, state) = run(&plan(scene), |frame| energy = frame.energy.clone());
    (outcome, state, energy)
}

/// Two unit cubes, the upper pressed onto the lower by a tenth.
fn press(step: f64) -> Value {
    let mut scene = cube(&quasi_static(step));
    let mut upper = scene["bodies"][0].clone();
    upper["name"] = json!("upper");
    upper["mesh"]["generator"]["min_m"] = json!([0, 0, 1]);
    upper["mesh"]["generator"]["max_m"] = json!([1, 1, 2]);
    upper["fixed"] = json!([{"set": "x_min", "axes": ["x"]}, {"set": "y_min", "axes": ["y"]}]);
    upper["prescribed"] = json!([{"set": "z_max", "axes": ["z"], "displacement_m": [0, 0, -0.2]}]);
    scene["bodies"].as_array_mut().unwrap().push(upper);
    scene["contact"] = json!({"friction": 0.0});
    scene
}

#[test]
fn contact_works_by_the_reactions_at_both_ends_of_a_load_step() {
    let of_steps = |steps: u32| {
        let (outcome, _, energy) = last(&press(1.0 / f64::from(steps)));
        assert_at_most(outcome.balance_error, 1e-8, "error of the energy balance");
        energy
    };
    let [coarse, fine] = [10, 20].map(of_steps);
    // Each cube is compressed by a tenth, without friction.
    let (_, _, strain) = uniaxial(0.9);
    let missed = |energy: &Energy| {
        for body in &energy.bodies {
            assert_close(body.strain_j, strain, 1e-6, "strain energy");
        }
        // The work of contact is the strain energy of the lower cube, whose support does not move, and the rest is what the steps miss.
        let lower = &energy.bodies[0];
        assert_close(lower.contact_work_j, lower.strain_j + lower.algorithmic_j, 1e-8, "work of contact");
        lower.algorithmic_j.abs() / strain
    };
    // With the reactions at the ends alone it was 1/steps.
    assert_at_most(missed(&coarse), 2e-3, "energy that ten load steps miss");
    let order = (missed(&coarse) / missed(&fine)).log2();
    assert_at_most((order - 2.0).abs(), 0.1, "order of what load steps miss, less 2");
}

#[test]
fn traction_and_pressure_stretch_as_the_law_says() {
    let a = 1.3;
    let (b, stress, strain) = uniaxial(a);
    // The pressure follows the face, which has shrunk to b².
    let loads = [
        json!({"kind": "traction", "set": "x_max", "traction_pa": [stress, 0, 0]}),
        json!({"kind": "pressure", "set": "x_max", "pressure_pa": -stress / (b * b)}),
    ];
    for load in loads {
        let mut scene = cube(&quasi_static(0.1));
        scene["bodies"][0]["face_loads"] = json!([load]);
        let (outcome, state, energy) = last(&scene);
        let stretched = state.u.iter().map(|u| u.x).fold(0.0, f64::max) + 1.0;
        assert_close(stretched, a, 1e-8, "stretch");
        assert_close(energy.bodies[0].strain_j, strain, 1e-8, "strain energy");
        assert_close(energy.external_work_j, strain, 2e-3, "work of the load");
        assert_at_most(outcome.balance_error, 1e-8, "error of the energy balance");
    }
}

#[test]
fn loads_act_in_all_integrators_and_their_work_closes_the_balance() {
    // Slow against the cube's period of some 0.3 s: a stretch, a pressure on the top, and gravity, each with its ramp.
    let integrators = [
        json!({"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0}),
        json!({"kind": "implicit", "step_s": 0.02}),
        json!({"kind": "implicit", "step_s": 0.02, "theta": 0.8}),
        quasi_static(0.05),
    ];
    let mut places = Vec::new();
    for integrator in integrators {
        // Explicit steps measure the energy at half steps: of second order where a ramp bends.
        let limit = match integrator["kind"].as_str() {
            Some("explicit") => 5e-4,
            Some("quasi_static") => 1e-7,
            _ => 1e-6,
        };
        let mut scene = cube(&integrator);
        scene["end_time_s"] = json!(4.0);
        scene["gravity_m_per_s2"] = json!([0, 0, -5]);
        scene["gravity_ramp"] = json!({"kind": "table", "times_s": [0, 2, 4], "factors": [0, 0.2, 1]});
        scene["bodies"][0]["prescribed"] = json!([{
            "set": "x_max", "axes": ["x"], "displacement_m": [0.2, 0, 0],
            "ramp": {"kind": "table", "times_s": [0, 1, 3, 4], "factors": [0, 0.1, 0.9, 1]}
        }]);
        scene["bodies"][0]["face_loads"] = json!([
            {"kind": "pressure", "set": "z_max", "pressure_pa": 2e4, "ramp": {"kind": "linear", "to_s": 4}}
        ]);
        let (outcome, state, energy) = last(&scene);
        assert!(outcome.balance_error < limit, "{scene}: {}", outcome.balance_error);
        let work = energy.bodies[0].strain_j + energy.bodies[0].kinetic_j + energy.algorithmic_j();
        assert_close(energy.external_work_j, work, 1e-3, "work");
        assert!(energy.algorithmic_j().abs() < 5e-3 * work, "{} of {work}", energy.algorithmic_j());
        places.push(state.u.iter().sum::<Vec3>() / state.u.len() as f64);
    }
    for place in &places {
        let apart = (place - places[3]).norm() / places[3].norm();
        assert_at_most(apart, 0.03, "mean displacement less that of equilibrium, of its size");
    }
}

#[test]
fn an_under_constrained_body_is_reported() {
    // A block on an incline without friction.
    let mut scene = crate::incline::scene(15.0, 0.0, 0.0, 1.0, 1e6);
    scene.as_object_mut().unwrap().remove("dynamic_relaxation");
    scene["integrator"] = quasi_static(0.5);
    let plan = plan(&scene);
    let (outcome, _) = run_on(&plan, State::new(&plan), 1, |_| {});
    let Ending::Failed { failure } = &outcome.ending else { panic!("{outcome:#?}") };
    assert_eq!(failure.cause, FailureCause::UnderConstrained, "{failure}");
    assert!(failure.message.contains("`block`"), "{failure}");
}

/// The incline of 15° with friction 0.3, loaded quasi-statically before the clock starts.
fn incline(integrator: Value) -> Value {
    let mut scene = crate::incline::scene(15.0, 0.3, 0.0, 1.0, 1e6);
    scene.as_object_mut().unwrap().remove("dynamic_relaxation");
    scene["preload"] = json!({"steps": 4});
    scene["integrator"] = integrator;
    scene
}

#[test]
fn a_preloaded_block_on_a_gentle_incline_does_not_creep() {
    for integrator in [json!({"kind": "implicit", "step_s": 0.01, "theta": 1.0}), json!({"kind": "explicit"})]
    {
        let scene = incline(integrator);
        let plan = plan(&scene);
        let bottom: Vec<u32> =
            (0..plan.node_count() as u32).filter(|a| plan.X[*a as usize].z == 0.0).collect();
        let (mut first, mut most, mut sticking, mut force) = (None, 0.0_f64, usize::MAX, Vec3::zeros());
        run(&plan, |frame| {
            let places: Vec<_> = bottom.iter().map(|a| frame.position(*a)).collect();
            let start = first.get_or_insert_with(|| places.clone());
            most = places.iter().zip(start.iter()).map(|(x, x0)| (x - x0).norm()).fold(most, f64::max);
            sticking = sticking.min(frame.reactions.iter().filter(|r| r.impulse[0] > 0.0).count());
            force = contact_force(frame);
        });
        let weight = 9.81 * plan.bodies[0].mass;
        let (sin, cos) = 15.0_f64.to_radians().sin_cos();
        let wrong = (force - Vec3::new(-sin, 0.0, cos) * weight).norm() / weight;
        assert_at_most(wrong, 1e-6, "force of the incline on the block, error over its weight");
        assert_eq!(sticking, bottom.len());
        assert_at_most(most, 1e-12, "creep over 1 s [m]");
    }
}

#[test]
fn a_quasi_static_run_that_is_restarted_has_the_same_bits() {
    let scene = |end: f64| {
        let mut scene = incline(quasi_static(0.1));
        scene.as_object_mut().unwrap().remove("preload");
        scene["end_time_s"] = json!(end);
        // Both runs hit the time at which one of them stops.
        scene["record"] = json!({"fields": [], "field_times_s": [0.5]});
        scene["gravity_ramp"] = json!({"kind": "linear", "to_s": 1.0});
        plan(&scene)
    };
    let (half, whole) = (scene(0.5), scene(1.0));
    let (_, middle) = run(&half, |_| {});
    let (_, restarted) = run_on(&whole, middle, 2, |_| {});
    let (_, straight) = run(&whole, |_| {});
    assert!(restarted == straight, "bits");
}
