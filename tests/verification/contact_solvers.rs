//! Every solver of the contact library gives the result of the default, Gauss–Seidel on the nodal velocities, which forms no W.
//!
//! A ball strikes a block aslant, with friction, in explicit and in implicit steps; its last velocity by Gauss–Seidel on the velocities
//! (explicit) or by the hybrid (implicit) is what the others are compared with, which get W, q and μ of every step.

use crate::rig::{assert_at_most, mean_velocity, plan, run, run_on, small_ball_on_block};
use clap::ValueEnum as _;
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use contuse::scene::document::ContactSolver;
use contuse::step::{Ending, FailureCause, State};
use serde_json::{Value, json};

/// Velocity of the ball at the end [m/s], and the largest error of the energy balance [-].
fn last_velocity(plan: &Plan) -> (Vec3, f64) {
    let mut last = Vec3::zeros();
    let (outcome, _) = run(plan, |frame| {
        // A rigid body is the node of its centre, and that of its spin.
        let is_rigid = plan.bodies[0].rigid.is_some();
        let rigid = || frame.v_after[0] + plan.bodies[0].flight_velocity;
        last = if is_rigid { rigid() } else { mean_velocity(frame, 0) };
    });
    assert!(outcome.most_contacts > 3, "only {} contacts: the scene shows nothing", outcome.most_contacts);
    (last, outcome.balance_error)
}

fn scene(integrator: &Value, friction: f64) -> Value {
    let mut scene = small_ball_on_block([4, 1], [10, 10, 5], [5.0, 0.0, -20.0], 1.5e-4);
    scene["contact"] = json!({"friction": friction});
    scene["integrator"] = integrator.clone();
    scene
}

fn compare(integrator: &Value, friction: f64, solvers: &[ContactSolver]) {
    let mut scene = scene(integrator, friction);
    let (expected, _) = last_velocity(&plan(&scene));
    for solver in solvers {
        scene["solver"] = json!({"contact": solver});
        let plan = plan(&scene);
        let is_implicit = integrator["kind"] == "implicit";
        let by_products = is_implicit && *solver == ContactSolver::AcceleratedGradient;
        let how = if by_products { "matrix-free" } else { "W formed in every step" };
        let line = format!("contact problems solved by {}, {how}", solver.method().name());
        assert!(plan.report.kept.contains(&line), "{:?}", plan.report.kept);
        assert_eq!(plan.report.pairs[0].unknowns_per_contact, 3);
        let (velocity, balance) = last_velocity(&plan);
        let what = format!(
            "{}, μ = {friction}: velocity of the ball less that by the default, of its size",
            solver.method().name()
        );
        assert_at_most((velocity - expected).norm() / expected.norm(), 1e-7, &what);
        assert_at_most(balance, 1e-2, "error of the energy balance");
    }
}

#[test]
fn explicit_steps_end_alike_by_every_solver() {
    let explicit = json!({"kind": "explicit"});
    compare(&explicit, 0.3, ContactSolver::value_variants());
    compare(&explicit, 0.0, &[ContactSolver::Nsgs, ContactSolver::Newton]);
}

#[test]
fn implicit_steps_end_alike_by_every_solver() {
    use ContactSolver::{AcceleratedGradient, InteriorPoint, Newton, Nsgs};
    let implicit = json!({"kind": "implicit", "step_s": 5e-6});
    compare(&implicit, 0.3, &[Nsgs, Newton, InteriorPoint, AcceleratedGradient]);
    compare(&implicit, 0.0, &[Newton, AcceleratedGradient]);
}

/// Two plates of material without lateral contraction, `n` × `n` elements each, one thrown at the other.
fn plates(n: u32) -> Value {
    let width = 1e-3 * f64::from(n);
    let plate = |name: &str, z: f64, velocity: f64| {
        json!({
            "name": name,
            "mesh": {"generator": {
                "kind": "block", "min_m": [0, 0, z], "max_m": [width, width, z + 1e-3], "elements": [n, n, 1]
            }},
            "velocity_m_per_s": [0, 0, velocity],
            "parts": [{
                "part": "block", "density_kg_per_m3": 1000.0,
                "material": {"law": "coupled_neo_hookean", "mu_pa": 1e5, "lambda_pa": 0.0}
            }]
        })
    };
    json!({
        "name": "plates", "end_time_s": 4e-5,
        "bodies": [plate("lower", -1e-3, 0.0), plate("upper", 0.0, -1.0)],
        "contact": {"friction": 0.3},
        "integrator": {"kind": "implicit", "step_s": 2e-5},
        "record": {"fields": [], "field_times_s": []}
    })
}

/// Contacts between more nodes than W is formed for: every column of the plates is the one-column plate.
#[test]
fn many_contacts_end_as_one_does() {
    let (one, _) = last_velocities(&plan(&plates(1)));
    let (many, contacts) = last_velocities(&plan(&plates(28)));
    assert_eq!(contacts, 29 * 29);
    assert!((one - Vec3::z() * -1.0).norm() > 0.1, "nothing happened: {one:?}");
    // Nodes at the rim lie on the edges of facets, by rounding on the one or the other side: that changes 2e-6, whatever the solver.
    assert_at_most(
        (many - one).norm(),
        1e-5,
        "velocity of a plate of 784 elements less that of one element [m/s]",
    );
}

/// Velocity of the upper body at the end [m/s], and the most contacts.
fn last_velocities(plan: &Plan) -> (Vec3, usize) {
    let mut last = Vec3::zeros();
    let (outcome, _) = run(plan, |frame| last = mean_velocity(frame, 1));
    (last, outcome.most_contacts)
}

/// The four corners of a rigid block on a plane: W of rank 6 in 12 rows.
#[test]
fn rigid_sides_are_in_w_too() {
    let mut scene = json!({
        "name": "slide", "end_time_s": 0.1,
        "bodies": [{
            "name": "block", "velocity_m_per_s": [1.0, 0.3, 0.0],
            "rigid": {"shape": {"kind": "box", "half_extents_m": [0.05, 0.05, 0.025]}, "center_m": [0, 0, 0.025], "mass_kg": 1.0}
        }],
        "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "gravity_m_per_s2": [0, 0, -9.81],
        "contact": {"friction": 0.3},
        "integrator": {"kind": "explicit", "max_step_s": 1e-3},
        "record": {"fields": [], "field_times_s": []}
    });
    let (expected, _) = last_velocity(&plan(&scene));
    scene["solver"] = json!({"contact": "hybrid"});
    let (velocity, _) = last_velocity(&plan(&scene));
    assert_at_most(
        (velocity - expected).norm(),
        1e-8,
        "velocity of a sliding rigid block less that by the default [m/s]",
    );
}

/// During dynamic relaxation everything sticks, which some solvers cannot handle: the default takes their place, then they go on.
#[test]
fn every_solver_relaxes() {
    use ContactSolver::{AcceleratedGradient, DeSaxce, Extragradient, InteriorPoint, Uzawa};
    let mut scene = crate::incline::scene(15.0, 0.3, 0.0, 2e-3, 1e6);
    let velocity = |scene: &Value| {
        let mut last = Vec3::zeros();
        run(&plan(scene), |frame| last = mean_velocity(frame, 0));
        last
    };
    let expected = velocity(&scene);
    for solver in [InteriorPoint, DeSaxce, Uzawa, Extragradient, AcceleratedGradient] {
        scene["solver"] = json!({"contact": solver});
        let what = format!(
            "{}: velocity after dynamic relaxation less that by the default [m/s]",
            solver.method().name()
        );
        assert_at_most((velocity(&scene) - expected).norm(), 1e-7, &what);
    }
}

/// A rigid ball between a floor and a block all of whose nodes have a prescribed motion further down than the gap.
#[test]
fn what_has_no_room_ends_the_run_with_a_diagnosis() {
    let mut scene = json!({
        "name": "press", "end_time_s": 2e-3,
        "bodies": [
            {
                "name": "ball", "role": "projectile",
                "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [0, 0, 0.01], "mass_kg": 0.005}
            },
            {
                "name": "press", "role": "tissue",
                "mesh": {"generator": {
                    "kind": "block", "min_m": [-0.02, -0.02, 0.0201], "max_m": [0.02, 0.02, 0.03], "elements": [4, 4, 2]
                }},
                "parts": [{"part": "*", "density_kg_per_m3": 1000.0, "material": {
                    "law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 2e6
                }}],
                "prescribed": [{"set": "*", "displacement_m": [0, 0, -0.002], "ramp": {"kind": "linear", "to_s": 2e-3}}]
            }
        ],
        "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": []}
    });
    let implicit = json!({"kind": "implicit", "step_s": 1e-4});
    for (integrator, solver) in [
        (json!({"kind": "explicit"}), None),
        (json!({"kind": "explicit"}), Some(ContactSolver::Newton)),
        (implicit.clone(), None),
        (implicit, Some(ContactSolver::Newton)),
    ] {
        scene["integrator"] = integrator;
        scene["solver"] = solver.map_or_else(|| json!({}), |solver| json!({"contact": solver}));
        let plan = plan(&scene);
        let (outcome, _) = run_on(&plan, State::new(&plan), 1, |_| {});
        let Ending::Failed { failure } = &outcome.ending else { panic!("{solver:?}: {outcome:#?}") };
        assert_eq!(failure.cause, FailureCause::ContactJammed, "{solver:?}: {failure}");
    }

    // On a bed of elements that are held instead of the floor, where long sweeps are extrapolated.
    let mut bed = scene["bodies"][1].clone();
    bed["name"] = json!("bed");
    bed["mesh"]["generator"]["min_m"] = json!([-0.02, -0.02, -0.01]);
    bed["mesh"]["generator"]["max_m"] = json!([0.02, 0.02, 0.0]);
    bed["prescribed"][0]["displacement_m"] = json!([0, 0, 0]);
    scene["bodies"].as_array_mut().unwrap().push(bed);
    scene["planes"] = json!([]);
    scene["integrator"] = json!({"kind": "explicit"});
    scene["solver"] = json!({});
    for friction in [0.0, 0.3] {
        scene["contact"]["friction"] = json!(friction);
        let plan = plan(&scene);
        let (outcome, _) = run_on(&plan, State::new(&plan), 1, |_| {});
        let Ending::Failed { failure } = &outcome.ending else { panic!("μ = {friction}: {outcome:#?}") };
        assert_eq!(failure.cause, FailureCause::ContactJammed, "μ = {friction}: {failure}");
    }
}

/// A heavy steel cube lands on a light sheet of foam on a floor: impulses are thousands of times those of the sheet's own velocities.
#[test]
fn a_heavy_body_on_a_light_one_is_not_jammed() {
    let scene = |friction: f64| {
        let body = |name: &str, half_extents_m: [f64; 3], height: f64, density: f64, velocity: [f64; 3]| {
            json!({
                "name": name, "role": "other", "velocity_m_per_s": velocity,
                "rigid": {"shape": {"kind": "box", "half_extents_m": half_extents_m}, "center_m": [0, 0, height], "density_kg_per_m3": density}
            })
        };
        json!({
            "name": "foam", "end_time_s": 1e-2, "gravity_m_per_s2": [0, 0, -9.81],
            "bodies": [
                body("foam", [0.05, 0.05, 0.0015], 0.0015, 100.0, [0.0; 3]),
                body("steel", [0.05; 3], 0.053_000_1, 7850.0, [0.3, 0.0, -1.0])
            ],
            "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
            "contact": {"friction": friction},
            "integrator": {"kind": "explicit", "max_step_s": 1e-4},
            "record": {"fields": [], "field_times_s": []}
        })
    };
    for friction in [0.0, 0.3, 0.5] {
        let plan = plan(&scene(friction));
        let mut centre = Vec3::zeros();
        let (outcome, _) =
            run_on(&plan, State::new(&plan), 1, |frame| centre = frame.pose(1).unwrap().centre);
        assert_eq!(outcome.ending, Ending::Finished, "μ = {friction}");
        // The cube rests on the sheet, and slides only without friction: friction of 0.3 stops 0.3 m/s with the 1 m/s of the impact.
        assert_at_most(
            (centre.z - 0.053).abs(),
            1e-6,
            &format!("height of the cube less 53 mm, μ = {friction} [m]"),
        );
        let slid = if friction == 0.0 { 3e-3 } else { 0.0 };
        assert_at_most(
            (centre.x - slid).abs(),
            5e-5,
            &format!("place of the cube less {slid}, μ = {friction} [m]"),
        );
    }
}
