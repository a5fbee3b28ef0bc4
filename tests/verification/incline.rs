//! A soft block on a plane with friction, against the rigid block of the textbook.
//!
//! μ = 0.3, g = 9.81 m/s². At 15° it sticks. At 30° a = g (sin 30° − μ cos 30°) = 2.356287237 m/s², x(1 s) = 1.178143618 m,
//! friction work per mass 3.002749677 J/kg. On the flat with v₀ = 3 m/s, μ = 0.2 it stops at t = 1.529051988 s,
//! x = 2.293577982 m.

use crate::rig::{assert_close, mean_velocity, plan, run};
use contuse::mechanics::tensor::Vec3;
use serde_json::{Value, json};

const G: f64 = 9.81;

/// A block on the plane z = 0, gravity turned by the angle of the incline towards +x.
pub fn scene(degrees: f64, mu: f64, speed: f64, end: f64) -> Value {
    let (sin, cos) = degrees.to_radians().sin_cos();
    json!({
        "name": "block on incline",
        "end_time_s": end,
        "bodies": [{
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.2, 0.2, 0.05], "elements": [6, 6, 2]}},
            "velocity_m_per_s": [speed, 0, 0],
            "parts": [{"part": "block", "density_kg_per_m3": 1000.0, "material": {
                "law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 5e5
            }}]
        }],
        "planes": [{"name": "incline", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": mu},
        "gravity_m_per_s2": [G * sin, 0, -G * cos],
        "settle": {"duration_s": 0.5, "damping_per_s": 100.0},
        "record": {"fields": [], "field_times_s": []}
    })
}

struct Row {
    t: f64,
    x: Vec3,
    v: Vec3,
    friction: f64,
    bottom: f64,
}

fn look(degrees: f64, mu: f64, speed: f64, end: f64) -> Vec<Row> {
    let plan = plan(&scene(degrees, mu, speed, end));
    let bottom: Vec<usize> = (0..plan.node_count()).filter(|a| plan.X[*a].z == 0.0).collect();
    let mut rows = Vec::new();
    let mut start: Option<(Vec3, Vec<Vec3>)> = None;
    let (outcome, _) = run(&plan, |frame| {
        let x = (0..plan.node_count()).map(|a| frame.position(a as u32) * plan.mass[a]).sum::<Vec3>()
            / plan.bodies[0].mass;
        let places: Vec<Vec3> = bottom.iter().map(|a| frame.position(*a as u32)).collect();
        let (x0, places0) = start.get_or_insert((x, places.clone()));
        let creep = places.iter().zip(places0.iter()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        rows.push(Row {
            t: frame.time(),
            x: x - *x0,
            v: mean_velocity(frame, 0),
            friction: frame.energy.pairs[0].friction_j / plan.bodies[0].mass,
            bottom: creep,
        });
    });
    println!("{outcome:?}");
    rows
}

#[test]
fn print() {
    for (d, mu, v, end) in [(15.0, 0.3, 0.0, 2.0), (30.0, 0.3, 0.0, 1.0), (0.0, 0.2, 3.0, 2.0)] {
        let t = std::time::Instant::now();
        let rows = look(d, mu, v, end);
        println!("{d} {mu} {v}: {} rows {:?}", rows.len(), t.elapsed());
        for r in rows.iter().step_by(rows.len() / 20) {
            println!(
                "{:.4} x {:.8} {:.2e} v {:.6} fr {:.6} creep {:.3e}",
                r.t, r.x.x, r.x.z, r.v.x, r.friction, r.bottom
            );
        }
        let r = rows.last().unwrap();
        println!(
            "{:.4} x {:.8} {:.2e} v {:.6} fr {:.6} creep {:.3e}",
            r.t, r.x.x, r.x.z, r.v.x, r.friction, r.bottom
        );
        if v > 0.0 {
            println!("stop {:?}", rows.iter().find(|r| r.v.x <= 0.0).map(|r| (r.t, r.x.x)));
        }
    }
    let _ = assert_close;
}
