//! A rigid solid ball on a plane with friction: sliding and rolling.
//!
//! I = 2/5 m R². Friction takes at most μ times the normal impulse m v_n, and never more than makes it roll: from then on
//! v_t = ω R = 5/7 of the tangential velocity that it came with.

use crate::rig::{assert_at_most, assert_close, assert_within, both_integrators, plan, run, run_on};
use contuse::mechanics::tensor::Vec3;
use contuse::step::{Frame, Interrupt, RunOptions};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicU32, Ordering};

const RADIUS: f64 = 0.015;

/// A ball at a height over the plane z = 0.
fn scene(height: f64, velocity: [f64; 3], mu: f64, (end, integrator): (f64, &Value)) -> Value {
    json!({
        "name": "rigid ball on a plane",
        "end_time_s": end,
        "bodies": [{
            "name": "ball",
            "role": "projectile",
            "rigid": {
                "shape": {"kind": "ball", "radius_m": RADIUS},
                "center_m": [0, 0, RADIUS + height],
                "density_kg_per_m3": 1000
            },
            "velocity_m_per_s": velocity
        }],
        "planes": [{"name": "ground", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": mu},
        "integrator": integrator,
        "record": {"fields": [], "field_times_s": []}
    })
}

/// Velocity of the centre, and angular velocity in space.
fn motion(frame: &Frame) -> (Vec3, Vec3) {
    let body = &frame.plan.rigid_bodies()[0];
    let flight = frame.plan.bodies[0].flight_velocity;
    let spin = frame.orientations[0] * frame.v_after[body.spin as usize];
    (frame.v_after[body.centre as usize] + flight, spin)
}

/// An oblique impact with v_t = 5, v_n = 10 m/s, no rebound: velocities after it, and friction and impact loss per mass.
fn impact(mu: f64, integrator: &Value) -> (Vec3, Vec3, f64, f64) {
    let plan = plan(&scene(1e-3, [5.0, 0.0, -10.0], mu, (5e-4, integrator)));
    let (mass, mut last) = (plan.bodies[0].mass, None);
    run(&plan, |frame| {
        let pair = &frame.energy.pairs[0];
        assert!(frame.energy.balance_error < 1e-12, "{}", frame.energy.balance_error);
        last = Some((motion(frame), pair.friction_j / mass, pair.impact_j / mass));
    });
    let ((v, spin), friction, lost) = last.unwrap();
    assert_at_most(v.z, 1e-9, "velocity off the plane [m/s]");
    assert_at_most(v.y, 1e-12, "velocity across [m/s]");
    (v, spin, friction, lost)
}

#[test]
fn a_little_friction_lets_it_slide() {
    for integrator in both_integrators(3e-6) {
        let (v, spin, friction, lost) = impact(0.1, &integrator);
        assert_close(v.x, 4.0, 1e-10, "tangential velocity");
        assert_close(spin.y, 166.666_666_667, 1e-10, "spin");
        // μ m v_n over the mean of the slip before and after, 5 and 1.5 m/s.
        assert_close(friction, 3.25, 1e-3, "friction");
        assert_close(friction + lost, 50.0 + 3.25, 1e-10, "all that is lost");
    }
}

#[test]
fn more_friction_makes_it_roll() {
    let [explicit, implicit] = both_integrators(3e-6);
    for (mu, integrator) in
        [1.0 / 7.0 + 1e-6, 0.3, 2.0].into_iter().flat_map(|mu| [(mu, &explicit), (mu, &implicit)])
    {
        let (v, spin, friction, lost) = impact(mu, integrator);
        assert_close(v.x, 3.571_428_571_43, 1e-10, "tangential velocity");
        assert_close(spin.y, 238.095_238_095, 1e-10, "spin");
        // Of the normal part all is lost, of the tangential one 3.571428571 J/kg.
        assert_close(friction + lost - 50.0, 3.571_428_571_43, 1e-9, "tangential loss");
    }
}

#[test]
fn a_ball_that_slides_ends_in_rolling_at_five_sevenths() {
    both_integrators(1e-4).iter().for_each(slides_and_rolls);
}

fn slides_and_rolls(integrator: &Value) {
    let mut scene = scene(0.0, [3.0, 0.0, 0.0], 0.2, (0.6, integrator));
    scene["gravity_m_per_s2"] = json!([0, 0, -9.81]);
    let plan = plan(&scene);
    let (mut rolls_from, mut heights) = (None, 0.0_f64);
    let (outcome, state) = run(&plan, |frame| {
        let (v, spin) = motion(frame);
        if (v.x - spin.y * RADIUS).abs() < 1e-9 && rolls_from.is_none() {
            rolls_from = Some(frame.time);
        }
        heights = heights.max((frame.position(0).z - RADIUS).abs());
    });
    let v = state.v[0].x + 3.0;
    assert_close(v, 15.0 / 7.0, 1e-9, "rolling at 5/7 of its speed");
    // Slip falls by 7/2 μ g a second.
    assert_close(rolls_from.unwrap(), 3.0 / (3.5 * 0.2 * 9.81), 1e-3, "time of the slip");
    assert_at_most(heights, 1e-12, "how far it leaves the plane [m]");
    assert_at_most(outcome.balance_error, 1e-9, "error of the energy balance");
}

#[test]
fn free_flight_is_exact() {
    for integrator in both_integrators(1e-3) {
        let mut scene = scene(1.0, [5.0, -2.0, 1.0], 0.3, (0.05, &integrator));
        scene["bodies"][0]["spin_rad_per_s"] = json!([30, 10, -20]);
        let plan = plan(&scene);
        run(&plan, |frame| {
            assert_eq!(frame.u[0], Vec3::zeros());
            assert_eq!(frame.position(0), plan.X[0] + Vec3::new(5.0, -2.0, 1.0) * frame.time);
            assert_eq!(frame.energy.balance_error, 0.0);
        });
    }
}

#[test]
fn a_fall_is_that_of_the_textbook() {
    for integrator in both_integrators(7e-4) {
        let mut scene = scene(1.0, [1.0, 0.0, 0.0], 0.0, (0.2, &integrator));
        scene["gravity_m_per_s2"] = json!([0, 0, -9.81]);
        let plan = plan(&scene);
        let (outcome, _) = run(&plan, |frame| {
            let fallen = 0.5 * 9.81 * frame.time.powi(2);
            assert_within(frame.position(0).z, 1.0 + RADIUS - fallen, 1e-14, "height in free fall [m]");
        });
        assert_at_most(outcome.balance_error, 1e-13, "error of the energy balance in free fall");
    }
}

#[test]
fn a_restart_has_the_same_bits() {
    both_integrators(1e-4).iter().for_each(restarts);
}

fn restarts(integrator: &Value) {
    let mut scene = scene(0.0, [3.0, 0.0, 0.0], 0.2, (0.02, integrator));
    scene["gravity_m_per_s2"] = json!([0, 0, -9.81]);
    // The state of a part restarts no run of the whole.
    scene["solver"] = json!({"keep": ["mirror_images"]});
    let plan = plan(&scene);
    let (_, whole) = run(&plan, |_| ());
    let requested = AtomicU32::new(0);
    let interrupt = || (requested.fetch_add(1, Ordering::Relaxed) >= 77).then_some(Interrupt::Cancel);
    let (_, half) = contuse::step::run(&plan, &RunOptions { threads: 1, interrupt: &interrupt }, &mut []);
    // Explicit steps query it once each, implicit ones in every iteration too.
    assert!(half.step > 10 && half.step <= 77, "{}", half.step);
    let (_, end) = run_on(&plan, half, 2, |_| ());
    assert_eq!(end, whole);
}
