//! A scene that is run to an accuracy: finer and finer meshes, until the error bars are as small as requested, and hold.

use crate::record::{assert_at_most, assert_close};
use contuse::measure::Summary;
use contuse::measure::summary::{ErrorEstimate, Shown};
use contuse::plan::compile;
use contuse::scene::{Budget, NoFiles, load};
use contuse::study::{RunRequest, run_scene};
use serde_json::{Value, json};

/// A bar of 1 m² that hits another one of its like at 0.01 m/s: all of its energy passes on, 2 L / c = 20/30 s after they touch.
fn two_bars(elements: u32, accuracy: &Value) -> Value {
    let bar = |name: &str, role: &str, low: f64, speed: f64| {
        json!({
            "name": name, "role": role, "velocity_m_per_s": [0, 0, speed],
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, low], "max_m": [1, 1, low + 10.0],
                     "elements": [1, 1, elements]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1,
                       "material": {"law": "coupled_neo_hookean", "mu_pa": 450, "lambda_pa": 0}}]
        })
    };
    json!({
        "name": "two bars", "end_time_s": 1.0,
        "bodies": [bar("striker", "projectile", 10.001, -0.01), bar("target", "tissue", 0.0, 0.0)],
        "contact": {"pairs": [{"between": ["striker", "target"], "friction": 0}]},
        "integrator": {"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "measures": {"force_window_s": 0.1},
        "accuracy": accuracy,
        "record": {"fields": [], "field_times_s": []}
    })
}

fn summary_of(document: &Value) -> Summary {
    let loaded = load(document.to_string().as_bytes(), &NoFiles, &Budget::COMMAND_LINE).unwrap();
    let request = RunRequest {
        scene: &loaded.scene,
        sinks: Vec::new(),
        also: None,
        threads: 1,
        interrupt: &|| None,
        progress: &mut |_| {},
    };
    run_scene(request).unwrap().summary
}

/// ½ ρ A L v².
const ENERGY: f64 = 0.5 * 10.0 * 1e-4;
/// ρ A L v.
const IMPULSE: f64 = 10.0 * 0.01;

#[test]
fn numbers_are_as_exact_as_asked_and_their_bars_hold() {
    let of = ["peak_force", "impulse", "energy_given"];
    let summary = summary_of(&two_bars(8, &json!({"relative": 0.03, "of": of, "time_budget_s": 600})));
    let accuracy = summary.accuracy.clone().unwrap();
    assert!(accuracy.reached && accuracy.numbers.len() == 3, "{accuracy:?}");
    assert!(
        accuracy.numbers.iter().all(|of| of.relative.is_some_and(|relative| relative <= 0.03)),
        "{accuracy:?}"
    );
    // ½ ρ c v A, the mean force while the wave is on its way.
    let exact = [0.5 * 30.0 * 0.01, IMPULSE, ENERGY];
    let (impact, tissue) = (&summary.values().impacts[0], summary.values().tissue.as_ref().unwrap());
    let found = [&impact.peak_force_n, &impact.impulse_n_s, &tissue.energy_given_j];
    for ((quantity, exact), of) in found.into_iter().zip(exact).zip(&accuracy.numbers) {
        assert_at_most(
            (quantity.value / exact - 1.0).abs(),
            of.relative.unwrap(),
            contuse::measure::QuantityOfInterest::from(of.number).title(),
        );
    }
}

#[test]
fn a_time_that_is_over_leaves_the_first_mesh_and_says_so() {
    let summary =
        summary_of(&two_bars(2000, &json!({"relative": 0.01, "of": ["impulse"], "time_budget_s": 1e-9})));
    let accuracy = summary.accuracy.as_ref().unwrap();
    assert!(!accuracy.reached && accuracy.mesh_factor < 1.0, "{accuracy:?}");
    assert_eq!(accuracy.numbers[0].relative, None);
    assert!(accuracy.words().contains("NOT reached"), "{}", accuracy.words());
}

/// Where the estimates count, the number of meshes depends on the scene alone.
#[test]
fn estimated_run_times_choose_the_same_mesh_on_every_machine() {
    let estimate_s = |elements: u32| {
        let document = two_bars(elements, &Value::Null).to_string();
        let scene = load(document.as_bytes(), &NoFiles, &Budget::COMMAND_LINE).unwrap().scene;
        compile(&scene).unwrap().report.expected_run_time_s
    };
    // A quarter, half and the whole of the elements fit, twice of them in every direction do not.
    let budget_s = estimate_s(10) + estimate_s(20) + 1.5 * estimate_s(40);
    let accuracy =
        json!({"relative": 1e-9, "of": ["impulse"], "time_budget_s": budget_s, "reproducible": true});
    let summary = summary_of(&two_bars(40, &accuracy));
    let reached = summary.accuracy.unwrap();
    assert!(!reached.reached && (reached.mesh_factor - 1.0).abs() < 1e-12, "{reached:?}");
}

/// The bars as solids with a shear modulus of 3 MPa, and as many times that as bulk modulus.
fn solid_bars(elements: u32, ratio: f64, accuracy: &Value) -> Value {
    let mut document = two_bars(elements, accuracy);
    for body in document["bodies"].as_array_mut().unwrap() {
        let part = &mut body["parts"][0];
        part["density_kg_per_m3"] = json!(1e4);
        part["material"] = json!({"law": "neo_hookean", "c10_pa": 1.5e6, "bulk_modulus_pa": ratio * 3e6});
    }
    document
}

/// Bars of an incompressible solid have E = 3 G, whatever the bulk modulus, and lower ones need fewer steps.
#[test]
fn bulk_moduli_are_lowered_as_far_as_the_accuracy_allows() {
    let of_bars = |lower: bool, ratio: f64, of: &[&str]| {
        let accuracy = json!({"relative": 0.1, "of": of, "time_budget_s": 600, "lower_bulk_modulus": lower});
        summary_of(&solid_bars(8, ratio, &accuracy))
    };
    let numbers = |summary: &Summary| {
        let tissue = summary.values().tissue.clone().unwrap();
        [summary.values().impacts[0].impulse_n_s.clone(), tissue.energy_given_j]
    };
    let [given, lowered] = [false, true].map(|lower| of_bars(lower, 1e4, &["impulse", "energy_given"]));
    assert!(lowered.error_bars.contains("bulk moduli × 0.004 on the coarsest mesh change impulse by"));
    assert!(lowered.steps < given.steps / 8, "{} steps instead of {}", lowered.steps, given.steps);
    for (given, lowered) in numbers(&given).iter().zip(&numbers(&lowered)) {
        let ErrorEstimate::Estimated(error) = lowered.error else { panic!("{lowered:?}") };
        assert!(error.bulk_modulus > 0.0 && error.bulk_modulus < 0.1 / 3.0 * lowered.value, "{error:?}");
        assert_at_most((lowered.value - given.value).abs(), error.total, "the change");
    }
    // None changes the force by less than a third of a thousandth: those of the scene stand, with their own effect, 1 − √(E/E of water).
    let accuracy = json!({
        "relative": 1e-3, "of": ["peak_force"], "time_budget_s": 1, "reproducible": true, "lower_bulk_modulus": true
    });
    let summary = summary_of(&solid_bars(8, 6.0, &accuracy));
    assert!(summary.error_bars.contains("bulk moduli not lowered: those × 0.250"), "{}", summary.error_bars);
    let ErrorEstimate::Estimated(error) = summary.values().impacts[0].peak_force_n.error else {
        panic!("no error bar")
    };
    assert!(error.bulk_modulus > 0.0, "{error:?}");
    // Foam keeps its modulus.
    let foam = of_bars(true, 3.0, &["peak_force"]);
    assert!(foam.error_bars.contains("no part is meant to keep its volume"), "{}", foam.error_bars);
    let mut mixed = solid_bars(
        8,
        1e4,
        &json!({
            "relative": 0.1, "of": ["impulse"], "time_budget_s": 600, "lower_bulk_modulus": true
        }),
    );
    mixed["bodies"][0]["parts"][0]["material"]["bulk_modulus_pa"] = json!(9e6);
    let summary = summary_of(&mixed);
    assert!(summary.error_bars.contains("bulk moduli × 0."), "{}", summary.error_bars);
}

/// A rigid ball on a block of gel of a shear modulus of 0.1 MPa.
fn ball_on_gel(elements: u32, bulk_modulus_pa: f64) -> Value {
    json!({
        "name": "ball on gel", "end_time_s": 2e-3,
        "bodies": [
            {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -5],
             "rigid": {"shape": {"kind": "ball", "radius_m": 0.02}, "center_m": [0, 0, 0.0701], "mass_kg": 0.05}},
            {"name": "gel", "role": "tissue", "fixed": [{"set": "z_min"}],
             "mesh": {"generator": {"kind": "block", "min_m": [-0.05, -0.05, 0], "max_m": [0.05, 0.05, 0.05],
                      "elements": [elements, elements, elements]}},
             "parts": [{"part": "block", "density_kg_per_m3": 1000, "shear_viscosity_pa_s": 3,
                        "material": {"law": "neo_hookean", "c10_pa": 5e4, "bulk_modulus_pa": bulk_modulus_pa}}]}
        ],
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn bulk_moduli_below_that_of_water_are_compared_with_it() {
    // The coarsest mesh has half the numbers of elements.
    let impulse = |bulk_modulus_pa: f64| {
        let coarse = ball_on_gel(6, bulk_modulus_pa);
        summary_of(&coarse).values().impacts[0].impulse_n_s.value
    };
    let with_water = impulse(2.2e9);
    for (bulk_modulus_pa, relative) in [(6e5, 0.05), (2e7, 0.1), (2.2e9, 0.1)] {
        let mut document = ball_on_gel(12, bulk_modulus_pa);
        document["accuracy"] = json!({"relative": relative, "of": ["impulse"], "time_budget_s": 1e9});
        let summary = summary_of(&document);
        let change = summary.error_bars.split_once("changes on the coarsest mesh ");
        assert_eq!(change.is_some(), bulk_modulus_pa < 2.2e9, "{}", summary.error_bars);
        let ErrorEstimate::Estimated(error) = summary.values().impacts[0].impulse_n_s.error else {
            panic!("no error bar")
        };
        assert!(error.bulk_modulus == 0.0, "{error:?}");
        let Some((_, change)) = change else { continue };
        let (_, change) = change.split_once("impulse by ").unwrap();
        let percent: f64 = change.split_once(" %").unwrap().0.parse().unwrap();
        let expected = (impulse(bulk_modulus_pa) / with_water - 1.0).abs();
        // As printed, with a digit after the point.
        assert_at_most((percent - 100.0 * expected).abs(), 0.06, "change of the impulse by the bulk modulus");
        let warns = summary.warnings.iter().any(|warning| warning.contains("in place of that of water"));
        assert_eq!(warns, expected > relative, "{:?}", summary.warnings);
    }
}

/// What contact nodes lose belongs half to either bar, and all of it comes from the striker, which is left at rest.
#[test]
fn the_energy_given_has_what_absorbed_energy_lacks_by_contact_nodes() {
    let summary =
        summary_of(&two_bars(40, &json!({"relative": 1.0, "of": ["impulse"], "time_budget_s": 1e-9})));
    let tissue = summary.values().tissue.as_ref().unwrap();
    let lost = summary.values().impacts[0].numerical_contact_dissipation_j.value;
    assert_close(tissue.energy_given_j.value, tissue.absorbed_energy_j.value + lost, 1e-12, "the sum");
    let error = |energy: f64| (energy / ENERGY - 1.0).abs();
    // What is left is the striker's own vibration.
    assert_at_most(
        error(tissue.energy_given_j.value),
        0.5 * error(tissue.absorbed_energy_j.value),
        "its error",
    );
}

/// A light box on a soft block whose first meshes lose more than half of the energy in contact: a mesh of four times the numbers of elements
/// passes that check.
#[test]
fn a_failed_check_that_comes_down_leads_to_finer_meshes() {
    let summary = summary_of(&json!({
        "name": "light box", "end_time_s": 2.9e-3,
        "bodies": [
            {"name": "box", "role": "projectile", "velocity_m_per_s": [0, 0, -25],
             "rigid": {"shape": {"kind": "box", "half_extents_m": [0.02, 0.012, 0.006]},
                       "center_m": [-0.0048, -0.0049, 0.0746], "density_kg_per_m3": 300}},
            {"name": "gel", "role": "tissue", "fixed": [{"set": "z_min"}],
             "mesh": {"generator": {"kind": "block", "min_m": [-0.045, -0.045, 0], "max_m": [0.045, 0.045, 0.05],
                      "elements": [5, 6, 4]}},
             "parts": [{"part": "block", "density_kg_per_m3": 1000,
                        "material": {"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 5e7}}]}
        ],
        "contact": {"friction": 0},
        "accuracy": {"time_budget_s": 50, "reproducible": true},
        "record": {"fields": [], "field_times_s": []}
    }));
    let factor = summary.accuracy.as_ref().map(|accuracy| accuracy.mesh_factor);
    assert!(
        matches!(summary.results, Shown::Results(_)) && factor > Some(2.0),
        "{factor:?} {:?}",
        summary.excess()
    );
}
