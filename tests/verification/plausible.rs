//! What is shown of a run that cannot be a result: nothing touched, nobody knows the error, the law was left.

use crate::rig::MeshInMemory;
use contuse::measure::{Summary, render_table};
use contuse::mesh::Mesh;
use contuse::scene::{Budget, load};
use contuse::study::{RunRequest, run_scene};
use serde_json::{Value, json};

/// The summary of a scene, with its error bars.
fn summary(document: &Value, mesh: Option<Mesh>) -> Summary {
    let bytes = serde_json::to_vec(document).unwrap();
    let loaded = load(&bytes, &MeshInMemory(mesh), &Budget::COMMAND_LINE)
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

/// A soft ball over a block of gel that is held at the bottom.
fn ball_on_gel(velocity: [f64; 3], end_time_s: f64) -> Value {
    let soft = json!({"law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": 1e6});
    json!({
        "name": "ball on gel", "end_time_s": end_time_s,
        "bodies": [
            {
                "name": "ball", "role": "projectile", "velocity_m_per_s": velocity,
                "mesh": {"generator": {"kind": "solid_ball", "center_m": [0, 0, 0.0505], "radius_m": 0.01, "elements_around": 3, "elements_through": 2}},
                "parts": [{"part": "ball", "density_kg_per_m3": 1000, "material": soft}]
            },
            {
                "name": "gel", "role": "tissue", "fixed": [{"set": "z_min"}],
                "mesh": {"generator": {"kind": "block", "min_m": [-0.03, -0.03, 0], "max_m": [0.03, 0.03, 0.04], "elements": [8, 8, 6]}},
                "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": soft}]
            }
        ],
        "contact": {"pairs": [{"between": ["ball", "gel"]}]},
        "measures": {"stress_thresholds_pa": [1000.0], "skin_set": "z_max"}
    })
}

#[test]
fn a_miss_says_so_first_and_shows_no_number() {
    for velocity in [[0.0, 0.0, 5.0], [300.0, 0.0, -2.0]] {
        let summary = summary(&ball_on_gel(velocity, 1e-3), None);
        assert!(summary.plain_words[0].starts_with("Nothing touched"), "{:?}", summary.plain_words);
        assert_eq!(summary.plain_words.len(), 1);
        assert!(summary.values().nothing_touched && summary.injury_measures.is_empty());
        let table = render_table(&summary);
        let first = table.lines().nth(1).unwrap();
        assert!(first.contains("Nothing touched"), "{table}");
        let results = table.split("Numerics").next().unwrap();
        assert!(!results.contains('±') && !results.contains("absorbed energy"), "{results}");
        // No client reads "0 ± 0 resolved" out of the JSON.
        let json = summary.to_json().unwrap();
        assert!(json.contains("\"nothing touched\"") && !json.contains("\"resolved\": true"), "{json}");
    }
}

#[test]
fn a_number_whose_error_nobody_knows_is_no_plain_one() {
    let mut scene = ball_on_gel([0.0, 0.0, -5.0], 1e-3);
    scene["solver"] = json!({"error_bars": "none"});
    let summary = summary(&scene, None);
    let impact = &summary.values().impacts[0];
    assert!(impact.contact_span_s.is_some() && !impact.peak_force_n.error.is_resolved());
    let table = render_table(&summary);
    let results = table.split("Injury").next().unwrap();
    let row = results.lines().find(|line| line.contains("peak force, ")).unwrap();
    assert!(row.contains("(") && row.contains(") N") && row.contains("error not estimated"), "{row}");
    assert!(summary.plain_words.iter().any(|words| words.contains("(error not estimated)")));
}
