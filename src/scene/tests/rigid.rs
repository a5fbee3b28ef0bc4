//! Scenes of rigid bodies: valid ones, and broken variants, one per line.

use super::{load_value, problems, set};
use serde_json::{Value, json};

/// A ball above a box, which stands on a plane.
fn sound() -> Value {
    json!({
        "name": "rigid",
        "end_time_s": 0.1,
        "bodies": [
            {
                "name": "ball",
                "role": "projectile",
                "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [0, 0, 0.11], "mass_kg": 0.03},
                "velocity_m_per_s": [0, 0, -1],
                "spin_rad_per_s": [0, 5, 0]
            },
            {
                "name": "box",
                "rigid": {
                    "shape": {"kind": "box", "half_extents_m": [0.05, 0.04, 0.03]},
                    "center_m": [0, 0, 0.03], "density_kg_per_m3": 700, "inertia_kg_m2": [3e-4, 4e-4, 5e-4],
                    "rotation": {"axis": [0, 0, 1], "angle_deg": 30}
                }
            }
        ],
        "planes": [{"name": "ground", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "gravity_m_per_s2": [0, 0, -9.81],
        "integrator": {"kind": "explicit", "max_step_s": 1e-4}
    })
}

fn with(pointer: &str, value: Value) -> Value {
    let mut document = sound();
    set(&mut document, pointer, value);
    document
}

#[test]
fn a_scene_of_rigid_bodies_alone_loads_without_a_word() {
    let loaded = load_value(&sound()).unwrap();
    assert!(loaded.warnings.is_empty(), "{:#?}", loaded.warnings);
    let [ball, cuboid] = &loaded.bodies[..] else { panic!("two bodies") };
    assert_eq!((ball.mass_kg, ball.elements), (0.03, 0));
    assert!((cuboid.mass_kg - 700.0 * 8.0 * 0.05 * 0.04 * 0.03).abs() < 1e-12);
    assert_eq!(loaded.estimate.steps, 1000);
}

#[test]
#[rustfmt::skip]
fn every_break_is_reported_where_it_is() {
    let generator = json!({"generator": {"kind": "solid_ball", "radius_m": 0.01, "elements_around": 2, "elements_through": 1}});
    let breaks = [
        ("/bodies/0/rigid", json!(null), "/bodies/0/mesh", "missing_field"),
        ("/bodies/0/rigid/mass", json!(1), "/bodies/0/rigid/mass", "unknown_field"),
        ("/bodies/0/rigid/shape", json!({"kind": "bal", "radius_m": 1}), "/bodies/0/rigid/shape/kind", "unknown_variant"),
        ("/bodies/0/rigid/shape", json!({"kind": "ball", "radius": 1}), "/bodies/0/rigid/shape/radius", "unknown_field"),
        ("/bodies/0/rigid/shape/radius_m", json!(0), "/bodies/0/rigid/shape/radius_m", "not_positive"),
        ("/bodies/0/rigid/shape", json!({"kind": "capsule", "radius_m": 0.01, "half_length_m": 0.02, "axis": [0, 0, 0]}), "/bodies/0/rigid/shape/axis", "no_direction"),
        ("/bodies/1/rigid/shape/half_extents_m/1", json!(-1), "/bodies/1/rigid/shape/half_extents_m/1", "not_positive"),
        ("/bodies/1/rigid/shape/half_extents_m", json!([50, 40, 30]), "/bodies/1/rigid/shape", "unusual_unit"),
        ("/bodies/1/rigid/rotation/axis", json!([0, 0, 0]), "/bodies/1/rigid/rotation/axis", "no_direction"),
        ("/bodies/0/rigid/density_kg_per_m3", json!(1000), "/bodies/0/rigid/mass_kg", "mass_or_density"),
        ("/bodies/0/rigid/mass_kg", json!(null), "/bodies/0/rigid/mass_kg", "mass_or_density"),
        ("/bodies/0/rigid/mass_kg", json!(-1), "/bodies/0/rigid/mass_kg", "not_positive"),
        ("/bodies/1/rigid/density_kg_per_m3", json!(7.85), "/bodies/1/rigid/density_kg_per_m3", "unusual_unit"),
        ("/bodies/1/rigid/inertia_kg_m2", json!([1, 1, 3]), "/bodies/1/rigid/inertia_kg_m2/2", "impossible_inertia"),
        ("/bodies/1/rigid/inertia_kg_m2", json!([1, 1, 0]), "/bodies/1/rigid/inertia_kg_m2/2", "not_positive"),
        ("/bodies/1/rigid/inertia_kg_m2", json!([0.3, 0.4, 0.5]), "/bodies/1/rigid/inertia_kg_m2/0", "impossible_inertia"),
        ("/bodies/1/rigid/inertia_kg_m2", json!([3e-9, 4e-9, 5e-9]), "/bodies/1/rigid/inertia_kg_m2/0", "impossible_inertia"),
        ("/bodies/0/spin_rad_per_s", json!([0, 1e6, 0]), "/bodies/0/spin_rad_per_s", "impossible_spin"),
        ("/bodies/0/role", json!("tissue"), "/bodies/0/role", "rigid_tissue"),
        ("/bodies/0/mesh", generator, "/bodies/0/mesh", "not_for_rigid"),
        ("/bodies/0/fixed", json!([{"set": "*"}]), "/bodies/0/fixed", "not_for_rigid"),
        ("/bodies/0/velocity_m_per_s", json!([0, 0, -3000]), "/bodies/0/velocity_m_per_s", "unusual_unit"),
        ("/integrator", json!({"kind": "explicit"}), "/integrator/max_step_s", "no_step"),
        ("/contact", json!({"pairs": [{"between": ["ball", "ball"]}]}), "/contact/pairs/0/between", "rigid_self_contact"),
        ("/bodies/0/rigid/center_m", json!([0, 0, 0.069]), "/bodies/0", "initial_overlap"),
        ("/bodies/1/rigid/center_m", json!([0, 0, 0.029]), "/bodies/1", "initial_overlap"),
    ];
    for (pointer, value, expected, code) in breaks {
        let found = problems(&with(pointer, value.clone()));
        let hit = found.iter().find(|p| p.pointer == expected && p.code == code);
        let hit = hit.unwrap_or_else(|| panic!("{pointer} = {value}: {found:#?}"));
        assert!(!hit.limit.is_empty() && !hit.remedy.is_empty(), "{hit}");
    }
}

#[test]
fn a_rigid_body_inside_a_mesh_is_refused_with_its_depth() {
    let mut document = sound();
    set(
        &mut document,
        "/bodies/1",
        json!({
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [-0.05, -0.05, 0], "max_m": [0.05, 0.05, 0.05], "elements": [8, 8, 2]}},
            "parts": [{"part": "*", "density_kg_per_m3": 1000,
                       "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7}}]
        }),
    );
    set(&mut document, "/bodies/0/rigid/center_m", json!([0, 0, 0.06 - 1e-9]));
    assert!(problems(&document).iter().all(|p| p.code != "initial_overlap"));
    set(&mut document, "/bodies/0/rigid/center_m", json!([0, 0, 0.058]));
    let found = problems(&document);
    let overlap = found.iter().find(|p| p.code == "initial_overlap").unwrap();
    assert!((overlap.value.as_f64().unwrap() - 0.002).abs() < 1e-9, "{overlap}");
    // Wholly inside, away from every node.
    set(&mut document, "/bodies/1/mesh/generator/elements", json!([2, 2, 1]));
    set(&mut document, "/bodies/0/rigid/shape/radius_m", json!(0.009));
    set(&mut document, "/bodies/0/rigid/center_m", json!([0.02, 0.02, 0.02]));
    let found = problems(&document);
    assert!(found.iter().any(|p| p.code == "initial_overlap"), "{found:#?}");
    // Above it, at any distance, there is no overlap.
    set(&mut document, "/bodies/0/rigid/center_m", json!([0.02, 0.02, 0.1]));
    let found = problems(&document);
    assert!(found.iter().all(|p| p.code != "initial_overlap"), "{found:#?}");
}
