//! A spinning rigid bar hits a ball: contact is detected however far the bar turns in a step.

use crate::rig::{assert_close, both_integrators, plan, run};
use serde_json::{Value, json};

const SPIN: f64 = 10.0;

fn scene(shape: &Value, integrator: &Value) -> Value {
    json!({
        "name": "bar and ball",
        "end_time_s": 0.12,
        "bodies": [
            {"name": "bar", "rigid": {"shape": shape, "mass_kg": 1.0, "center_m": [0, 0, 0]}, "spin_rad_per_s": [0, 0, SPIN]},
            {"name": "ball", "rigid": {"shape": {"kind": "ball", "radius_m": 0.02}, "mass_kg": 0.1, "center_m": [0.3, 0.3, 0]}}
        ],
        "contact": {"friction": 0.0},
        "integrator": integrator,
        "record": {"fields": [], "field_times_s": []}
    })
}

/// The impulse of the first two steps in which they touch [N s]: the first closes the gap, the second takes what is left of the
/// velocity.
fn first_impulse(shape: &Value, integrator: &Value) -> f64 {
    let plan = plan(&scene(shape, integrator));
    let mut pressed = Vec::new();
    run(&plan, |frame| pressed.push(frame.reactions.iter().map(|r| r.impulse[0]).sum::<f64>()));
    pressed.into_iter().filter(|p| *p > 0.0).take(2).sum()
}

#[test]
fn a_spinning_bar_meets_a_ball_in_long_steps() {
    // Without rebound the ball leaves with the velocity of the bar at the moment_arm r, where its centre is R from the axis of the bar:
    // p (1/m + 1/M + r²/I) = ω r.
    let bars = [
        (json!({"kind": "capsule", "radius_m": 0.01, "half_length_m": 0.5, "axis": [1, 0, 0]}), {
            let (L, R) = (1.0, 0.01);
            let cylinder = L / (L + 4.0 / 3.0 * R);
            cylinder * (L * L / 12.0 + R * R / 4.0)
                + (1.0 - cylinder) * (0.4 * R * R + L * L / 4.0 + 3.0 * L * R / 8.0)
        }),
        (json!({"kind": "box", "half_extents_m": [0.5, 0.01, 0.01]}), (1.0 + 0.02 * 0.02) / 12.0),
    ];
    for (shape, inertia) in bars {
        let moment_arm: f64 = 0.18 - 0.03 * 0.03;
        let exact = SPIN * moment_arm.sqrt() / (1.0 / 0.1 + 1.0 + moment_arm / inertia);
        for step in [5e-4, 2e-3, 5e-3] {
            for integrator in both_integrators(step) {
                let p = first_impulse(&shape, &integrator);
                let what = format!(
                    "impulse of a spinning {} on a ball, turning by {} a step",
                    shape["kind"],
                    SPIN * step
                );
                assert_close(p, exact, 0.05, &what);
            }
        }
    }
}
