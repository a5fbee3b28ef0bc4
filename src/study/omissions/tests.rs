use super::*;
use crate::scene::{Budget, FolderSource, load};
use serde_json::json;

/// Two small blocks in frictionless contact, the lower one with fibres of zero stiffness; a third far away.
fn scene() -> Scene {
    let block = |name: &str, low: [f64; 3], material: &serde_json::Value, velocity: [f64; 3]| {
        json!({
            "name": name,
            "mesh": {"generator": {"kind": "block", "min_m": low, "max_m": low.map(|x| x + 0.01), "elements": [2, 2, 2]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": material}],
            "velocity_m_per_s": velocity
        })
    };
    let rubber = json!({"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 2e7});
    let tissue = json!({"law": "holzapfel_gasser_ogden", "c_pa": 5e4, "k1_pa": 0.0, "k2": 1.0,
                        "fibres": {"angles_deg": [15, -15]}, "bulk_modulus_pa": 2e7});
    let document = json!({
        "name": "blocks", "end_time_s": 1e-4,
        "bodies": [
            block("tissue", [0.0, 0.0, -0.0101], &tissue, [0.0; 3]),
            block("striker", [0.002, 0.003, 0.0], &rubber, [3.0, 1.0, -20.0]),
            block("far", [1.0, 0.0, 0.0], &rubber, [0.0; 3])
        ],
        "planes": [{"name": "wall", "point_m": [2, 0, 0], "normal": [-1, 0, 0]}],
        "contact": {"pairs": [
            {"between": ["striker", "tissue"]}, {"between": ["far", "wall"]}, {"between": ["striker", "striker"]}
        ]},
        "record": {"fields": [], "field_times_s": []}
    });
    let bytes = serde_json::to_vec(&document).unwrap();
    load(&bytes, &FolderSource::new("."), &Budget::COMMAND_LINE).unwrap().scene
}

fn studied(scene: &Scene, recording: Option<&Path>) -> (OmissionsStudy, Vec<Vec<Keep>>) {
    let mut reported = Vec::new();
    let study = study_omissions(&mut OmissionsRequest {
        scene,
        document_json: b"{}",
        repeat: 2,
        threads: 1,
        recording,
        interrupt: &|| None,
        progress: &mut |number, count, restored| {
            assert!(number < count);
            reported.push(restored.to_vec());
        },
    });
    (study.unwrap(), reported)
}

#[test]
fn everything_that_is_omitted_can_be_restored_and_changes_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (study, reported) = studied(&scene(), Some(&folder.path().join("study.mcap")));
    let kinds: Vec<Vec<Keep>> = study.rows.iter().map(|row| row.restored.clone()).collect();
    // The scene is not symmetric.
    let others = &Keep::ALL[1..];
    let alone: Vec<Vec<Keep>> = others.iter().map(|keep| vec![*keep]).collect();
    let expected = [&[Vec::new()], &alone[..], &[others.to_vec()]].concat();
    assert_eq!(kinds, expected);
    assert_eq!(reported, [expected.clone(), expected].concat(), "in turns");
    for row in &study.rows {
        assert_eq!(row.difference, Difference::Bitwise, "{row:#?}");
        assert_eq!(row.ending, "finished");
        assert!(row.wall_s > 0.0 && row.holds && row.steps == study.rows[0].steps);
        assert!(row.memory_bytes >= study.rows[0].memory_bytes);
    }
    assert!(study.holds);
    // The fields of the last row take space in the recording.
    let bytes = |row: &OmissionsRow| row.recording_bytes.unwrap();
    let fields = study.rows.iter().find(|row| row.restored == [Keep::UnrequestedFields]).unwrap();
    assert!(bytes(fields) > bytes(&study.rows[0]) && fields.memory_bytes > study.rows[0].memory_bytes);
}

#[test]
fn what_the_scene_keeps_itself_is_not_studied() {
    let mut scene = scene();
    scene.restore(&Keep::ALL[2..]);
    let (study, _) = studied(&scene, None);
    let kinds: Vec<&[Keep]> = study.rows.iter().map(|row| &row.restored[..]).collect();
    assert_eq!(kinds, [&[][..], &[Keep::InactiveElements][..]]);
    assert_eq!(study.rows[0].recording_bytes, None);
}

#[test]
fn a_run_that_does_not_end_holds_nothing() {
    let scene = scene();
    let study = study_omissions(&mut OmissionsRequest {
        scene: &scene,
        document_json: b"{}",
        repeat: 1,
        threads: 1,
        recording: None,
        interrupt: &|| Some(Interrupt::Cancel),
        progress: &mut |_, _, _| {},
    });
    let study = study.unwrap();
    assert!(!study.holds && study.rows.iter().all(|row| row.ending == "cancelled"));
}

#[test]
fn differences_are_relative_to_the_largest_value_and_zeros_have_no_sign() {
    let close = |x: Option<f64>, y: f64| (x.unwrap() - y).abs() < 1e-15;
    assert_eq!(relative_difference(&[1.0, 0.0], &[1.0, -0.0]), None);
    assert!(close(relative_difference(&[4.0, 1.0], &[4.0, 1.5]), 0.125));
    assert_eq!(relative_difference(&[1.0], &[f64::NAN]), Some(f64::INFINITY));
    assert_eq!(relative_difference(&[1.0], &[1.0, 2.0]), Some(f64::INFINITY));
    assert!(relative_difference(&[1.0], &[1.0 + f64::EPSILON]).is_some());
}

#[test]
fn medians_are_in_the_middle() {
    assert_eq!(median(&[]), None);
    assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
    assert_eq!(median(&[4.0, 1.0, 2.0, 9.0]), Some(3.0));
}
