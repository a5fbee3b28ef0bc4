//! Parts whose material is a name of the library.

use super::*;
use crate::scene::materials::library::find;

const LAW: &str = "/bodies/1/parts/1";

/// The sound scene with a part by its name, and what stands beside it.
fn named(part: Value) -> Value {
    with(LAW, part)
}

fn part(loaded: &Loaded) -> &document::PartDocument {
    &loaded.scene.document.bodies[1].parts[1]
}

#[test]
fn a_part_by_name_is_the_part_written_out() {
    for set in materials::library::sets().iter().filter(|set| set.material.family_count() == 0) {
        let name = &set.name;
        let by_name = load_value(&named(json!({"part": "*", "material": {"library": name}}))).unwrap();
        let mut out =
            json!({"part": "*", "material": set.material, "density_kg_per_m3": set.density_kg_per_m3});
        if let Some(prony) = &set.prony_series {
            out["prony_series"] = json!(prony);
        }
        if let Some(viscosity) = set.shear_viscosity_pa_s {
            out["shear_viscosity_pa_s"] = json!(viscosity);
        }
        let by_numbers = load_value(&named(out)).unwrap();
        assert_eq!(by_name.scene.content_hash, by_numbers.scene.content_hash, "{name}");
        assert_eq!(by_name.scene.bodies[1].materials, by_numbers.scene.bodies[1].materials, "{name}");
        assert_eq!(part(&by_name).library.as_deref(), Some(name.as_str()));
        assert_eq!(part(&by_numbers).library, None);
    }
}

#[test]
fn what_stands_beside_the_name_replaces_the_sets_own() {
    let loaded = load_value(&named(json!({
        "part": "*", "density_kg_per_m3": 900, "shear_viscosity_pa_s": 0, "prony_series": null,
        "material": {"library": "fat/naseri_2018_ogden", "bulk_modulus_pa": 1e6, "valid_to": {"stretch": [0.5, 1.2]}}
    })))
    .unwrap();
    let found = part(&loaded);
    assert_eq!((found.density_kg_per_m3, found.prony_series.as_ref()), (900.0, None));
    let mut expected = find("fat/naseri_2018_ogden").unwrap().material.clone();
    let document::MaterialDocument::Ogden(law) = &mut expected else { panic!("{expected:?}") };
    law.bulk_modulus_pa = 1e6;
    law.valid_to = serde_json::from_value(json!({"stretch": [0.5, 1.2]})).unwrap();
    assert_eq!(found.material, expected);
}

#[test]
fn ranges_beside_the_name_leave_the_sets_others_as_they_are() {
    let skin = |valid_to: Value| {
        let material = json!({"library": "skin/manschot_1986_across", "valid_to": valid_to});
        part(&load_value(&named(json!({"part": "*", "material": material}))).unwrap()).material.valid_to()
    };
    let narrow = skin(json!({"stretch": [0.95, 1.1]}));
    assert_eq!((narrow.stretch, narrow.limit_stretch), (Some([0.95, 1.1]), Some([0.7, 1.19])));
    let wide = skin(json!({"limit_stretch": [0.6, 1.3]}));
    assert_eq!((wide.stretch, wide.limit_stretch), (Some([0.94, 1.13]), Some([0.6, 1.3])));
    assert_eq!(skin(json!({"limit_stretch": null})).limit_stretch, None);
}

#[test]
fn null_omits_the_viscosity_of_a_set() {
    let viscosity = |beside: Value| {
        let mut document = json!({"part": "*", "material": {"library": "muscle/kang_2007_voigt_100hz"}});
        document.as_object_mut().unwrap().extend(beside.as_object().unwrap().clone());
        part(&load_value(&named(document)).unwrap()).shear_viscosity_pa_s
    };
    let own = viscosity(json!({}));
    let none = viscosity(json!({"shear_viscosity_pa_s": null}));
    assert_eq!((own, none), (4.5, 0.0));
}

#[test]
fn a_law_and_a_name_are_one_error() {
    let both =
        json!({"library": "fat/thigh_mre", "law": "neo_hookean", "c10_pa": 1e3, "bulk_modulus_pa": 5e7});
    let found = problems(&named(json!({"part": "*", "material": both})));
    let [problem] = &found[..] else { panic!("{found:#?}") };
    assert_eq!((&*problem.code, &problem.pointer), ("several_variants", &format!("{LAW}/material")));
    assert!(problem.remedy.starts_with("choose one of \"law\" and \"library\""), "{problem}");
}

#[test]
fn breaks_of_named_materials_are_reported_where_they_are() {
    let at = |place: &str| format!("{LAW}{place}");
    for (part, place, code) in [
        (
            json!({"part": "*", "material": {"library": "fat/naseri"}}),
            at("/material/library"),
            "unknown_material",
        ),
        (json!({"part": "*", "material": {"library": 3}}), at("/material/library"), "wrong_type"),
        (
            json!({"part": "*", "material": {"library": "fat/thigh_mre", "c10_pa": 1}}),
            at("/material/c10_pa"),
            "unknown_field",
        ),
        (
            json!({"part": "*", "material": {"law": "neo_hookean", "c10_pa": 5e3, "bulk_modulus_pa": 2e7}}),
            at("/density_kg_per_m3"),
            "missing_field",
        ),
        (
            json!({"part": "*", "library": "fat/thigh_mre", "material": {"library": "fat/thigh_mre"}}),
            at("/library"),
            "unknown_field",
        ),
        (
            json!({"part": "*", "material": {"library": "fat/thigh_mre", "bulk_modulus_pa": -1}}),
            at("/material/bulk_modulus_pa"),
            "not_positive",
        ),
    ] {
        let found = problems(&named(part.clone()));
        let errors: Vec<_> = found.iter().filter(|problem| problem.is_error()).collect();
        assert!(
            matches!(errors[..], [one] if one.pointer == place && one.code == code && !one.remedy.is_empty()),
            "{part}: {found:#?}"
        );
    }
    let found = problems(&named(json!({"part": "*", "material": {"library": "fat/naseri_2018_ogdn"}})));
    assert!(found[0].remedy.contains("did you mean \"fat/naseri_2018_ogden\""), "{found:#?}");
}

/// Warnings of a stiff volume, where two bodies are of the same set.
fn stiff_volumes(material: &Value, integrator: &Value) -> Vec<Problem> {
    let mut scene = named(json!({"part": "*", "material": material}));
    set(&mut scene, "/bodies/0/parts/0", json!({"part": "*", "material": material}));
    set(&mut scene, "/integrator", integrator.clone());
    problems(&scene).into_iter().filter(|problem| problem.code == "stiff_volume").collect()
}

#[test]
fn a_stiff_volume_is_warned_of_once_and_only_if_steps_are_shorter_than_usual() {
    let explicit = json!({"kind": "explicit"});
    let softest = json!({"library": "fat/naseri_2018_ogden"});
    assert_eq!(stiff_volumes(&softest, &explicit), [], "the library's own 50 MPa");
    let water = json!({"library": "fat/naseri_2018_ogden", "bulk_modulus_pa": 2.2e9});
    let found = stiff_volumes(&water, &explicit);
    let [problem] = &found[..] else { panic!("{found:#?}") };
    assert_eq!(problem.pointer, "/bodies/0/parts/0/material/bulk_modulus_pa");
    assert!(problem.remedy.contains("6.6 times as long"), "{problem}");
    assert_eq!(stiff_volumes(&water, &json!({"kind": "implicit", "step_s": 1e-6})), []);
}
