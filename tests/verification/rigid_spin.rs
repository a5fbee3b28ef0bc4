//! A rigid box that spins freely about no principal axis keeps its angular momentum, as a vector, and its energy, in steps of a radian as
//! well as in short ones. Explicit steps of more are shortened.

use crate::rig::{assert_at_most, both_integrators, plan, run};
use contuse::mechanics::tensor::Vec3;
use serde_json::{Value, json};

const SPIN: [f64; 3] = [300.0, 500.0, -700.0];

fn scene(integrator: &Value) -> Value {
    json!({
        "name": "spinning box",
        "end_time_s": 0.1,
        "bodies": [{
            "name": "box",
            "rigid": {"shape": {"kind": "box", "half_extents_m": [0.03, 0.02, 0.005]}, "center_m": [0, 0, 0], "mass_kg": 0.2},
            "spin_rad_per_s": SPIN
        }],
        "integrator": integrator,
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn the_momentum_vector_and_the_energy_are_kept_at_a_radian_a_step() {
    let speed = Vec3::from(SPIN).norm();
    for angle in [0.05, 0.9, 3.0] {
        for integrator in both_integrators(angle / speed) {
            let (mut start, mut errors) = (None, [0.0_f64; 2]);
            let (outcome, _) = run(&plan(&scene(&integrator)), |frame| {
                let now =
                    (Vec3::from(frame.energy.angular_momentum_kg_m2_per_s), frame.energy.bodies[0].kinetic_j);
                let (momentum, energy) = *start.get_or_insert(now);
                errors[0] = errors[0].max((now.0 - momentum).norm() / momentum.norm());
                errors[1] = errors[1].max((now.1 / energy - 1.0).abs());
            });
            let what = format!("{angle} rad a step, {}", integrator["kind"].as_str().unwrap());
            let is_explicit = integrator["kind"] == "explicit";
            let least = 0.1 * speed / if is_explicit { angle.min(1.0) } else { angle };
            assert!(outcome.steps as f64 >= least, "{what}: {} steps", outcome.steps);
            assert_at_most(
                errors[0],
                1e-11,
                &format!("{what}: change of the angular momentum, as a vector [-]"),
            );
            assert_at_most(errors[1], 1e-11, &format!("{what}: change of the energy [-]"));
        }
    }
}
