//! Rigid boxes: at rest in a stack, on an incline, on the flat, and spinning free.

use crate::rig::{assert_at_most, assert_close, assert_within, both_integrators, plan, run};
use contuse::mechanics::tensor::Vec3;
use serde_json::{Value, json};

const G: f64 = 9.81;

fn cube(name: &str, half: [f64; 3], center: [f64; 3]) -> Value {
    json!({
        "name": name,
        "rigid": {"shape": {"kind": "box", "half_extents_m": half}, "center_m": center, "density_kg_per_m3": 1000}
    })
}

fn scene(bodies: &[Value], gravity: [f64; 3], mu: f64, (end, integrator): (f64, &Value)) -> Value {
    json!({
        "name": "rigid boxes",
        "end_time_s": end,
        "bodies": bodies,
        "planes": [{"name": "ground", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": mu},
        "gravity_m_per_s2": gravity,
        "integrator": integrator,
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn ten_boxes_on_each_other_stay() {
    both_integrators(1e-3).iter().for_each(boxes_stay);
}

fn boxes_stay(integrator: &Value) {
    let boxes = (0..10).map(|i| cube(&format!("box {i}"), [0.05; 3], [0.0, 0.0, 0.05 + 0.1 * f64::from(i)]));
    let plan = plan(&scene(&boxes.collect::<Vec<_>>(), [0.0, 0.0, -G], 0.3, (0.5, integrator)));
    let (mut most, mut turned) = (0.0_f64, 0.0_f64);
    let (outcome, _) = run(&plan, |frame| {
        for (body, start) in frame.plan.rigid_bodies().iter().zip(&plan.rigid.as_ref().unwrap().orientations)
        {
            let node = body.centre;
            most = most.max((frame.position(node) - plan.X[node as usize]).norm());
            turned = turned.max(frame.orientations.iter().map(|o| o.angle_to(start)).fold(0.0, f64::max));
        }
    });
    println!("moved {most:e} m, turned {turned:e}");
    assert_at_most(most, 1e-9, "how far a block of the stack moves [m]");
    assert_at_most(turned, 1e-9, "how far it turns [-]");
    assert!(outcome.warnings.is_empty(), "{:?}", outcome.warnings);
}

#[test]
fn a_plank_laid_across_another_does_not_fall_through() {
    // No corner of either lies on the other: only their edges cross.
    let planks = vec![
        cube("below", [0.2, 0.02, 0.01], [0.0, 0.0, 0.01]),
        cube("above", [0.02, 0.2, 0.01], [0.0, 0.0, 0.03]),
    ];
    for integrator in both_integrators(1e-3) {
        let plan = plan(&scene(&planks, [0.0, 0.0, -G], 0.3, (0.2, &integrator)));
        let (_, state) = run(&plan, |_| ());
        assert_at_most(state.u[2].norm(), 1e-9, "how far a plank across another moves [m]");
    }
}

/// Place and velocity along x of a block on an incline, step by step.
fn slide(degrees: f64, mu: f64, speed: f64, (end, integrator): (f64, &Value)) -> Vec<(f64, f64, f64)> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut block = cube("block", [0.1, 0.1, 0.025], [0.0, 0.0, 0.025]);
    block["velocity_m_per_s"] = json!([speed, 0, 0]);
    let plan = plan(&scene(&[block], [G * sin, 0.0, -G * cos], mu, (end, integrator)));
    let mut rows = Vec::new();
    let (outcome, _) = run(&plan, |frame| {
        let velocity = 0.5 * (frame.v[0].x + frame.v_after[0].x) + speed;
        rows.push((frame.time, frame.position(0).x, velocity));
        assert!((frame.position(0).z - 0.025).abs() < 1e-9);
    });
    assert!(outcome.balance_error < 1e-6, "{}", outcome.balance_error);
    rows
}

#[test]
fn at_15_degrees_a_block_sticks_and_at_30_it_slides() {
    for integrator in both_integrators(1e-3) {
        let rows = slide(15.0, 0.3, 0.0, (1.0, &integrator));
        assert!(rows.iter().all(|(_, x, _)| x.abs() < 1e-11), "{:?}", rows.last());
        let rows = slide(30.0, 0.3, 0.0, (1.0, &integrator));
        let (_, x, v) = rows.last().unwrap();
        assert_close(*x, 1.178_143_618, 1e-8, "way after 1 s");
        assert_close(*v, 2.356_287_237, 1e-8, "velocity after 1 s");
    }
}

#[test]
fn on_the_flat_a_block_stops() {
    for integrator in both_integrators(1e-3) {
        let rows = slide(0.0, 0.2, 3.0, (1.6, &integrator));
        let stopped = rows.iter().find(|(_, _, v)| *v < 1e-9).unwrap();
        assert_within(stopped.0, 1.529_051_988, 2e-3, "time of the stop [s]");
        assert_close(rows.last().unwrap().1, 2.293_577_982, 1e-6, "way");
    }
}

#[test]
fn a_spinning_box_keeps_energy_and_angular_momentum_also_about_its_middle_axis() {
    let [explicit, implicit] = both_integrators(1e-4);
    let spins = [[0.0, 40.0, 0.0], [0.1, 40.0, 0.2], [10.0, -20.0, 30.0]];
    for (spin, integrator) in spins.into_iter().flat_map(|spin| [(spin, &explicit), (spin, &implicit)]) {
        let mut block = cube("block", [0.03, 0.05, 0.08], [0.0, 0.0, 1.0]);
        block["spin_rad_per_s"] = json!(spin);
        block["rigid"]["rotation"] = json!({"axis": [1, 2, 3], "angle_deg": 25});
        block["velocity_m_per_s"] = json!([1, 0, 0.5]);
        let plan = plan(&scene(&[block], [0.0; 3], 0.0, (1.0, integrator)));
        let (mut first, mut drift) = (None, 0.0_f64);
        let (outcome, _) = run(&plan, |frame| {
            let momentum = Vec3::from(frame.energy.angular_momentum_kg_m2_per_s);
            let start = *first.get_or_insert(momentum);
            drift = drift.max((momentum - start).norm());
        });
        let about_centre = plan.rigid_bodies()[0].inertia.norm() * Vec3::from(spin).norm();
        assert_at_most(outcome.balance_error, 1e-11, "error of the energy balance of a free rotation");
        assert_at_most(drift / about_centre, 2e-5, "relative change of the angular momentum");
    }
}
