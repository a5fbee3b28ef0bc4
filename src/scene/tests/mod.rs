//! Broken documents, and the problems reported for them.

mod broken;
mod cells;
mod element_values;
mod library;
mod mesh_formats;
mod rigid;
mod scans;
mod surface_nest;
mod surfaces;

use super::document::Keep;
use super::problem::MOST_LISTED;
use super::*;
use broken::broken;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Mesh files by name, in memory.
struct Files(Vec<(&'static str, Vec<u8>)>);

impl MeshSource for Files {
    fn read(&self, name: &str, limit: u64) -> Result<MeshBytes, MeshSourceError> {
        let found = self.0.iter().find(|(n, _)| *n == name);
        let known = self.0.iter().map(|(n, _)| (*n).to_owned()).collect();
        let (_, bytes) = found.ok_or(MeshSourceError::NotFound { name: name.into(), known })?;
        if bytes.len() as u64 > limit {
            return Err(MeshSourceError::TooLarge { name: name.into(), bytes: bytes.len() as u64, limit });
        }
        Ok(MeshBytes { file_name: name.into(), bytes: bytes.clone() })
    }
}

/// Gmsh 2.2: the unit cube, one element, part "cube"; inverted on request.
fn cube(inside_out: bool) -> Vec<u8> {
    let order = if inside_out { "5 6 7 8 1 2 3 4" } else { "1 2 3 4 5 6 7 8" };
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"cube\"\n$EndPhysicalNames\n$Nodes\n8\n\
         1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n\
         $Elements\n1\n1 5 2 1 1 {order}\n$EndElements\n"
    )
    .into_bytes()
}

fn files() -> Files {
    Files(vec![("cube.msh", cube(false)), ("bad.msh", cube(true)), ("noise.msh", b"$MeshFormat\nx".to_vec())])
}

/// A ball above a limb: every section of the document is used.
fn sound() -> Value {
    json!({
        "name": "ball on limb", "end_time_s": 1e-4,
        "bodies": [
            {
                "name": "ball", "role": "projectile",
                "mesh": {"generator": {"kind": "hollow_ball", "outer_radius_m": 0.015, "inner_radius_m": 0.012,
                                       "elements_around": 3, "elements_through": 1}},
                "placement": {"translation_m": [0.0, 0.0, 0.1], "rotation": {"axis": [0, 0, 1], "angle_deg": 30}},
                "parts": [{"part": "ball", "density_kg_per_m3": 1000,
                           "material": {"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7}}],
                "velocity_m_per_s": [0, 0, -100]
            },
            {
                "name": "limb", "role": "tissue",
                "mesh": {"generator": {"kind": "limb_segment", "semi_axis_x_m": 0.075, "semi_axis_z_m": 0.07,
                    "length_m": 0.2, "bone_semi_axis_x_m": 0.014, "bone_semi_axis_z_m": 0.014,
                    "fat_thickness_m": 0.008, "skin_thickness_m": 0.002, "elements_around": 12, "elements_along": 4,
                    "muscle_elements": 2, "fat_elements": 1, "skin_elements": 1}},
                "parts": [
                    {"part": "muscle", "density_kg_per_m3": 1060, "fibre_frame": {"kind": "mesh"},
                     "material": {"law": "holzapfel_gasser_ogden", "c_pa": 1e4, "k1_pa": 1e4, "k2": 1.0,
                                  "fibres": {"angles_deg": [15, -15]}, "bulk_modulus_pa": 2e7}},
                    {"part": "*", "density_kg_per_m3": 950,
                     "material": {"law": "neo_hookean", "c10_pa": 5e3, "bulk_modulus_pa": 2e7}}
                ],
                "fixed": [{"set": "bone"}]
            }
        ],
        "planes": [{"name": "floor", "point_m": [0, 0, -1], "normal": [0, 0, 2]}],
        "contact": {"pairs": [{"between": ["ball", "limb"], "friction": 0.3}, {"between": ["floor", "limb"]}],
                    "friction": 0.1},
        "gravity_m_per_s2": [0, 0, -9.81],
        "dynamic_relaxation": {"duration_s": 1e-5, "damping_per_s": 100},
        "integrator": {"kind": "explicit", "safety_factor": 0.9},
        "record": {"field_times_s": [0, 2.5e-5, 1e-4], "fields": ["von_mises"]},
        "measures": {"skin_set": "skin_outer", "stress_thresholds_pa": [1e4, 1e5]}
    })
}

fn load_value(document: &Value) -> Result<Loaded, Problems> {
    load(document.to_string().as_bytes(), &files(), &Budget::COMMAND_LINE)
}

/// The problems of a scene, warnings included, whether or not it loads.
fn problems(document: &Value) -> Vec<Problem> {
    match load_value(document) {
        Ok(loaded) => loaded.warnings,
        Err(Problems(problems)) => problems,
    }
}

/// The valid scene with the value at `pointer` replaced, or added to its object.
fn with(pointer: &str, value: Value) -> Value {
    let mut document = sound();
    set(&mut document, pointer, value);
    document
}

fn set(document: &mut Value, pointer: &str, value: Value) {
    if let Some(place) = document.pointer_mut(pointer) {
        *place = value;
        return;
    }
    let (parent, name) = pointer.rsplit_once('/').unwrap();
    document.pointer_mut(parent).unwrap().as_object_mut().unwrap().insert(name.into(), value);
}

#[test]
fn a_projectile_that_reaches_nothing_is_reported_before_it_runs() {
    // Loads move bodies in ways that are not known in advance.
    let mut free = sound();
    for load in ["gravity_m_per_s2", "dynamic_relaxation"] {
        free.as_object_mut().unwrap().remove(load);
    }
    let warnings = |velocity: [f64; 3], end: f64| {
        let mut document = free.clone();
        document["bodies"][0]["velocity_m_per_s"] = json!(velocity);
        document["end_time_s"] = json!(end);
        let all = load_value(&document).unwrap().warnings;
        all.into_iter().filter(|p| p.code == "nothing_in_reach").collect::<Vec<_>>()
    };
    assert_eq!(warnings([0.0, 0.0, -100.0], 1e-3), []);
    let away = &warnings([0.0, 0.0, 100.0], 1e-4)[0];
    assert_eq!(away.pointer, "/bodies/0/velocity_m_per_s");
    assert!(away.message.contains("flies past all other bodies"), "{away}");
    let late = &warnings([0.0, 0.0, -100.0], 1e-4)[0];
    assert!(late.remedy.contains("raise end_time_s"), "{late}");
}

#[test]
fn layers_that_are_hit_from_their_side_have_a_warning() {
    let law = json!({"law": "neo_hookean", "c10_pa": 1e4, "bulk_modulus_pa": 2e7});
    let scene = |center: [f64; 3], velocity: [f64; 3]| {
        json!({
            "name": "ball on layers", "end_time_s": 1e-3,
            "bodies": [
                {
                    "name": "ball", "role": "projectile", "velocity_m_per_s": velocity,
                    "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": center, "mass_kg": 0.03}
                },
                {
                    "name": "slab", "role": "tissue", "fixed": [{"set": "z_min"}],
                    "mesh": {"generator": {
                        "kind": "layered_block", "size_m": [0.06, 0.04], "elements": [4, 4],
                        "layers": [{"part": "skin", "thickness_m": 0.002, "elements": 1}, {"part": "fat", "thickness_m": 0.03, "elements": 4}]
                    }},
                    "parts": [{"part": "*", "density_kg_per_m3": 1000, "material": law}]
                }
            ]
        })
    };
    let found = |document: &Value| {
        let all = load_value(document).unwrap().warnings;
        all.into_iter().filter(|p| p.code == "hit_from_the_side").collect::<Vec<_>>()
    };
    // From above, also aslant from beyond an edge, depths are those below what is hit.
    assert_eq!(found(&scene([0.0, 0.0, 0.011], [0.0, 0.0, -10.0])), []);
    assert_eq!(found(&scene([0.05, 0.0, 0.03], [-30.0, 0.0, -20.0])), []);
    let beside = scene([0.041, 0.0, -0.015], [-10.0, 0.0, 0.0]);
    let [warning] = &found(&beside)[..] else { panic!("{:?}", found(&beside)) };
    assert_eq!(warning.pointer, "/measures/skin_set");
    assert!(warning.remedy.contains(r#""skin_set": "x_max""#), "{warning}");
    // Turned by a quarter, its top is hit by the same ball.
    let mut turned = beside.clone();
    turned["bodies"][1]["placement"] = json!({"rotation": {"axis": [0, 1, 0], "angle_deg": 90}});
    turned["bodies"][0]["rigid"]["center_m"] = json!([0.011, 0.0, 0.0]);
    assert_eq!(found(&turned), []);
    // With the side that is hit as skin, or without a skin to hit.
    let mut named = beside.clone();
    named["measures"] = json!({"skin_set": "x_max"});
    assert_eq!(found(&named), []);
    let mut held = beside;
    held["bodies"][1]["fixed"] = json!([{"set": "z_max"}]);
    assert_eq!(found(&held), []);
}

#[test]
fn the_sound_scene_loads_without_a_word() {
    let loaded = load_value(&sound()).unwrap();
    assert_eq!(loaded.warnings, []);
    let [ball, limb] = &loaded.scene.bodies[..] else { panic!() };
    assert_eq!((ball.mesh.cells.len(), limb.mesh.cells.len()), (54, 192));
    assert_eq!((ball.axes.len(), limb.axes.len()), (0, 192));
    let muscle = limb.mesh.part_of.iter().map(|&p| limb.mesh.parts[p as usize] == "muscle");
    assert!(muscle.zip(&limb.part_entry).all(|(is_muscle, &entry)| is_muscle == (entry == 0)));
    assert!(loaded.estimate.steps > 5 && loaded.estimate.steps < 10_000, "{:?}", loaded.estimate);
    assert!((loaded.bodies[0].mass_kg - 6.9e-3).abs() < 1e-3, "{:?}", loaded.bodies[0]);
    assert_eq!(loaded.scene.content_hash.len(), 64);
}

#[test]
fn the_name_of_the_question_is_that_of_its_content() {
    let hash = |document: &Value| load_value(document).unwrap().scene.content_hash;
    assert_eq!(
        hash(&sound()),
        hash(&with("/contact/tolerance", json!(1e-10))),
        "a default written out is the same"
    );
    assert_ne!(hash(&sound()), hash(&with("/end_time_s", json!(1.1e-4))));
}

#[test]
fn every_break_is_reported_where_it_is() {
    let mut wrong = Vec::new();
    for (place, value, pointer, code) in broken() {
        let found = problems(&with(place, value.clone()));
        if !found.iter().any(|p| p.pointer == pointer && p.code == code) {
            wrong.push(format!("{place} = {value}: no {code} at {pointer}, but {found:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_problem_has_a_limit_and_a_remedy() {
    for (place, value, ..) in broken() {
        for problem in problems(&with(place, value.clone())) {
            assert!(
                !problem.limit.is_empty() && !problem.remedy.is_empty(),
                "{place} = {value}: {problem:#?}"
            );
        }
    }
}

#[test]
fn one_break_brings_no_others() {
    // Breaks of one number or word that imply nothing else: exactly one error.
    for (place, value) in [
        ("/bodies/0/parts/0/material/law", json!("money_rivlin")),
        ("/bodies/0/parts/0/densty", json!(1)),
        ("/bodies/0/parts/0/material/c01_pa", json!("1")),
        ("/bodies/0/mesh/generator/kind", json!("holow_ball")),
        ("/contact/pairs", json!("al")),
        ("/bodies/0/name", json!(3)),
        ("/end_time_s", json!("soon")),
        ("/bodies/1/fixed/0/set", json!("bnoe")),
    ] {
        let found = problems(&with(place, value.clone()));
        assert_eq!(found.len(), 1, "{place} = {value}: {found:#?}");
    }
}

#[test]
fn ten_different_errors_are_all_reported() {
    let mut document = sound();
    let breaks = [
        ("/extra", json!(1), "unknown_field", "/extra"),
        ("/bodies/0/role", json!("missile"), "unknown_variant", "/bodies/0/role"),
        (
            "/bodies/0/parts/0/material/law",
            json!("rubber"),
            "unknown_variant",
            "/bodies/0/parts/0/material/law",
        ),
        (
            "/bodies/0/mesh/generator/inner_radius_m",
            json!(0.5),
            "bad_generator_parameter",
            "/bodies/0/mesh/generator/inner_radius_m",
        ),
        (
            "/bodies/1/parts/0/density_kg_per_m3",
            json!(-1),
            "not_positive",
            "/bodies/1/parts/0/density_kg_per_m3",
        ),
        ("/bodies/1/parts/0/material/kappa", json!(0.5), "out_of_range", "/bodies/1/parts/0/material/kappa"),
        ("/bodies/1/fixed/0/set", json!("boen"), "unknown_set", "/bodies/1/fixed/0/set"),
        ("/contact/pairs/0/between/1", json!("lim"), "unknown_body", "/contact/pairs/0/between/1"),
        ("/planes/0/normal", json!([0, 0]), "too_few_items", "/planes/0/normal"),
        ("/record/field_times_s", json!([0, 1]), "time_outside_run", "/record/field_times_s/1"),
    ];
    for (place, value, ..) in &breaks {
        set(&mut document, place, value.clone());
    }
    let Problems(found) = load_value(&document).unwrap_err();
    let found: BTreeSet<(&str, &str)> = found.iter().map(|p| (&*p.code, p.pointer.as_str())).collect();
    let expected: BTreeSet<(&str, &str)> = breaks.iter().map(|b| (b.2, b.3)).collect();
    assert_eq!(found, expected);
}

#[test]
fn misspelt_words_are_answered_with_the_right_ones() {
    for (place, value, hint) in [
        ("/bodies/0/parts/0/density", json!(1), "density_kg_per_m3"),
        ("/bodies/0/parts/0/material/law", json!("money_rivlin"), "mooney_rivlin"),
        ("/bodies/0/role", json!("projectil"), "projectile"),
        ("/contact/pairs/0/between/0", json!("bal"), "ball"),
        ("/bodies/1/fixed/0/set", json!("bnoe"), "bone"),
        ("/bodies/0/mesh", json!({"file": {"name": "cub.msh"}}), "cube.msh"),
        ("/record/fields/0", json!("vonmises"), "von_mises"),
    ] {
        let found = problems(&with(place, value));
        assert!(
            found.iter().any(|p| p.remedy.contains(&format!("did you mean {hint:?}"))),
            "{place}: {found:#?}"
        );
    }
}

#[test]
fn an_unknown_thing_to_keep_is_answered_with_all_that_there_are() {
    let found = problems(&with("/solver", json!({"keep": ["history"]})));
    assert_eq!((found.len(), found[0].pointer.as_str()), (1, "/solver/keep/0"));
    for keep in Keep::ALL {
        assert!(found[0].limit.contains(keep.name()), "{}", found[0]);
    }
}

#[test]
fn what_is_kept_is_restored_once() {
    let mut scene = load_value(&with("/solver", json!({"keep": ["idle_fibres"]}))).unwrap().scene;
    scene.restore(&[Keep::UnrequestedFields, Keep::IdleFibres]);
    assert_eq!(scene.document.solver.keep, [Keep::IdleFibres, Keep::UnrequestedFields]);
    assert_eq!(scene.document.recorded_fields(), document::FieldName::ALL);
    assert_eq!(
        load_value(&sound()).unwrap().scene.document.recorded_fields(),
        [document::FieldName::VonMises]
    );
}

#[test]
fn a_missing_mesh_is_reported_of_every_body_that_names_it() {
    let mut document = with("/bodies/0/mesh", json!({"file": {"name": "cueb.msh"}}));
    set(&mut document, "/bodies/1/mesh", json!({"file": {"name": "cueb.msh"}}));
    let found = problems(&document);
    let missing: Vec<&Problem> = found.iter().filter(|p| p.code == "mesh_not_found").collect();
    let places: Vec<&str> = missing.iter().map(|p| p.pointer.as_str()).collect();
    assert_eq!(places, ["/bodies/0/mesh/file/name", "/bodies/1/mesh/file/name"], "{found:#?}");
    assert!(missing[1].remedy.starts_with("did you mean \"cube.msh\"?"), "{}", missing[1]);

    let Problems(found) = load(document.to_string().as_bytes(), &NoFiles, &Budget::COMMAND_LINE).unwrap_err();
    let missing: Vec<&Problem> = found.iter().filter(|p| p.code == "mesh_not_found").collect();
    assert!(missing.len() == 2 && missing[0].remedy.contains("into the folder of the scene"), "{found:#?}");
}

#[test]
fn a_key_written_twice_is_refused() {
    let text = sound().to_string().replacen("\"end_time_s\":", "\"end_time_s\":1.0,\"end_time_s\":", 1);
    let Problems(found) = load(text.as_bytes(), &files(), &Budget::COMMAND_LINE).unwrap_err();
    assert_eq!((&*found[0].code, found[0].pointer.as_str()), ("repeated_key", "/end_time_s"));
}

#[test]
fn coupled_laws_refuse_mean_dilatation() {
    let mut document = with("/bodies/1/parts/0/material/matrix", json!("coupled"));
    set(&mut document, "/bodies/1/parts/0/formulation", json!("mean_dilatation"));
    let found = problems(&document);
    assert_eq!(found[0].code, "coupled_law_with_mean_dilatation");
    assert_eq!(found[0].pointer, "/bodies/1/parts/0/formulation");
    for formulation in ["full", "reduced"] {
        set(&mut document, "/bodies/1/parts/0/formulation", json!(formulation));
        assert!(load_value(&document).is_ok(), "{formulation}");
    }
}

#[test]
fn single_precision_is_for_moderate_bulk_moduli() {
    // G = 2 C₁₀ is 10 kPa.
    let mut document = with("/bodies/1/parts/1/formulation", json!("mean_dilatation_single"));
    for (bulk_modulus, is_refused) in [(5.0e7, false), (5.1e7, true)] {
        set(&mut document, "/bodies/1/parts/1/material/bulk_modulus_pa", json!(bulk_modulus));
        let found = problems(&document);
        let codes: Vec<&str> = found.iter().map(|problem| &*problem.code).collect();
        assert_eq!(codes == ["incompressible_in_single_precision"], is_refused, "{found:#?}");
    }
    // The remedy.
    set(&mut document, "/bodies/1/parts/1/formulation", json!("mean_dilatation"));
    assert!(load_value(&document).is_ok());
}

#[test]
fn bodies_that_start_inside_each_other_are_refused_with_place_and_depth() {
    let overlaps = |document: &Value| -> Vec<Problem> {
        problems(document).into_iter().filter(|p| p.code == "initial_overlap").collect()
    };
    // The top of the limb is at z = 0.07; an even count gives the ball a node at its pole, 0.015 below its centre.
    let mut sunk = with("/bodies/0/placement/translation_m", json!([0, 0, 0.084]));
    set(&mut sunk, "/bodies/0/mesh/generator/elements_around", json!(4));
    let found = overlaps(&sunk);
    assert_eq!((found.len(), found[0].pointer.as_str()), (1, "/bodies/0"), "{found:#?}");
    let depth = found[0].value.as_f64().unwrap();
    assert!((depth - 0.001).abs() < 2e-4, "{}", found[0]);
    assert!(found[0].message.contains("ball and limb") && found[0].message.contains("0.069"), "{}", found[0]);

    let through_floor = with("/planes/0/point_m", json!([0, 0, -0.069]));
    let found = overlaps(&through_floor);
    assert_eq!((found.len(), found[0].pointer.as_str()), (1, "/bodies/1"));
    assert!((found[0].value.as_f64().unwrap() - 0.001).abs() < 1e-5, "{}", found[0]);

    assert!(overlaps(&with("/contact/pairs", json!([]))).is_empty(), "what may not touch may overlap");
    let mut all = sunk;
    set(&mut all, "/contact/pairs", json!("all"));
    assert_eq!(overlaps(&all).len(), 1);
}

#[test]
fn a_strange_service_allows_less() {
    let budget = Budget { elements: 200, ..Budget::SERVICE };
    let Problems(found) = load(sound().to_string().as_bytes(), &files(), &budget).unwrap_err();
    assert_eq!(found[0].code, "budget_elements");
    assert_eq!(found[0].pointer, "/bodies/1/mesh/generator");
    let budget = Budget { mesh_bytes: 10, document_bytes: 100_000, ..Budget::SERVICE };
    let document = with("/bodies/0/mesh", json!({"file": {"name": "cube.msh"}}));
    let Problems(found) = load(document.to_string().as_bytes(), &files(), &budget).unwrap_err();
    assert!(found.iter().any(|p| p.code == "budget_mesh_bytes"), "{found:#?}");
}

#[test]
fn a_document_of_mistakes_is_answered_briefly() {
    let Problems(found) = load(br#"{"bodies": [0]}"#, &files(), &Budget::SERVICE).unwrap_err();
    assert!(found.len() < 20);
    let many = json!({"bodies": vec![0; 5000]}).to_string();
    let Problems(found) = load(many.as_bytes(), &files(), &Budget::SERVICE).unwrap_err();
    let last = found.last().unwrap();
    assert_eq!((found.len(), &*last.code), (MOST_LISTED + 1, "too_many_problems"));
    assert!(last.value.as_u64() >= Some(4900), "{last}");
    let longer = json!({"bodies": vec![0; 20_000]}).to_string();
    let Problems(found) = load(longer.as_bytes(), &files(), &Budget::SERVICE).unwrap_err();
    assert_eq!(
        (found.len(), found[0].code.as_ref(), found[0].pointer.as_str()),
        (1, "list_too_long", "/bodies")
    );
}
