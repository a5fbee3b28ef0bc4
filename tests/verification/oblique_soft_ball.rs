//! Oblique impact of a soft solid ball without spin on a plane with friction.

use crate::rig::{assert_close, mean_velocity, order, plan, run};
use contuse::mechanics::tensor::Vec3;
use serde_json::{Value, json};

const RADIUS: f64 = 0.015;

pub fn scene(n: u32, mu: f64, v_t: f64, v_n: f64, young: f64) -> Value {
    let nu = 0.3;
    json!({
        "name": "oblique soft ball",
        "end_time_s": std::env::var("END").map_or(1.2e-3, |s| s.parse::<f64>().unwrap()),
        "bodies": [{
            "name": "ball",
            "mesh": {"generator": {
                "kind": "solid_ball", "center_m": [0, 0, RADIUS * 1.001], "radius_m": RADIUS, "elements_around": n, "elements_through": n / 2
            }},
            "velocity_m_per_s": [v_t, 0, -v_n],
            "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": {
                "law": "neo_hookean", "c10_pa": young / (4.0 * (1.0 + nu)), "bulk_modulus_pa": young / (3.0 * (1.0 - 2.0 * nu))
            }}]
        }],
        "planes": [{"name": "plane", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": mu},
        "integrator": {"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "record": {"fields": [], "field_times_s": []}
    })
}

fn look(n: u32, mu: f64, v_t: f64, v_n: f64, young: f64) {
    let t = std::time::Instant::now();
    let plan = plan(&scene(n, mu, v_t, v_n, young));
    let mass = plan.bodies[0].mass;
    let center = |frame: &contuse::step::Frame| {
        (0..plan.node_count()).map(|a| frame.position(a as u32) * plan.mass[a]).sum::<Vec3>() / mass
    };
    let inertia: f64 = (0..plan.node_count())
        .map(|a| {
            let r = plan.X[a] - Vec3::new(0.0, 0.0, RADIUS * 1.001);
            plan.mass[a] * (r.x * r.x + r.z * r.z)
        })
        .sum();
    let (mut last, mut first, mut end, mut nodes) = (None, f64::NAN, f64::NAN, 0);
    let mut moment = 0.0;
    let mut sums = [0.0; 3];
    let mut low = [0.0_f64; 3];
    let (outcome, _) = crate::rig::run_on(&plan, contuse::step::State::new(&plan), 1, |frame| {
        for (c, r) in frame.contacts.iter().zip(frame.reactions) {
            let vm = frame.state.v[c.slave as usize] + c.drift;
            let vp = frame.v_after[c.slave as usize] + c.drift;
            let [n, t1, t2] = c.frame;
            let pt = t1 * r.impulse[1] + t2 * r.impulse[2];
            sums[0] -= 0.5 * r.impulse[0] * n.dot(&(vm + vp));
            if pt.norm() >= mu * r.impulse[0] * (1.0 - 1e-6) {
                sums[1] += 0.5 * pt.dot(&(vp - vm));
            } else {
                sums[2] -= 0.5 * pt.dot(&(vp + vm));
            }
            for i in 0..3 {
                low[i] = low[i].min(sums[i]);
            }
        }
        let v = mean_velocity(frame, 0);
        let spin = Vec3::from(frame.energy.angular_momentum_kg_m2_per_s)
            - center(frame).cross(&Vec3::from(frame.energy.momentum_kg_m_per_s));
        let touching = frame.reactions.iter().filter(|r| r.impulse[0] > 0.0).count();
        nodes = nodes.max(touching);
        if touching > 0 {
            if first.is_nan() {
                first = frame.time();
            }
            end = frame.time();
        }
        for (c, r) in frame.contacts.iter().zip(frame.reactions) {
            let p = c.frame[0] * r.impulse[0] + c.frame[1] * r.impulse[1] + c.frame[2] * r.impulse[2];
            moment += frame.position(c.slave).cross(&p).y;
        }
        last = Some((
            v,
            spin.y / inertia,
            frame.energy.clone(),
            Vec3::from(frame.energy.angular_momentum_kg_m2_per_s).y,
        ));
    });
    let (v, omega, energy, angular) = last.unwrap();
    println!(
        "normal {:.3e} slip {:.3e} stick {:.3e} lows {low:?} of {}",
        sums[0], sums[1], sums[2], energy.scale_j
    );
    let e = v.z / v_n;
    let dv = v_t - v.x;
    println!(
        "n {n} mu {mu} v {v_t} {v_n}: steps {} {:?} contact {first:.3e}..{end:.3e} nodes {nodes} e {e:.4} dv_t/(mu(1+e)v_n) {:.6} omega {omega:.3} (m v R + I w)/(m v_t R) {:.5} {:.5} num {:.4} balance {:.1e} vy {:.1e} ang {:.2e}",
        outcome.steps,
        t.elapsed(),
        dv / (mu * (1.0 + e) * v_n),
        (mass * v.x * RADIUS + inertia * omega) / (mass * v_t * RADIUS),
        inertia * omega / (mass * dv * RADIUS),
        energy.numerical_contact_j() / energy.initial_total_j,
        outcome.balance_error,
        v.y,
        (angular - mass * v_t * RADIUS * 1.001 - moment) / (mass * v_t * RADIUS)
    );
}

#[test]
fn print_oblique() {
    for n in [4, 8, 12] {
        look(n, 0.1, 5.0, 1.0, 1e8);
        look(n, 0.1, 5.0, 0.5, 1e8);
        look(n, 0.6, 1.0, 1.0, 1e8);
    }
    let _ = (order, assert_close);
}
