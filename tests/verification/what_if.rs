//! What-if: sharing and remembering change no bit, the reported edits make the case, and what must rise rises.

use crate::rig;
use contuse::measure::QuantityOfInterest;
use contuse::measure::summary::ErrorEstimate;
use contuse::scene::{Budget, Loaded, NoFiles};
use contuse::step::Interrupt;
use contuse::study::what_if::limit::Verdict;
use contuse::study::what_if::{
    Answer, Cache, CaseAnswer, Partial, WhatIfDocument, WhatIfRequest, check, study_what_if,
};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A rubber ball on a coarse limb.
pub fn limb() -> Value {
    let part = |part: &str, density: f64, c10: f64| {
        json!({"part": part, "density_kg_per_m3": density,
               "material": {"law": "neo_hookean", "c10_pa": c10, "bulk_modulus_pa": 5e6}})
    };
    json!({
        "name": "limb", "end_time_s": 2e-4,
        "bodies": [
            {"name": "ball", "role": "projectile",
             "mesh": {"generator": {"kind": "hollow_ball", "outer_radius_m": 0.015, "inner_radius_m": 0.011,
                                    "elements_around": 4, "elements_through": 1}},
             "placement": {"translation_m": [0, 0, 0.0451]},
             "velocity_m_per_s": [0, 0, -60],
             "parts": [part("ball", 1100.0, 5e5)]},
            {"name": "arm", "role": "tissue",
             "mesh": {"generator": {"kind": "limb_segment", "semi_axis_x_m": 0.034, "semi_axis_z_m": 0.03, "length_m": 0.1,
                "bone_semi_axis_x_m": 0.01, "bone_semi_axis_z_m": 0.01, "fat_thickness_m": 0.004, "skin_thickness_m": 0.002,
                "elements_around": 12, "elements_along": 6, "muscle_elements": 2, "fat_elements": 1, "skin_elements": 1,
                "grading_around": 2, "grading_along": 3}},
             "parts": [part("muscle", 1060.0, 2e4), part("fat", 950.0, 1e4), part("skin", 1100.0, 2e5)],
             "fixed": [{"set": "bone"}]}
        ],
        "contact": {"pairs": [{"between": ["ball", "arm"], "friction": 0.3}]},
        "record": {"field_interval_s": 2e-5},
        "measures": {"skin_set": "skin_outer", "stress_thresholds_pa": [5e3]}
    })
}

pub fn loaded(scene: &Value) -> Loaded {
    rig::loaded(scene, None)
}

pub fn question(question: Value) -> WhatIfDocument {
    serde_json::from_value(question).unwrap()
}

fn ask(
    base: &Loaded,
    question: &WhatIfDocument,
    cache: &Cache,
    threads: usize,
    shares_plans: bool,
) -> Answer {
    check(question, base, &NoFiles, &Budget::COMMAND_LINE).unwrap();
    study_what_if(&mut WhatIfRequest {
        question,
        base,
        source: &NoFiles,
        budget: &Budget::COMMAND_LINE,
        threads,
        cache,
        shares_plans,
        interrupt: &|| None,
        report: &mut |_| {},
    })
}

pub fn answer(base: &Loaded, requested: &WhatIfDocument) -> Answer {
    ask(base, requested, &Cache::default(), 2, true)
}

fn value(case: &CaseAnswer, quantity: QuantityOfInterest) -> f64 {
    case.numbers[&quantity].value
}

#[test]
fn sharing_remembering_and_threads_change_no_bit() {
    let base = loaded(&limb());
    let requested = question(json!({
        "parameters": [
            {"name": "speed", "change": {"kind": "speed_m_per_s"}, "low": 50, "high": 70},
            {"name": "tilt", "change": {"kind": "angle_deg", "about": [0, 1, 0]}, "low": -10, "high": 10},
            {"name": "friction", "change": {"kind": "friction"}, "low": 0, "high": 0.5},
            {"name": "fat", "change": {"kind": "layer_thickness_m", "layer": "fat"}, "low": 0.003, "high": 0.006}
        ],
        "one_at_a_time": true,
        "sample": {"count": 3},
        "limits": [{"parameter": "speed", "measure": {"von_mises_pa_below_depth_m": 0.004}, "at_most": 2e4, "tolerance": 0.1}]
    }));
    let folder = tempfile::tempdir().unwrap();
    let plain = ask(&base, &requested, &Cache::default(), 1, false);
    let shared = ask(&base, &requested, &Cache::in_folder(folder.path()).unwrap(), 3, true);
    let again = ask(&base, &requested, &Cache::in_folder(folder.path()).unwrap(), 2, true);
    for other in [&shared, &again] {
        assert_eq!(plain.cases, other.cases);
        assert_eq!(plain.limits, other.limits);
        assert_eq!(plain.sensitivities, other.sensitivities);
        assert_eq!(plain.spread, other.spread);
    }
    assert_eq!(again.effort.computed, 0);
    assert!(plain.cases.iter().all(|case| case.ending == "finished"), "{:#?}", plain.cases);
    assert!(plain.cases.iter().all(|case| case.numbers.values().all(|number| number.error.is_some())));
    // The stress below a depth has an error as any number.
    assert!(plain.limits[0].relative_error.is_some_and(|error| error > 0.0), "{:#?}", plain.limits[0]);
}

#[test]
fn a_case_is_the_run_of_the_scene_with_its_edits() {
    let scene = limb();
    let base = loaded(&scene);
    let requested = question(json!({
        "parameters": [
            {"name": "speed", "change": {"kind": "speed_m_per_s"}},
            {"name": "mass", "change": {"kind": "mass_kg"}},
            {"name": "around", "change": {"kind": "impact_around_deg"}},
            {"name": "along", "change": {"kind": "impact_along_m"}},
            {"name": "muscle", "change": {"kind": "stiffness_percentile", "body": "arm", "part": "muscle",
                                          "coefficient_of_variation": 0.4}},
            {"name": "window", "change": {"kind": "number", "pointer": "/end_time_s"}}
        ],
        "cases": [{"set": {"speed": 65, "mass": 0.012, "around": 30, "along": 0.01, "muscle": 90, "window": 1.5e-4}}],
        "error_bars": "none"
    }));
    let answer = answer(&base, &requested);
    let case = &answer.cases[1];
    assert_eq!(case.ending, "finished", "{:?}", case.reason);
    let mut edited = serde_json::to_value(&base.scene.document).unwrap();
    for (pointer, value) in &case.edits {
        *edited.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}")) = value.clone();
    }
    edited["solver"] = json!({"error_bars": "none"});
    let edited = loaded(&edited);
    assert!((edited.bodies[0].mass_kg - 0.012).abs() < 1e-12);
    let summary = rig::summary(&edited);
    for (quantity, number) in &case.numbers {
        assert_eq!(Some(number.value), quantity.of(summary.values()), "{quantity}");
    }
    // It strikes the new place as squarely as it struck the old one.
    assert!(
        value(case, QuantityOfInterest::PeakForceN)
            > 0.5 * value(&answer.cases[0], QuantityOfInterest::PeakForceN)
    );
}

#[test]
fn around_a_round_limb_nothing_changes_but_the_place() {
    let mut scene = limb();
    scene["bodies"][1]["mesh"]["generator"]["semi_axis_x_m"] = json!(0.03);
    // Turned, so that no node lies on the edge between two faces, of which rounding would choose one.
    scene["bodies"][0]["placement"]["rotation"] = json!({"axis": [1, 2, 3], "angle_deg": 7});
    let base = loaded(&scene);
    let requested = question(json!({
        "parameters": [{"name": "around", "change": {"kind": "impact_around_deg"}}],
        "cases": [{"set": {"around": 0}}, {"set": {"around": 75}}, {"set": {"around": 180}}],
        "error_bars": "none"
    }));
    let answer = answer(&base, &requested);
    for quantity in
        [QuantityOfInterest::PeakForceN, QuantityOfInterest::AbsorbedEnergyJ, QuantityOfInterest::ImpulseNS]
    {
        let [base, same, turned, opposite] = [0, 1, 2, 3].map(|index| value(&answer.cases[index], quantity));
        assert_eq!(base, same);
        assert!((turned / base - 1.0).abs() < 1e-6 && (opposite / base - 1.0).abs() < 1e-6, "{quantity}");
    }
}

#[test]
fn faster_means_more_energy_and_limits_lie_between() {
    let base = loaded(&limb());
    let requested = question(json!({
        "parameters": [{"name": "speed", "change": {"kind": "speed_m_per_s"}, "low": 30, "high": 90}],
        "cases": [{"set": {"speed": 30}}, {"set": {"speed": 45}}, {"set": {"speed": 60}}, {"set": {"speed": 75}}],
        "one_at_a_time": true,
        "error_bars": "none"
    }));
    let mut reported = Vec::new();
    let mut report = |partial: Partial| {
        if let Partial::Case { case, of, .. } = partial {
            reported.push((case.index, of));
        }
    };
    let answer = study_what_if(&mut WhatIfRequest {
        question: &requested,
        base: &base,
        source: &NoFiles,
        budget: &Budget::COMMAND_LINE,
        threads: 3,
        cache: &Cache::default(),
        shares_plans: true,
        interrupt: &|| None,
        report: &mut report,
    });
    assert_eq!(reported, (0..7).map(|index| (index, 7)).collect::<Vec<_>>());
    let energies: Vec<f64> =
        answer.cases[1..5].iter().map(|case| value(case, QuantityOfInterest::AbsorbedEnergyJ)).collect();
    assert!(energies.is_sorted_by(|a, b| a < b), "{energies:?}");
    assert_eq!(
        value(&answer.cases[0], QuantityOfInterest::AbsorbedEnergyJ),
        energies[2],
        "60 m/s is the base"
    );
    let energy =
        answer.sensitivities.iter().find(|s| s.quantity == QuantityOfInterest::AbsorbedEnergyJ).unwrap();
    // The touching area grows with the way and the pressure with the speed: about the third power, whose elasticity over ±50 % is
    // 3.25; at least proportional, and less than the fourth power's 5.
    assert!(energy.change > 0.0 && energy.rank == 1 && energy.is_monotone);
    assert!((1.0..5.0).contains(&energy.elasticity.unwrap()), "{energy:?}");

    // A limit between the energies of two cases is reached between their speeds.
    let limit = 0.5 * (energies[1] + energies[2]);
    let requested = question(json!({
        "parameters": [{"name": "speed", "change": {"kind": "speed_m_per_s"}, "low": 30, "high": 90}],
        "limits": [
            {"parameter": "speed", "measure": {"quantity": "absorbed_energy_j"}, "at_most": limit, "tolerance": 0.01},
            {"parameter": "speed", "measure": {"quantity": "absorbed_energy_j"}, "at_most": 1e9},
            {"parameter": "speed", "measure": {"quantity": "peak_force_n"}, "at_most": 0}
        ],
        "error_bars": "none"
    }));
    let limits = self::answer(&base, &requested).limits;
    let Verdict::KeptUpTo { kept_at, value, broken_at, value_broken } = limits[0].verdict else {
        panic!("{:?}", limits[0])
    };
    assert!(value <= limit && value_broken > limit && broken_at - kept_at <= 0.6 + 1e-9);
    assert!(45.0 < broken_at && kept_at < 60.0, "{kept_at} {broken_at}");
    assert!(matches!(limits[1].verdict, Verdict::KeptAtBothEnds { .. }));
    assert!(matches!(limits[2].verdict, Verdict::BrokenAtBothEnds { .. }));
}

#[test]
fn all_that_is_wrong_is_reported_at_once() {
    let base = loaded(&limb());
    let requested = question(json!({
        "parameters": [
            {"name": "speed", "change": {"kind": "speed_m_per_s", "body": "bal"}, "low": 2, "high": 1},
            {"name": "speed", "change": {"kind": "angle_deg", "about": [0, 0, 0]}, "low": 0, "high": 1},
            {"name": "fat", "change": {"kind": "stiffness_factor", "body": "arm", "part": "fet"}},
            {"name": "else", "change": {"kind": "number", "pointer": "/name"}, "low": 0, "high": 1}
        ],
        "cases": [{"set": {"sped": 1}}],
        "one_at_a_time": true,
        "sample": {"count": 1},
        "limits": [{"parameter": "x", "measure": {"von_mises_pa_below_depth_m": -1}, "at_most": 1, "tolerance": 9}]
    }));
    let problems = check(&requested, &base, &NoFiles, &Budget::COMMAND_LINE).unwrap_err();
    let mut pointers: Vec<&str> = problems.iter().map(|problem| problem.pointer.as_str()).collect();
    pointers.sort_unstable();
    let expected = [
        "/cases/0/set/sped",
        "/limits/0/measure/von_mises_pa_below_depth_m",
        "/limits/0/parameter",
        "/limits/0/tolerance",
        "/parameters/0/change/body",
        "/parameters/0/high",
        "/parameters/1/change/about",
        "/parameters/1/name",
        "/parameters/2",
        "/parameters/2/change/part",
        "/parameters/3/change/pointer",
        "/sample/count",
    ];
    assert_eq!(pointers, expected);
    assert!(problems.iter().all(|problem| !problem.remedy.is_empty()), "{problems:#?}");

    // What only the scene shows, at the end of the range that it is about.
    let requested = question(json!({
        "parameters": [{"name": "fat", "change": {"kind": "layer_thickness_m", "layer": "fat"}, "low": 0.004, "high": 0.05}],
        "one_at_a_time": true
    }));
    let problems = check(&requested, &base, &NoFiles, &Budget::COMMAND_LINE).unwrap_err();
    assert!(problems.iter().all(|problem| problem.pointer == "/parameters/0/high"), "{problems:#?}");
}

#[test]
fn speeds_that_no_body_has_are_reported_where_they_stand() {
    let mut scene = limb();
    scene["end_time_s"] = json!(2e-5);
    let base = loaded(&scene);
    let pointers = |requested: Value| {
        let problems = check(&question(requested), &base, &NoFiles, &Budget::COMMAND_LINE).unwrap_err();
        let of = |problem: &contuse::scene::Problem| (problem.pointer.clone(), problem.message.clone());
        problems.iter().map(of).unzip::<String, String, Vec<_>, Vec<_>>()
    };
    let speed = json!({"kind": "speed_m_per_s"});
    let (found, messages) = pointers(json!({
        "parameters": [{"name": "speed", "change": speed, "low": -5, "high": 60}],
        "cases": [{"set": {"speed": 10}}, {"name": "back", "set": {"speed": -1}}],
        "one_at_a_time": true
    }));
    assert_eq!(found, ["/parameters/0/low", "/cases/1/set/speed"]);
    assert!(messages[1].contains("back"), "{messages:?}");
    let normal = json!({"kind": "normal", "mean": 0, "standard_deviation": 30});
    let (found, _) = pointers(json!({
        "parameters": [{"name": "speed", "change": speed, "distribution": normal}],
        "sample": {"count": 4}
    }));
    assert_eq!(found, ["/parameters/0/distribution"]);

    // Of a sample they are cases that cannot run.
    let requested = question(json!({
        "parameters": [{"name": "speed", "change": speed, "low": 1, "high": 60, "distribution": normal}],
        "sample": {"count": 4},
        "error_bars": "none"
    }));
    let cases = answer(&base, &requested).cases;
    assert!(cases.iter().any(|case| case.ending == "invalid"));
    for case in &cases {
        assert_eq!(case.ending == "invalid", case.parameters["speed"] < 0.0, "{case:?}");
        assert!(case.ending != "invalid" || case.numbers.is_empty() && case.reason.is_some());
    }
}

#[test]
fn below_the_deepest_point_there_is_no_stress() {
    let base = loaded(&limb());
    let bone = "/bodies/1/mesh/generator/bone_semi_axis_x_m";
    let limits = |depth: f64| {
        question(json!({
            "parameters": [{"name": "bone", "change": {"kind": "number", "pointer": bone}, "low": 0.01, "high": 0.016}],
            "limits": [{"parameter": "bone", "measure": {"von_mises_pa_below_depth_m": depth}, "at_most": 30e3}],
            "error_bars": "none"
        }))
    };
    for depth in [0.05, 1e300] {
        let problems = check(&limits(depth), &base, &NoFiles, &Budget::COMMAND_LINE).unwrap_err();
        assert_eq!(problems[0].pointer, "/limits/0/measure/von_mises_pa_below_depth_m");
        // Muscle, fat and skin are 24 mm thick where they are thickest.
        let limit = problems[0].limit.strip_prefix("at most ").unwrap().strip_suffix(" m").unwrap();
        assert!((0.02..0.024).contains(&limit.parse::<f64>().unwrap()), "{limit}");
    }
    // Round a thicker bone they are 18 mm thick.
    let limits = answer(&base, &limits(0.02)).limits;
    let Verdict::NoNumber { at, reason } = &limits[0].verdict else { panic!("{limits:?}") };
    assert!((at - 0.016).abs() < 1e-15 && reason.contains("deep"), "{reason}");
}

#[test]
fn what_the_summary_does_not_resolve_no_answer_resolves() {
    let mut scene = limb();
    let requested = question(json!({
        "parameters": [{"name": "speed", "change": {"kind": "speed_m_per_s"}, "low": 50, "high": 70}],
        "cases": [{"set": {"speed": 60.5}}],
        "limits": [{"parameter": "speed", "measure": {"quantity": "principal_strain"}, "at_most": 0.2, "tolerance": 0.5}]
    }));
    let answer = answer(&loaded(&scene), &requested);
    scene["solver"] = json!({"error_bars": "two_levels"});
    let summary = rig::summary(&loaded(&scene));
    for (quantity, number) in &answer.cases[0].numbers {
        let ErrorEstimate::Estimated(error) = quantity.number(summary.values()).unwrap().error else {
            panic!("{quantity}")
        };
        assert_eq!(number.resolved, Some(error.resolved), "{quantity}");
    }
    // A peak at a point never is, whatever its error.
    assert!(
        answer
            .cases
            .iter()
            .all(|case| case.numbers[&QuantityOfInterest::PrincipalStrain].resolved == Some(false))
    );
    let limit = &answer.limits[0];
    assert_eq!((limit.resolved, &limit.if_larger, &limit.if_smaller), (Some(false), &None, &None));
    assert!(limit.relative_error.is_some());
}

#[test]
fn what_was_stopped_says_what_is_missing() {
    let mut scene = limb();
    scene["end_time_s"] = json!(2e-5);
    let base = loaded(&scene);
    // Stopped when it has requested so many times whether to stop; how often it has requested. One thread always asks as often.
    let stopped_after = |requested: &WhatIfDocument, most: usize| {
        let asking = AtomicUsize::new(0);
        check(requested, &base, &NoFiles, &Budget::COMMAND_LINE).unwrap();
        let answer = study_what_if(&mut WhatIfRequest {
            question: requested,
            base: &base,
            source: &NoFiles,
            budget: &Budget::COMMAND_LINE,
            threads: 1,
            cache: &Cache::default(),
            shares_plans: true,
            interrupt: &|| (asking.fetch_add(1, Ordering::SeqCst) >= most).then_some(Interrupt::Deadline),
            report: &mut |_| {},
        });
        (answer, asking.into_inner())
    };
    let parameters = json!([{"name": "speed", "change": {"kind": "speed_m_per_s"}, "low": 50, "high": 70}]);
    let requested = question(json!({
        "parameters": parameters,
        "sample": {"count": 4, "indices": true},
        "limits": [{"parameter": "speed", "measure": {"quantity": "peak_force_n"}, "at_most": 0}],
        "error_bars": "none"
    }));
    let (all, count) = stopped_after(&requested, usize::MAX);
    assert_eq!((all.stopped, all.cases.len(), all.limits.len()), (None, 13, 1));
    assert!(!all.sobol_indices.is_empty());
    let (answer, _) = stopped_after(&requested, count / 3);
    assert_eq!((answer.stopped, answer.requested_cases, answer.requested_limits), (Some("deadline"), 13, 1));
    assert!((1..13).contains(&answer.cases.len()) && answer.limits.is_empty());
    assert_eq!(answer.sobol_indices, [], "they take all points");

    // Nothing is missing of what was stopped after its end.
    let requested =
        question(json!({"parameters": parameters, "cases": [{"set": {"speed": 50}}], "error_bars": "none"}));
    let (_, count) = stopped_after(&requested, usize::MAX);
    let (answer, _) = stopped_after(&requested, count - 1);
    assert_eq!((answer.stopped, answer.cases.len()), (None, 2));
}
