//! Mortar contact in motion: the ripple of the force on an indenter that slides.
//!
//! Normal and tangential: 9 and 36 % with nodes against faces, 2.2 and 3.0 % with mortar, of a patch that is two to three elements wide;
//! where it is hardly one and a half, any discretisation ripples, by 27 and 68 %, and 15 and 9 %.

use crate::rig::{assert_at_most, contact_force, plan, run};
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

/// Largest departure of normal and tangential force from their means, as fractions of these, while a ball that is pressed 3 mm into
/// the block slides over two of its elements.
fn ripple(discretisation: &str, around: u32, block: [u32; 3]) -> [f64; 2] {
    let mut ball = ball(around, 0.0);
    ball["prescribed"] = json!([
        {"set": "*", "axes": ["z", "y"], "displacement_m": [0, 0, -0.003],
            "ramp": {"kind": "table", "times_s": [0, 0.2, 1], "factors": [0, 1, 1]}},
        {"set": "*", "axes": ["x"], "displacement_m": [0.025, 0, 0],
            "ramp": {"kind": "table", "times_s": [0, 0.2, 1], "factors": [0, 0, 1]}}
    ]);
    let mut scene = scene(&ball, block, discretisation, 0.3);
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
fn mortar_lowers_the_ripple_of_a_sliding_indenter() {
    let both = |around, block| ["node_to_surface", "mortar"].map(|method| ripple(method, around, block));
    let [nodes, mortar] = both(6, [24, 24, 8]);
    assert_at_most(mortar[0], 0.03, "mortar: ripple of the normal force");
    assert_at_most(mortar[1], 0.05, "mortar: ripple of the tangential force");
    assert!(mortar[0] < 0.3 * nodes[0] && mortar[1] < 0.1 * nodes[1], "{mortar:?} for {nodes:?}");

    let [nodes, mortar] = both(4, [16, 16, 5]);
    assert_at_most(mortar[0], 0.16, "mortar: ripple of the normal force, patch of 1.5 elements");
    assert_at_most(mortar[1], 0.10, "mortar: ripple of the tangential force, patch of 1.5 elements");
    assert!(mortar[0] < 0.6 * nodes[0] && mortar[1] < 0.2 * nodes[1], "{mortar:?} for {nodes:?}");
}

/// Impulse [N s] on a block that a ball of so many elements around hits at 5 m/s, whichever of the two is the slave.
fn impulse(discretisation: &str, around: u32, block: [u32; 3], slave: &str) -> f64 {
    let mut ball = ball(around, 1e-4);
    ball["velocity_m_per_s"] = json!([0, 0, -5]);
    let mut scene = scene(&ball, block, discretisation, 0.3);
    scene["end_time_s"] = json!(8e-3);
    scene["contact"]["self_contact"] = json!("none");
    let mut plan = plan(&scene);
    let contact = plan.contact.as_mut().unwrap();
    let pair = contact.pairs.get(0);
    if plan.bodies[contact.surface_body[pair.slave]].name != slave {
        assert_eq!(contact.pairs.len(), 1);
        contact.pairs = contact.pairs.exchanged().0;
    }
    let (_, state) = run(&plan, |_| {});
    state.ledger.pairs[0].impulse_n_s[2].abs()
}

#[test]
fn a_coarse_slave_has_the_impulse_of_a_fine_one() {
    for (around, block) in [(4, [24, 24, 8]), (10, [10, 10, 4])] {
        for discretisation in ["two_pass", "mortar"] {
            let [of_ball, of_block] =
                ["ball", "block"].map(|slave| impulse(discretisation, around, block, slave));
            let name = format!(
                "{discretisation}, {around} elements around on {block:?}: bias of the impulse by the slave"
            );
            // By nodes against faces alone it is 1.1 % where the coarser side is a quarter as fine.
            assert_at_most((of_ball / of_block - 1.0).abs(), 1e-2, &name);
        }
    }
}
