//! Parameters that vary between the sources of a set of the library.

use crate::what_if::{answer, limb, loaded, question};
use contuse::scene::materials::library::find;
use contuse::scene::{Budget, NoFiles};
use contuse::study::what_if::check;
use serde_json::{Value, json};

/// The limb with muscle and fat of the library.
fn library_limb() -> Value {
    let mut scene = limb();
    let part =
        |part: &str, set: &str| json!({"part": part, "material": {"library": set, "bulk_modulus_pa": 5e6}});
    scene["bodies"][1]["parts"][0] = part("muscle", "muscle/kang_2007_voigt_100hz");
    scene["bodies"][1]["parts"][1] = part("fat", "fat/engelbrektsson_2011_ogden");
    scene
}

fn fat_stiffness(set: &str) -> Value {
    json!({"name": "fat", "change": {"kind": "stiffness_factor", "body": "arm", "part": "fat"},
           "distribution": {"kind": "library", "set": set}})
}

#[test]
fn ends_and_samples_lie_between_the_sources() {
    let base = loaded(&library_limb());
    let viscosity = json!({"name": "viscosity", "distribution": {"kind": "library", "set": "muscle/kang_2007_voigt_100hz"},
        "change": {"kind": "number", "pointer": "/bodies/1/parts/0/shear_viscosity_pa_s"}});
    let requested = question(json!({
        "parameters": [fat_stiffness("fat/engelbrektsson_2011_ogden"), viscosity],
        "one_at_a_time": true, "sample": {"count": 4, "seed": 3}, "error_bars": "none"
    }));
    let answer = answer(&base, &requested);
    // Factors of the 3300 Pa that the set has before it relaxes, and Pa s.
    let [fat, viscosity] = ["fat/engelbrektsson_2011_ogden", "muscle/kang_2007_voigt_100hz"]
        .map(|name| find(name).unwrap().spread.last().unwrap().clone());
    let ranges = [[fat.least / 3300.0, fat.most / 3300.0], [viscosity.least, viscosity.most]];
    for (parameter, range) in answer.parameters.iter().zip(ranges) {
        assert_eq!(parameter.range, Some(range));
    }
    assert_eq!(ranges[1], [2.4, 31.0]);
    for case in &answer.cases {
        assert!(case.reason.is_none(), "{case:?}");
        for (name, value) in &case.parameters {
            let [low, high] = ranges[usize::from(name == "viscosity")];
            assert!(*value >= low * (1.0 - 1e-12) && *value <= high * (1.0 + 1e-12), "{name} = {value}");
        }
    }
}

#[test]
fn what_no_source_states_is_refused() {
    let base = loaded(&library_limb());
    let requested = question(json!({
        "parameters": [
            fat_stiffness("fat/engelbrecht"),
            {"name": "other", "change": {"kind": "stiffness_factor", "body": "arm", "part": "fat"},
             "distribution": {"kind": "library", "set": "fat/thigh_mre"}},
            {"name": "friction", "change": {"kind": "friction"},
             "distribution": {"kind": "library", "set": "fat/thigh_mre"}},
            {"name": "skin", "change": {"kind": "stiffness_factor", "body": "arm", "part": "skin"},
             "distribution": {"kind": "library", "set": "skin/manschot_1986_across"}}
        ],
        "one_at_a_time": true
    }));
    let problems = check(&requested, &base, &NoFiles, &Budget::COMMAND_LINE).unwrap_err();
    let found: Vec<(&str, &str)> = problems.iter().map(|p| (p.pointer.as_str(), p.code.as_ref())).collect();
    let place = |i: u32| format!("/parameters/{i}/distribution/set");
    let expected = [
        (place(0), "unknown_material"),
        (place(1), "other_set"),
        (place(2), "no_spread"),
        (place(3), "other_set"),
    ];
    let expected: Vec<(&str, &str)> = expected.iter().map(|(place, code)| (place.as_str(), *code)).collect();
    assert_eq!(found, expected);
    assert!(problems.iter().all(|p| !p.limit.is_empty() && !p.remedy.is_empty()), "{problems:#?}");
}
