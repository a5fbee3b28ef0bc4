//! Parameters from curves: known ones from noisy curves, how often intervals contain them, closed forms, and sets of the library from
//! the numbers of their sources.

use contuse::mechanics::material::{Path, eval_path};
use contuse::scene::material_fit::FitQuestion;
use contuse::scene::materials::MaterialDocument;
use contuse::scene::materials::library::find;
use contuse::study::material_fit::{FitAnswer, fit};
use serde_json::{Value, json};
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/material_fit")
}

fn fitted(question: &Value) -> FitAnswer {
    let file = |name: &str| std::fs::read(folder().join(name));
    let (question, _) = FitQuestion::read(question.to_string().as_bytes(), &file).unwrap();
    fit(&question).unwrap()
}

/// The question of a file.
fn of_file(name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder().join(name)).unwrap()).unwrap()
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found} and not {expected}");
}

/// SplitMix64 and Box–Muller: independent normal numbers.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
    fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Nominal stress of a law at values of a path.
fn curve(material: &Value, path: Path, values: &[f64]) -> Vec<[f64; 2]> {
    let document: MaterialDocument = serde_json::from_value(material.clone()).unwrap();
    let law = document.to_material().unwrap();
    let component = if path == Path::SimpleShear { (0, 1) } else { (0, 0) };
    let points = eval_path(&law, law.fibre_directions(), path, values).unwrap();
    points.iter().map(|p| [p.value, p.stress.P[component]]).collect()
}

fn spaced(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| from + (to - from) * f64::from(i) / f64::from(count - 1)).collect()
}

fn noisy(curve: &[[f64; 2]], deviation: f64, normal: &mut Normal) -> Vec<[f64; 2]> {
    curve.iter().map(|[x, y]| [*x, y + deviation * normal.next()]).collect()
}

fn ogden(mu: [f64; 2], alpha: [f64; 2]) -> Value {
    json!({"law": "ogden", "bulk_modulus_pa": 2e7, "terms": {"mu_alpha": [
        {"mu_pa": mu[0], "alpha": alpha[0]}, {"mu_pa": mu[1], "alpha": alpha[1]}]}})
}

#[test]
fn known_parameters_come_back_from_three_exact_curves() {
    let truth = ogden([6e3, -1.5e3], [2.5, -3.0]);
    let tests = [
        ("uniaxial", Path::Uniaxial, [0.6, 2.0]),
        ("equibiaxial", Path::Equibiaxial, [1.02, 1.5]),
        ("shear", Path::SimpleShear, [0.0, 0.8]),
    ]
    .map(|(kind, path, [from, to])| json!({"kind": kind, "points": curve(&truth, path, &spaced(from, to, 15))}));
    let term = |i: u32, name: &str| format!("/material/terms/mu_alpha/{i}/{name}");
    let free = [term(0, "mu_pa"), term(0, "alpha"), term(1, "mu_pa"), term(1, "alpha")];
    let answer = fitted(&json!({"material": ogden([3e3, -3e3], [2.0, -2.0]), "free": free, "tests": tests}));
    assert!(answer.has_converged);
    for (parameter, exact) in answer.parameters.iter().zip([6e3, 2.5, -1.5e3, -3.0]) {
        close(parameter.value, exact, 1e-6, &parameter.pointer);
    }
    // Equibiaxial stretches of 1.5 are J/1.5² across.
    let [from, to] = answer.stretch_range.unwrap();
    let law = serde_json::from_value::<MaterialDocument>(truth).unwrap().to_material().unwrap();
    let across = eval_path(&law, &[], Path::Equibiaxial, &[1.5]).unwrap()[0].F[(2, 2)];
    close(from, across, 1e-6, "smallest stretch");
    close(to, 2.0, 1e-12, "largest stretch");
    assert_eq!(answer.constants.material.valid_to().stretch, answer.stretch_range);
}

/// C10 of least squares is Σ P f / Σ f², with P = 2 C10 f; its variance σ²/Σ f² (in units of 2).
#[test]
fn neo_hookean_is_that_of_linear_least_squares() {
    let shear = spaced(0.1, 0.5, 9);
    let mut normal = Normal(5);
    // In simple shear P = 2 C10 γ exactly, at any bulk modulus: J = 1.
    let points: Vec<[f64; 2]> = shear.iter().map(|g| [*g, 2.0 * 4e3 * g + 50.0 * normal.next()]).collect();
    let law = json!({"law": "neo_hookean", "c10_pa": 1e3, "bulk_modulus_pa": 5e7});
    let answer = fitted(
        &json!({"material": law, "free": ["/material/c10_pa"], "tests": [{"kind": "shear", "points": points}]}),
    );
    let squares: f64 = points.iter().map(|p| 4.0 * p[0] * p[0]).sum();
    let exact = points.iter().map(|p| 2.0 * p[0] * p[1]).sum::<f64>() / squares;
    let rest: f64 = points.iter().map(|p| (p[1] - 2.0 * exact * p[0]).powi(2)).sum();
    let error = (rest / 8.0 / squares).sqrt();
    let found = &answer.parameters[0];
    close(found.value, exact, 1e-4, "C10");
    close(found.standard_error.unwrap(), error, 1e-3, "standard error");
    // t(0.975, 8) = 2.306; the interval is that of the logarithm.
    let [low, high] = found.interval.unwrap();
    close(high / found.value, (2.306 * error / exact).exp(), 1e-5, "high end");
    close(found.value / low, (2.306 * error / exact).exp(), 1e-5, "low end");
    close(answer.tests[0].rms_pa, (rest / 9.0).sqrt(), 1e-3, "RMS error");
    let mean = points.iter().map(|p| p[1]).sum::<f64>() / 9.0;
    let spread: f64 = points.iter().map(|p| (p[1] - mean).powi(2)).sum();
    close(1.0 - answer.tests[0].r_squared.unwrap(), rest / spread, 1e-3, "1 − R²");
}

/// 200 seeded repetitions of a Yeoh fit: 190 ± 3.1 intervals of each parameter are expected to contain it; within three deviations.
#[test]
fn intervals_contain_the_truth_as_often_as_they_say() {
    const REPETITIONS: u64 = 200;
    let truth = json!({"law": "yeoh", "c10_pa": 8e3, "c20_pa": 500.0, "c30_pa": 0.0, "bulk_modulus_pa": 2e7});
    let exact = curve(&truth, Path::Uniaxial, &spaced(1.1, 1.9, 10));
    let mut contained = [0_u64; 2];
    for seed in 0..REPETITIONS {
        let points = noisy(&exact, 400.0, &mut Normal(1000 + seed));
        let start =
            json!({"law": "yeoh", "c10_pa": 3e3, "c20_pa": 0.0, "c30_pa": 0.0, "bulk_modulus_pa": 2e7});
        let answer = fitted(&json!({"material": start, "free": ["/material/c10_pa", "/material/c20_pa"],
            "tests": [{"kind": "uniaxial", "points": points}]}));
        assert!(answer.has_converged);
        for ((count, parameter), exact) in contained.iter_mut().zip(&answer.parameters).zip([8e3, 500.0]) {
            let [low, high] = parameter.interval.unwrap();
            *count += u64::from(low <= exact && exact <= high);
        }
    }
    println!("of {REPETITIONS} intervals contain C10 {} and C20 {}", contained[0], contained[1]);
    assert!(contained.iter().all(|count| (181..=199).contains(count)), "{contained:?}");
}

#[test]
fn relaxation_of_a_card_has_the_series_of_the_library() {
    let answer = fitted(&of_file("fat_relaxation.json"));
    let set = find("fat/engelbrektsson_2011_ogden").unwrap();
    let branch = set.prony_series.as_ref().unwrap().branches[0];
    let found = answer.constants.prony_series.unwrap().branches[0];
    close(found.relative_modulus, branch.relative_modulus, 1e-6, "relative modulus");
    close(found.relaxation_time_s, branch.relaxation_time_s, 1e-6, "relaxation time");
    close(answer.parameters[0].value, 30.0, 1e-6, "mu");
}

/// Two branches and instantaneous moduli: G(t) = G₀ (1 − Σ g (1 − e^(−t/τ))).
#[test]
fn a_series_relative_to_sudden_loading_comes_back() {
    let exact = |t: f64| 9e3 * (1.0 - 0.5 * (1.0 - (-t / 2e-3).exp()) - 0.3 * (1.0 - (-t / 0.1).exp()));
    let points: Vec<[f64; 2]> =
        (0..40).map(|i| 1e-4 * 10_f64.powf(f64::from(i) / 10.0)).map(|t| [t, exact(t)]).collect();
    let answer = fitted(&json!({
        "material": {"law": "neo_hookean", "c10_pa": 2e3, "bulk_modulus_pa": 5e7},
        "prony_series": {"moduli": "instantaneous", "branches": [
            {"relative_modulus": 0.3, "relaxation_time_s": 1e-3}, {"relative_modulus": 0.3, "relaxation_time_s": 1.0}]},
        "free": ["/material/c10_pa",
            "/prony_series/branches/0/relative_modulus", "/prony_series/branches/0/relaxation_time_s",
            "/prony_series/branches/1/relative_modulus", "/prony_series/branches/1/relaxation_time_s"],
        "tests": [{"kind": "relaxation", "points": points}]
    }));
    close(answer.parameters[0].value, 4.5e3, 1e-6, "C10");
    // The order of the branches is arbitrary.
    let mut branches = answer.constants.prony_series.unwrap().branches;
    branches.sort_by(|a, b| a.relaxation_time_s.total_cmp(&b.relaxation_time_s));
    for (branch, [g, tau]) in branches.iter().zip([[0.5, 2e-3], [0.3, 0.1]]) {
        close(branch.relative_modulus, g, 1e-6, "relative modulus");
        close(branch.relaxation_time_s, tau, 1e-6, "relaxation time");
    }
}

/// From the numbers of the sources to the numbers of the library, whose fits are closed forms of the incompressible solid: the bulk
/// modulus is so large here that it leaves no trace in them.
#[test]
fn sets_of_the_library_come_out_of_the_numbers_of_their_sources() {
    let law = |name: &str| serde_json::to_value(&find(name).unwrap().material).unwrap();
    for (file, name) in [
        ("skin_across.json", "skin/manschot_1986_across"),
        ("skin_to_failure.json", "skin/manschot_1986_to_failure"),
        ("muscle_at_220_per_s.json", "muscle/takaza_2012_220_per_s"),
        ("ecoflex_00_30.json", "silicone/ecoflex_00_30_marechal_2020"),
    ] {
        let library = json!({"material": law(name)});
        let mut question = of_file(file);
        question["material"]["bulk_modulus_pa"] = json!(1e11);
        for parameter in fitted(&question).parameters {
            let expected = library.pointer(&parameter.pointer).unwrap().as_f64().unwrap();
            close(parameter.value, expected, 1e-4, &format!("{name} {}", parameter.pointer));
        }
    }
}

fn codes(answer: &FitAnswer) -> Vec<&str> {
    answer.problems.iter().map(|p| p.code.as_ref()).collect()
}

#[test]
fn what_curves_do_not_determine_is_reported() {
    // Mooney and Rivlin's two constants in shear: P = 2 (C10 + C01) γ.
    let truth = json!({"law": "mooney_rivlin", "c10_pa": 3e3, "c01_pa": 1e3, "bulk_modulus_pa": 5e7});
    let mut normal = Normal(9);
    let points = noisy(&curve(&truth, Path::SimpleShear, &spaced(0.05, 0.5, 12)), 20.0, &mut normal);
    let free = ["/material/c10_pa", "/material/c01_pa"];
    let question = json!({"material": truth, "free": free, "tests": [{"kind": "shear", "points": points}]});
    let answer = fitted(&question);
    assert!(codes(&answer).contains(&"nearly_dependent"), "{:#?}", answer.problems);
    assert!(answer.problems.iter().any(|p| p.message.contains("c10_pa, /material/c01_pa")));
    // Another kind of test separates them.
    let more = noisy(&curve(&truth, Path::Equibiaxial, &spaced(1.1, 1.8, 12)), 20.0, &mut normal);
    let mut both = question.clone();
    both["tests"].as_array_mut().unwrap().push(json!({"kind": "equibiaxial", "points": more}));
    assert!(!codes(&fitted(&both)).contains(&"nearly_dependent"));
    // As many points as parameters.
    let exact = json!({"material": truth, "free": ["/material/c10_pa"], "tests": [{"kind": "shear", "points": [[0.2, 1500.0]]}]});
    let answer = fitted(&exact);
    assert!(codes(&answer).contains(&"no_degrees_of_freedom") && answer.parameters[0].interval.is_none());
    // A law that does not follow the curve.
    let stiff = json!({"law": "demiray", "mu_pa": 3e3, "b": 1.0, "bulk_modulus_pa": 5e7});
    let points = curve(&stiff, Path::Uniaxial, &spaced(1.05, 1.8, 20));
    let soft = json!({"law": "neo_hookean", "c10_pa": 1e3, "bulk_modulus_pa": 5e7});
    let answer = fitted(
        &json!({"material": soft, "free": ["/material/c10_pa"], "tests": [{"kind": "uniaxial", "points": points}]}),
    );
    assert!(codes(&answer).contains(&"correlated_errors"), "{:#?}", answer.problems);
}

#[test]
fn every_error_of_a_question_is_reported_at_once() {
    let question = json!({
        "material": {"law": "yeoh", "c10_pa": -1e3, "c20_pa": 0, "c30_pa": 0, "bulk_modulus_pa": 5e7},
        "free": ["/material/c1_pa", "/material/c20_pa", "/material/c20_pa", "/prony_series/branches/0/relaxation_time_s"],
        "tests": [
            {"kind": "uniaxial", "points": [[-1.1, 200.0]]},
            {"kind": "relaxation", "points": [[-1.0, 5.0]]},
            {"kind": "shear"},
            {"kind": "equibiaxial", "csv": "no_such_file.csv"},
            {"kind": "shear", "csv": "skin_across.csv"}
        ]
    });
    let file = |name: &str| std::fs::read(folder().join(name));
    let problems = FitQuestion::read(question.to_string().as_bytes(), &file).unwrap_err();
    let found = |pointer: &str, code: &str| problems.0.iter().any(|p| p.pointer == pointer && p.code == code);
    for (pointer, code) in [
        ("/material/c10_pa", "not_positive"),
        ("/free/0", "unknown_parameter"),
        ("/free/2", "repeated"),
        ("/free/3", "unknown_parameter"),
        ("/tests/0/points/0", "out_of_range"),
        ("/tests/1/kind", "missing_field"),
        ("/tests/1/points/0", "out_of_range"),
        ("/tests/2", "no_points"),
        ("/tests/3/csv", "unreadable_file"),
        ("/tests/4/csv", "wrong_header"),
    ] {
        assert!(found(pointer, code), "{code} at {pointer} in {:#?}", problems.0);
    }
    assert!(problems.0.iter().all(|p| !p.limit.is_empty() && !p.remedy.is_empty()), "{:#?}", problems.0);
}
