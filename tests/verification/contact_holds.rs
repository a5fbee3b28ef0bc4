//! Nothing slips through: scenes in which nodes, corners, edges and small bodies used to pass.

use crate::rig::{MeshInMemory, assert_at_most, plan, run};
use contuse::measure::Summary;
use contuse::scene::{Budget, load};
use contuse::study::{RunRequest, run_scene};
use serde_json::{Value, json};

/// The summary of a scene without error bars.
fn summary(mut document: Value) -> Summary {
    document["solver"] = json!({"error_bars": "none"});
    let bytes = serde_json::to_vec(&document).unwrap();
    let loaded = load(&bytes, &MeshInMemory(None), &Budget::COMMAND_LINE)
        .unwrap_or_else(|problems| panic!("{:#?}", problems.0));
    let request = RunRequest {
        scene: &loaded.scene,
        document_json: &bytes,
        recording: None,
        also: None,
        threads: 1,
        interrupt: &|| None,
        progress: &mut |_| {},
    };
    run_scene(request).unwrap().summary
}

/// Asserts that a run came to its end with its energy, and nothing deeper than 2 % of a face.
fn assert_holds(summary: &Summary) {
    let document: Value = serde_json::from_str(&summary.to_json().unwrap()).unwrap();
    assert_eq!(document["ending"], "finished");
    let numerics = &summary.numerics;
    assert!(numerics.balance_error < 0.01, "balance {}", numerics.balance_error);
    let share = numerics.deepest_penetration_share;
    assert!(share < 0.02, "{share} of a face, {} m deep", numerics.deepest_penetration_m);
    assert!(numerics.overlapped_volume_share < 0.01, "{} of the volume", numerics.overlapped_volume_share);
}

fn gel_block(name: &str, role: &str, [min, max]: [[f64; 3]; 2], elements: [u32; 3]) -> Value {
    json!({
        "name": name, "role": role,
        "mesh": {"generator": {"kind": "block", "min_m": min, "max_m": max, "elements": elements}},
        "parts": [{
            "part": "*", "density_kg_per_m3": 1000,
            "material": {"law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": 5e7}
        }]
    })
}

#[test]
fn no_node_of_the_hollow_ball_lies_in_the_thigh() {
    let text = include_str!("../../scenarios/flashball_thigh/scene_44mm.json");
    let mut scene: Value = serde_json::from_str(text).unwrap();
    scene["contact"]["discretisation"] = json!("two_pass");
    assert_holds(&summary(scene));
}

#[test]
fn cubes_that_meet_corner_to_corner_do_not_overlap() {
    let mut upper =
        gel_block("upper", "projectile", [[0.0185, 0.0185, 0.0201], [0.0385, 0.0385, 0.0401]], [3, 3, 3]);
    upper["velocity_m_per_s"] = json!([0, 0, -50]);
    let lower = gel_block("lower", "tissue", [[0.0; 3], [0.02; 3]], [4, 4, 4]);
    assert_holds(&summary(json!({
        "name": "corner to corner", "end_time_s": 1e-3,
        "bodies": [upper, lower],
        "contact": {"pairs": [{"between": ["upper", "lower"], "friction": 0.3}], "discretisation": "two_pass"},
        "record": {"field_interval_s": 2e-5}
    })));
}

#[test]
fn a_rigid_ball_smaller_than_a_face_does_not_pass_a_plate() {
    for (elements, [x, y]) in [(4, [0.0, 0.0]), (4, [0.002, 0.0025]), (11, [0.0, 0.0])] {
        let mut plate =
            gel_block("plate", "tissue", [[-0.01, -0.01, 0.0], [0.01, 0.01, 0.001]], [elements, elements, 1]);
        plate["fixed"] = json!([{"set": "x_min"}, {"set": "x_max"}]);
        let ball = json!({
            "name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -20],
            "rigid": {"shape": {"kind": "ball", "radius_m": 0.005}, "mass_kg": 0.002, "center_m": [x, y, 0.0061]}
        });
        let plan = plan(&json!({
            "name": "ball on plate", "end_time_s": 1e-3,
            "bodies": [ball, plate],
            "contact": {"pairs": [{"between": ["ball", "plate"], "friction": 0.3}]},
            "record": {"fields": [], "field_times_s": []}
        }));
        let radius = 0.005;
        let (mut deepest, mut slowest) = (0.0_f64, f64::NEG_INFINITY);
        let (outcome, _) = run(&plan, |frame| {
            let centre = frame.pose(0).unwrap().centre;
            for face in &plan.bodies[1].skin.faces {
                let corner = |k: usize| frame.position(face[k]);
                for (a, b) in
                    (0..=8).flat_map(|i| (0..=8).map(move |j| (f64::from(i) / 8.0, f64::from(j) / 8.0)))
                {
                    let place = corner(0).lerp(&corner(1), a).lerp(&corner(3).lerp(&corner(2), a), b);
                    deepest = deepest.max(radius - (place - centre).norm());
                }
            }
            slowest = slowest.max(frame.v_after[plan.rigid_bodies()[0].centre as usize].z);
        });
        assert_at_most(outcome.balance_error, 0.01, "error of the energy balance");
        // Stretched faces are as large as the ball, which may lie between their nodes by a fifth of its thickness.
        assert_at_most(deepest, 0.42 * radius, "how deep a face is inside the ball [m]");
        assert!(slowest > -18.0, "the plate hardly slows the ball: {slowest} m/s");
    }
}
