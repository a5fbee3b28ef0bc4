//! Nothing slips through where contact has two passes: scenes in which nodes, corners and edges used to pass.

use crate::rig::MeshInMemory;
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
