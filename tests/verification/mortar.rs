//! Mortar contact in motion: which side is the slave, and the ripple of the force on an indenter that slides.

use crate::rig::{assert_at_most, contact_force, plan, run};
use contuse::mechanics::contact::Master;
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use serde_json::{Value, json};

/// A solid ball of 30 mm over a block of 200 × 200 × 60 mm, held below.
fn scene(ball: &Value, block: [u32; 3], discretisation: &str, friction: f64) -> Value {
    json!({
        "name": "ball on block",
        "end_time_s": 3e-3,
        "bodies": [ball, {
            "name": "block",
            "mesh": {"generator": {
                "kind": "block", "min_m": [-0.1, -0.1, -0.06], "max_m": [0.1, 0.1, 0], "elements": block
            }},
            "fixed": [{"set": "z_min"}],
            "parts": [{"part": "block", "density_kg_per_m3": 1000.0, "material": {
                "law": "neo_hookean", "c10_pa": 2e5, "bulk_modulus_pa": 2e6
            }}]
        }],
        "contact": {"friction": friction, "discretisation": discretisation},
        "record": {"fields": [], "field_times_s": []}
    })
}

fn ball(around: u32, height: f64) -> Value {
    json!({
        "name": "ball",
        "mesh": {"generator": {
            "kind": "solid_ball", "center_m": [0.003, 0.002, 0.03 + height], "radius_m": 0.03,
            "elements_around": around, "elements_through": around
        }},
        "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": {
            "law": "neo_hookean", "c10_pa": 5e5, "bulk_modulus_pa": 5e6
        }}]
    })
}

/// Makes the master the slave.
fn turn_sides(plan: &mut Plan) {
    let contact = plan.contact.as_mut().unwrap();
    let pair = &mut contact.pairs[0];
    let Master::Surface(master) = pair.master else { panic!("no mesh") };
    (pair.slave, pair.master) = (master, Master::Surface(pair.slave));
    let (slave, master) = contact.pair_bodies[0];
    contact.pair_bodies[0] = (master.unwrap(), Some(slave));
}

/// Impulse on the ball [N s], after 3 ms of an impact at 8 m/s.
fn impulse(discretisation: &str, turned: bool) -> f64 {
    let mut ball = ball(6, 1e-4);
    ball["velocity_m_per_s"] = json!([0, 0, -8]);
    let mut plan = plan(&scene(&ball, [16, 16, 5], discretisation, 0.0));
    if turned {
        turn_sides(&mut plan);
    }
    let mut impulse = 0.0;
    run(&plan, |frame| impulse = Vec3::from(frame.energy.pairs[0].impulse_n_s).z.abs());
    impulse
}

#[test]
fn the_impulse_hardly_depends_on_which_side_is_the_slave() {
    let [fine, coarse] = [false, true].map(|turned| impulse("mortar", turned));
    assert_at_most(
        coarse / fine - 1.0,
        0.03,
        "mortar: impulse with the coarse slave, share of that with the fine one",
    );
    let [fine, coarse] = [false, true].map(|turned| impulse("node_to_surface", turned));
    println!("nodes: {}", coarse / fine - 1.0);
}

/// Largest departure of normal and tangential force from their means, as shares of these, while a ball that is pressed 3 mm into
/// the block slides over two of its elements.
fn ripple(discretisation: &str) -> [f64; 2] {
    let mut ball = ball(4, 0.0);
    ball["prescribed"] = json!([
        {"set": "*", "axes": ["z", "y"], "displacement_m": [0, 0, -0.003],
            "ramp": {"kind": "table", "times_s": [0, 0.2, 1], "factors": [0, 1, 1]}},
        {"set": "*", "axes": ["x"], "displacement_m": [0.025, 0, 0],
            "ramp": {"kind": "table", "times_s": [0, 0.2, 1], "factors": [0, 0, 1]}}
    ]);
    let mut scene = scene(&ball, [16, 16, 5], discretisation, 0.3);
    scene["end_time_s"] = json!(1.0);
    scene["integrator"] = json!({"kind": "quasi_static", "step_s": 0.02});
    let mut forces = Vec::new();
    run(&plan(&scene), |frame| {
        // All of it slides by then.
        if frame.time > 0.5 {
            let f = contact_force(frame);
            forces.push([f.z.abs(), f.x.abs()]);
        }
    });
    std::array::from_fn(|i| {
        let mean = forces.iter().map(|f| f[i]).sum::<f64>() / forces.len() as f64;
        forces.iter().map(|f| (f[i] / mean - 1.0).abs()).fold(0.0, f64::max)
    })
}

#[test]
fn the_force_on_a_sliding_indenter_ripples_little() {
    println!("nodes: {:?}", ripple("node_to_surface"));
    let [normal, tangential] = ripple("mortar");
    println!("mortar: {normal} {tangential}");
    assert_at_most(normal, 0.03, "mortar: ripple of the normal force");
    assert_at_most(tangential, 0.05, "mortar: ripple of the tangential force");
}
