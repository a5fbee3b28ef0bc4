use super::*;
use crate::scene::{Budget, NoFiles, load};
use serde_json::{Value, json};

fn loaded(document: &Value) -> Scene {
    load(document.to_string().as_bytes(), &NoFiles, &Budget::COMMAND_LINE).unwrap().scene
}

/// A block over another one, with fibres at these angles to x.
fn blocks(angles: &[f64]) -> Value {
    let block = |name: &str, low: [f64; 3], velocity: f64| {
        json!({
            "name": name,
            "mesh": {"generator": {"kind": "block", "min_m": low, "max_m": [low[0] + 0.02, low[1] + 0.02, low[2] + 0.02],
                "elements": [2, 2, 2]}},
            "velocity_m_per_s": [0, 0, velocity],
            "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": {"law": "holzapfel_gasser_ogden", "c_pa": 1e5, "k1_pa": 1e5,
                "k2": 1, "fibres": {"angles_deg": angles}, "bulk_modulus_pa": 1e7}}]
        })
    };
    json!({"name": "blocks", "end_time_s": 1e-4,
        "bodies": [block("low", [0.0, 0.0, 0.0], 0.0), block("high", [0.0, 0.0, 0.021], -10.0)]})
}

#[test]
fn planes_are_through_the_middle_of_all_bodies() {
    let symmetry = Symmetry::of(&loaded(&blocks(&[20.0, -20.0]))).unwrap();
    // Not normal to z, along which the blocks move and lie apart.
    assert_eq!(symmetry.planes, [MirrorPlane { axis: 0, at: 0.01 }, MirrorPlane { axis: 1, at: 0.01 }]);
    let elements =
        |plane: usize| symmetry.images[0][plane].as_ref().map(|images| images.elements.clone()).unwrap();
    assert_eq!(elements(0), [1, 0, 3, 2, 5, 4, 7, 6]);
    assert_eq!(elements(1), [2, 3, 0, 1, 6, 7, 4, 5]);
}

#[test]
fn fibres_are_compared_by_the_stress_that_they_cause() {
    let has_planes = |angles: &[f64]| Symmetry::of(&loaded(&blocks(angles))).is_some();
    assert!(has_planes(&[0.0]) && has_planes(&[90.0]) && has_planes(&[35.0, -35.0]));
    assert!(!has_planes(&[35.0]) && !has_planes(&[35.0, -30.0]));
}

#[test]
fn a_rigid_body_has_its_principal_axes_along_those_of_the_planes() {
    let with_box = |rotation: Value| {
        let mut document = blocks(&[0.0]);
        document["bodies"][1] = json!({"name": "high", "velocity_m_per_s": [0, 0, -10], "rigid": {
            "shape": {"kind": "box", "half_extents_m": [0.01, 0.008, 0.01]}, "mass_kg": 0.1, "center_m": [0.01, 0.01, 0.04], "rotation": rotation}});
        Symmetry::of(&loaded(&document)).map_or(0, |symmetry| symmetry.planes.len())
    };
    assert_eq!(with_box(Value::Null), 2);
    assert_eq!(with_box(json!({"axis": [0, 0, 1], "angle_deg": 90})), 2);
    assert_eq!(with_box(json!({"axis": [0, 0, 1], "angle_deg": 10})), 0);
}
