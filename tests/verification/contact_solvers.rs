//! Every solver of the contact library takes a run to the same end as the default, which sweeps over nodal velocities and forms no W.
//!
//! A ball strikes a block aslant, with friction, in explicit and in implicit steps; its last velocity by Gauss–Seidel on the velocities
//! (explicit) or by the hybrid (implicit) is what the others are compared with, which get W, q and μ of every step.

use crate::rig::{assert_at_most, mean_velocity, plan, run, small_ball_on_block};
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use contuse::scene::document::ContactSolver;
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
        let told = format!("contact problems solved by {}, W formed in every step", solver.name());
        assert!(plan.report.kept.contains(&told), "{:?}", plan.report.kept);
        assert_eq!(plan.report.pairs[0].unknowns_per_contact, 3);
        let (velocity, balance) = last_velocity(&plan);
        let what = format!(
            "{}, μ = {friction}: velocity of the ball less that by the default, of its size",
            solver.name()
        );
        assert_at_most((velocity - expected).norm() / expected.norm(), 1e-7, &what);
        assert_at_most(balance, 1e-2, "error of the energy balance");
    }
}

#[test]
fn explicit_steps_end_alike_by_every_solver() {
    let explicit = json!({"kind": "explicit"});
    compare(&explicit, 0.3, &ContactSolver::ALL);
    compare(&explicit, 0.0, &[ContactSolver::Nsgs, ContactSolver::Newton]);
}

#[test]
fn implicit_steps_end_alike_by_every_solver() {
    let implicit = json!({"kind": "implicit", "step_s": 5e-6});
    compare(&implicit, 0.3, &[ContactSolver::Nsgs, ContactSolver::Newton, ContactSolver::InteriorPoint]);
    compare(&implicit, 0.0, &[ContactSolver::Newton]);
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
