//! What is shown of a run that cannot be a result: nothing touched, the error is unknown, the law was left.

use crate::rig;
use contuse::measure::summary::{ErrorEstimate, Shown};
use contuse::measure::{Summary, render_table};
use contuse::mesh::Mesh;
use serde_json::{Value, json};

/// The summary of a scene, with its error bars.
pub fn summary(document: &Value, mesh: Option<Mesh>) -> Summary {
    rig::summary(&rig::loaded(document, mesh))
}

/// A soft ball over a block of gel that is held at the bottom.
pub fn ball_on_gel(velocity: [f64; 3], end_time_s: f64) -> Value {
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
fn the_headline_contact_is_that_of_what_the_projectile_pushes_onto_the_tissue() {
    let stiff = json!({"law": "neo_hookean", "c10_pa": 1e6, "bulk_modulus_pa": 1e7});
    let plate = json!({
        "name": "plate", "role": "other",
        "mesh": {"generator": {"kind": "block", "min_m": [-0.02, -0.02, 0.0402], "max_m": [0.02, 0.02, 0.0442], "elements": [6, 6, 2]}},
        "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": stiff}]
    });
    let mut scene = ball_on_gel([0.0, 0.0, -15.0], 2e-3);
    scene["bodies"][0]["mesh"]["generator"]["center_m"] = json!([0, 0, 0.055]);
    scene["bodies"].as_array_mut().unwrap().push(plate);
    scene["contact"] = json!({"friction": 0.3});
    scene["solver"] = json!({"error_bars": "none"});
    let of_plate = summary(&scene, None);
    let impact = of_plate.values().headline_impact().unwrap();
    assert!(
        impact.between.contains(&"plate".into()) && impact.between.contains(&"gel".into()),
        "{}",
        impact.pair
    );
    assert!(impact.impulse_n_s.value > 0.01 && impact.peak_force_n.value > 10.0);
    // Away from the ball the plate, which nothing pushes, strikes nothing.
    scene["bodies"][0]["mesh"]["generator"]["center_m"] = json!([0, 0, 0.1]);
    let of_ball = summary(&scene, None);
    assert!(of_ball.values().headline_impact().unwrap().between.contains(&"ball".into()));
}

#[test]
fn a_number_of_unknown_error_is_no_plain_one() {
    let mut scene = ball_on_gel([0.0, 0.0, -5.0], 1e-3);
    scene["solver"] = json!({"error_bars": "none"});
    let summary = summary(&scene, None);
    let impact = &summary.values().impacts[0];
    assert!(impact.contact_span_s.is_some() && !impact.peak_force_n.error.is_resolved());
    let table = render_table(&summary);
    let results = table.split("Injury").next().unwrap();
    let row = results.lines().find(|line| line.contains("peak force, ")).unwrap();
    assert!(row.contains('(') && row.contains(") N") && row.contains("error not estimated"), "{row}");
    assert!(summary.plain_words.iter().any(|words| words.contains("(error not estimated)")));
}

#[test]
fn rigid_bodies_have_no_mesh_whose_error_could_be_estimated() {
    let scene = json!({
        "name": "rigid ball on a plane", "end_time_s": 0.01,
        "bodies": [{
            "name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -1],
            "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [0, 0, 0.012], "mass_kg": 0.03}
        }],
        "planes": [{"name": "ground", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "integrator": {"kind": "explicit", "max_step_s": 1e-4}
    });
    let reason = summary(&scene, None).error_bars;
    assert_eq!(reason, "not estimated: there is no mesh whose error could be estimated");
}

#[test]
fn a_law_that_was_left_is_reported_and_beyond_its_limit_nothing_is_shown() {
    let with_range = |valid_to: Value| {
        let mut scene = ball_on_gel([0.0, 0.0, -5.0], 1e-3);
        scene["solver"] = json!({"error_bars": "none"});
        scene["bodies"][1]["parts"][0]["material"]["valid_to"] = valid_to;
        summary(&scene, None)
    };
    let left = with_range(json!({"stretch": [0.999, 1.001], "jacobian": [0.5, 2.0]}));
    let gel = left.law_ranges.iter().find(|law| law.body == "gel").unwrap();
    assert!(
        gel.fraction_outside > 0.01 && gel.fraction_outside <= 1.0 && gel.fraction_beyond_limit == 0.0,
        "{gel:?}"
    );
    assert!(gel.stretch[1] > 1.001 && gel.outside_since_s > 0.0, "{gel:?}");
    let Shown::Results(results) = &left.results else { panic!("{:?}", left.plain_words) };
    // The largest principal strain E of the summary is the same number as the largest stretch: 2E = λ² − 1.
    let strain =
        results.tissue.as_ref().unwrap().peaks.peak_principal_strain.as_ref().unwrap().quantity.value;
    assert!((gel.stretch[1].powi(2) - 1.0 - 2.0 * strain).abs() < 1e-12, "{strain} {gel:?}");
    assert!(
        left.warnings.iter().any(|w| w.contains("beyond the range of their laws")
            && w.contains("(gel) in ")
            && w.contains("fitted")),
        "{:?}",
        left.warnings
    );

    // An elastic gel, of which no velocity is recorded: its strain rates are compared all the same.
    let fast = with_range(json!({"strain_rate_per_s": [0.0, 1.0]}));
    let rate_of = |body: &str| fast.law_rates.iter().find(|rate| rate.body == body).unwrap();
    let (gel, ball) = (rate_of("gel"), rate_of("ball"));
    assert!(gel.tested_strain_rate_per_s.is_some() && gel.fraction_faster > 0.01, "{gel:?}");
    assert!(ball.tested_strain_rate_per_s.is_none() && ball.fraction_faster < 1e-12, "{ball:?}");
    assert!(fast.warnings.iter().any(|w| w.contains("faster than in any test")), "{:?}", fast.warnings);

    // Tests far faster than all of it, and tests faster than most of it: near the ball some is fast enough.
    let slow = with_range(json!({"strain_rate_per_s": [1e6, 1e7]}));
    let says = |of: &Summary, words: &str| of.warnings.iter().any(|warning| warning.contains(words));
    assert!(says(&slow, "in 100.0 % of its volume slower than in any test"), "{:?}", slow.warnings);
    let peak = gel.strain_rate_per_s;
    let partly = with_range(json!({"strain_rate_per_s": [0.5 * peak, 0.6 * peak]}));
    let gel = partly.law_rates.iter().find(|rate| rate.body == "gel").unwrap();
    assert!(gel.fraction_slower > 0.5 && gel.fraction_slower < 1.0 && gel.fraction_faster > 0.0, "{gel:?}");
    assert!(gel.fraction_slower + gel.fraction_faster < 1.0, "{gel:?}");
    assert!(says(&partly, "of its volume slower than in any test"), "{:?}", partly.warnings);
    // Without any rates nothing is compared, but with a set of the library, whose tests had some.
    assert!(left.law_rates.is_empty());
    let mut of_library = ball_on_gel([0.0, 0.0, -5.0], 1e-3);
    of_library["solver"] = json!({"error_bars": "none"});
    of_library["bodies"][1]["parts"][0]["material"] = json!({"library": "fat/engelbrektsson_2011_ogden"});
    let unknown = summary(&of_library, None);
    assert!(says(&unknown, "without rates of tests to compare with"), "{:?}", unknown.warnings);
    // Neither does its source state a range of stretch, which the run leaves small strains far enough to say.
    let of_gel = |words: &str| says(&unknown, words) && !says(&left, words) && !says(&fast, words);
    assert!(of_gel("state no range of stretch"), "{:?}", unknown.warnings);
    assert!(says(&unknown, "(fat/engelbrektsson_2011_ogden)"), "{:?}", unknown.warnings);

    let beyond = with_range(json!({"stretch": [0.999, 1.001], "limit_stretch": [0.999, 1.001]}));
    let Shown::Withheld { reason, .. } = &beyond.results else { panic!("{:?}", beyond.plain_words) };
    assert!(reason.contains("(gel) was stretched to") && reason.contains("limit 1.001"), "{reason}");
    assert!(beyond.plain_words[0].contains(reason), "{:?}", beyond.plain_words);
    let table = render_table(&beyond);
    assert!(table.contains("withheld") && !table.contains("peak force, mean"), "{table}");
    let gate = beyond.gates.iter().find(|gate| gate.name == "laws_within_limits").unwrap();
    assert!(gate.value > 0.9 && gate.value < 1.0, "{gate:?}");
}

/// The 44 mm ball at 100 m/s: principal strain above 8, J below 0.01.
/// A rigid ball of 72 mm at 60 m/s, aside, on gel of one-point elements: most of what it does is beyond the law.
fn ball_on_one_point_gel(record: &Value) -> Value {
    json!({
        "name": "ball on one-point gel", "end_time_s": 0.004,
        "bodies": [
            {
                "name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -60],
                "rigid": {"shape": {"kind": "ball", "radius_m": 0.036}, "center_m": [0.007, 0.003, 0.0361], "mass_kg": 0.16}
            },
            {
                "name": "gel", "role": "tissue", "fixed": [{"set": "z_min"}],
                "mesh": {"generator": {"kind": "block", "min_m": [-0.06, -0.06, -0.048], "max_m": [0.06, 0.06, 0], "elements": [10, 10, 8]}},
                "parts": [{
                    "part": "*", "density_kg_per_m3": 1000, "formulation": "reduced",
                    "material": {
                        "law": "neo_hookean", "c10_pa": 3e4, "bulk_modulus_pa": 5e7,
                        "valid_to": {"limit_stretch": [0.1, 4.0], "limit_jacobian": [0.1, 10.0]}
                    }
                }]
            }
        ],
        "contact": {"friction": 0.3},
        "solver": {"error_bars": "none"},
        "record": record
    })
}

#[test]
fn what_is_withheld_does_not_depend_on_what_is_recorded() {
    for record in [json!({"field_interval_s": 1e-4}), json!({"fields": [], "field_times_s": []})] {
        let summary = summary(&ball_on_one_point_gel(&record), None);
        let Shown::Withheld { reason, remedy, .. } = &summary.results else {
            panic!("{:?}", summary.plain_words)
        };
        assert!(reason.contains("limit of its law"), "{reason}");
        assert!(summary.plain_words[1] == *remedy && remedy.contains("Lower the speed"), "{remedy}");
    }
}

/// Without a declared limit nothing is withheld: a warning says whose numbers they are.
#[test]
fn beyond_the_usual_limit_of_a_law_a_warning_comes_first() {
    let mut scene = ball_on_one_point_gel(&json!({"field_interval_s": 1e-4}));
    let part = &mut scene["bodies"][1]["parts"][0];
    part["material"].as_object_mut().unwrap().remove("valid_to");
    part.as_object_mut().unwrap().remove("formulation");
    let summary = summary(&scene, None);
    let Shown::Results(results) = &summary.results else { panic!("{:?}", summary.plain_words) };
    assert!(results.tissue.as_ref().unwrap().peaks.peak_von_mises_pa.is_none());
    assert!(summary.numerics.energy_fraction_beyond_law > 0.05, "{:?}", summary.numerics);
    assert!(summary.numerics.energy_fraction_beyond_declared_limits == 0.0);
    let warns = |word: &str| summary.warnings.iter().any(|w| w.contains(word));
    assert!(
        warns("beyond the usual limit of its law") && warns("not of an intact tissue"),
        "{:?}",
        summary.warnings
    );
}

#[test]
fn a_body_with_a_velocity_waits_while_others_relax() {
    let mut scene = ball_on_gel([0.0, 0.0, -2.0], 4e-3);
    scene["solver"] = json!({"error_bars": "none"});
    let touched = |scene: &Value| {
        let summary = summary(scene, None);
        let Shown::Results(results) = &summary.results else { panic!("{:?}", summary.plain_words) };
        results.impacts[results.headline.impact.unwrap()].contact_span_s.unwrap()[0]
    };
    let at_once = touched(&scene);
    scene["gravity_m_per_s2"] = json!([0, 0, -9.81]);
    scene["dynamic_relaxation"] = json!({"duration_s": 0.02, "damping_per_s": 100});
    // The tissue sinks by some micrometres; the ball would have fallen on it.
    assert!((touched(&scene) - at_once).abs() < 0.1e-3, "{} for {at_once}", touched(&scene));
}

#[test]
fn the_44_mm_ball_has_no_peaks_where_its_laws_do_not_hold() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/flashball_thigh/scene_44mm.json");
    let mut scene: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    scene["solver"] = json!({"error_bars": "none"});
    let summary = summary(&scene, None);
    // Half a per cent of the energy is beyond the limit: forces and energies stand, peaks at points do not.
    let fraction = summary.numerics.energy_fraction_beyond_law;
    assert!((1e-3..0.02).contains(&fraction), "{fraction}");
    let Shown::Results(results) = &summary.results else { panic!("{:?}", summary.plain_words) };
    let tissue = results.tissue.as_ref().unwrap();
    assert!(tissue.peaks.peak_von_mises_pa.is_none() && tissue.peaks.peak_principal_strain.is_none());
    let warns = |word: &str| summary.warnings.iter().any(|w| w.contains(word));
    assert!(warns("limit of its law") && warns("omitted"), "{:?}", summary.warnings);
    // Stretches of 4 at most, where one-point elements that turned over had strains of 8 to 17.
    assert!(summary.law_ranges.iter().all(|law| law.stretch[1] < 5.0), "{:?}", summary.law_ranges);
}

/// Flat ends of rigid bodies pressed into gel, whose nodes they do not meet with their edges: the patch is their face.
#[test]
fn the_patch_of_a_flat_punch_is_its_face() {
    let cylinder = json!({"kind": "cylinder", "radius_m": 0.01, "half_length_m": 0.01, "axis": [0, 0, 1]});
    let cuboid = json!({"kind": "box", "half_extents_m": [0.01, 0.01, 0.01]});
    for (shape, face) in [(&cylinder, std::f64::consts::PI * 100.0), (&cuboid, 400.0)] {
        for (elements, least) in [(12, 0.6), (24, 0.8)] {
            let mut scene = ball_on_gel([0.0, 0.0, -2.0], 1e-3);
            scene["solver"] = json!({"error_bars": "none"});
            scene["bodies"][0] = json!({
                "name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -2],
                "rigid": {"shape": shape, "center_m": [0.0013, 0.0007, 0.0501], "mass_kg": 0.05}
            });
            scene["bodies"][1]["mesh"]["generator"]["elements"] = json!([elements, elements, elements / 2]);
            let patch = summary(&scene, None).values().impacts[0].patch_area_mm2.value;
            // The surface under it stretches and warps a little.
            assert!(patch > least * face && patch < 1.03 * face, "{elements}: {patch} of {face} mm²");
        }
    }
}

/// A long block, hit at one end: its far elements are long, and each step carries something one of them further.
#[test]
fn stress_that_no_wave_can_have_brought_counts_nowhere() {
    let mut scene = ball_on_gel([0.0, 0.0, -5.0], 1e-3);
    scene["solver"] = json!({"error_bars": "none"});
    scene["bodies"][1]["mesh"]["generator"] = json!({"kind": "block", "min_m": [-0.03, -0.03, 0], "max_m": [0.37, 0.03, 0.04], "elements": [10, 8, 6]});
    scene["measures"]["stress_thresholds_pa"] = json!([1e-6, 1000.0]);
    let summary = summary(&scene, None);
    let [tiny, real] = &summary.values().tissue.as_ref().unwrap().significant_stress[..] else { panic!() };
    let first = summary.values().impacts[0].contact_span_s.unwrap()[0];
    // The fastest wave: sqrt((K + 4/3 G)/ρ), G = 2 C10, and the speed of the impact; then a step, the patch and an element.
    let farthest = (((1e6 + 4.0 / 3.0 * 6e4) / 1e3_f64).sqrt() + 5.0) * (1e-3 - first);
    let slack = 0.02
        + (0.04f64 * 0.0075 * 0.04 / 6.0).cbrt()
        + 5.0 * summary.numerics.smallest_step_s.unwrap() * 38.0;
    let most = (0.03 + farthest + slack) * 0.06 * 0.04 * 1e9;
    assert!(tiny.numerical_volume_mm3 > 0.0, "{tiny:?}");
    assert!(
        tiny.volume_mm3.value < most && tiny.volume_mm3.value > 0.0,
        "{} of {most}",
        tiny.volume_mm3.value
    );
    assert!(real.numerical_volume_mm3 < tiny.numerical_volume_mm3, "{real:?}");
    assert!(
        summary.warnings.iter().any(|w| w.contains("where no wave from the contact can have arrived")),
        "{:?}",
        summary.warnings
    );
}

#[test]
fn the_force_is_averaged_over_a_fraction_of_the_contact_and_a_short_window_is_reported() {
    let summary_of = |measures: Value| {
        let mut scene = ball_on_gel([0.0, 0.0, -5.0], 2e-2);
        scene["solver"] = json!({"error_bars": "none"});
        scene["measures"] = measures;
        summary(&scene, None)
    };
    let by_default = summary_of(json!({"skin_set": "z_max"}));
    let impact = &by_default.values().impacts[0];
    let (window, duration) = (impact.force_window_s.unwrap(), impact.contact_duration_s.value);
    assert!(impact.contact_ended && window >= duration / 10.0 * (1.0 - 1e-12), "{window} of {duration}");
    assert!(
        impact.force_average.contains("10 steps") || impact.force_average.contains("1/10"),
        "{}",
        impact.force_average
    );
    assert!(render_table(&by_default).contains(&impact.force_average));
    assert!(impact.peak_force_n.value < impact.peak_step_force_n.value);
    // A wider window flattens the peak, the same window gives the same force.
    let same = summary_of(json!({"skin_set": "z_max", "force_window_s": window}));
    let requested = &same.values().impacts[0];
    assert!((requested.peak_force_n.value / impact.peak_force_n.value - 1.0).abs() < 1e-9);
    assert!((requested.patch_area_mm2.value / impact.patch_area_mm2.value - 1.0).abs() < 1e-9);
    let short = summary_of(json!({"skin_set": "z_max", "force_window_s": 1e-6}));
    assert!(short.warnings.iter().any(|w| w.contains("less than two steps")), "{:?}", short.warnings);
    // A class far above what the contact has in it changes little, and is named.
    let filtered = summary_of(json!({"skin_set": "z_max", "force_filter": "cfc_1000"}));
    let by_class = &filtered.values().impacts[0];
    assert_eq!((by_class.force_window_s, by_class.force_filter.as_deref()), (None, Some("CFC 1000")));
    assert!(
        (by_class.peak_force_n.value / impact.peak_force_n.value - 1.0).abs() < 0.2,
        "{}",
        by_class.peak_force_n.value
    );
}

#[test]
fn a_stiff_ball_that_chatters_is_in_one_contact() {
    // The same ball, rigid and as a mesh a thousand times stiffer than the gel: its mesh bounces from the nodes that it hits.
    let summary_of = |is_rigid: bool| {
        let mut scene = ball_on_gel([0.0, 0.0, -5.0], 1e-2);
        scene["solver"] = json!({"error_bars": "none"});
        scene["bodies"][0]["mesh"]["generator"]["center_m"] = json!([0, 0, 0.0502]);
        scene["bodies"][0]["parts"][0]["density_kg_per_m3"] = json!(8000);
        let stiff = json!({"law": "neo_hookean", "c10_pa": 1.5e8, "bulk_modulus_pa": 5e8});
        scene["bodies"][0]["parts"][0]["material"] = stiff;
        if is_rigid {
            let ball = scene["bodies"][0].as_object_mut().unwrap();
            ball.retain(|key, _| !["mesh", "parts"].contains(&key.as_str()));
            let rigid = json!({"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [0, 0, 0.0502], "density_kg_per_m3": 8000});
            ball.insert("rigid".into(), rigid);
        }
        summary(&scene, None)
    };
    let [rigid, mesh] = [true, false].map(|is_rigid| summary_of(is_rigid).values().impacts[0].clone());
    let ratio = mesh.contact_duration_s.value / rigid.contact_duration_s.value;
    println!("durations {:e} and {:e} s", rigid.contact_duration_s.value, mesh.contact_duration_s.value);
    assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
    let ratio = mesh.peak_force_n.value / rigid.peak_force_n.value;
    assert!((ratio - 1.0).abs() < 0.5, "{ratio}");
}

#[test]
fn what_rigid_bodies_lose_to_each_other_is_reported() {
    let ball = |name: &str, x: f64, speed: f64| {
        json!({"name": name, "velocity_m_per_s": [speed, 0, 0],
               "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [x, 0, 0], "mass_kg": 0.1}})
    };
    let scene = json!({
        "name": "two balls", "end_time_s": 1e-3, "bodies": [ball("a", 0.0, 10.0), ball("b", 0.021, 0.0)],
        "integrator": {"kind": "explicit", "max_step_s": 1e-5}, "record": {"fields": [], "field_times_s": []}
    });
    let summary = summary(&scene, None);
    // ½ m v² of the relative motion, with the reduced mass: all the energy in the frame of the centre of mass.
    let lost = summary.numerics.rigid_impact_dissipation_j;
    assert!((lost - 0.25 * 0.1 * 100.0).abs() < 1e-9, "{lost}");
    assert!(
        summary.warnings.iter().any(|w| w.contains("do not rebound") && w.contains("100.0 %")),
        "{:?}",
        summary.warnings
    );
    let table = render_table(&summary);
    let row = table.lines().find(|line| line.contains("lost in rigid–rigid impacts")).unwrap();
    assert!(row.contains(" 2.500 J"), "{row}");
}

#[test]
fn error_bars_of_a_force_compare_the_same_window() {
    let summary = summary(&ball_on_gel([0.0, 0.0, -5.0], 5e-3), None);
    let impact = &summary.values().impacts[0];
    // The coarse mesh has steps twice as long, and by itself would take a window twice as wide.
    let ErrorEstimate::Estimated(error) = &impact.peak_force_n.error else {
        panic!("{}", summary.error_bars)
    };
    assert!(error.total.is_finite() && error.mesh > 0.0, "{error:?}");
}
