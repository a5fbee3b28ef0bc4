//! Invariance: a free block of tissue struck by a hollow rubber ball, with a common velocity, rotated by an odd angle about
//! a skew axis, and mirrored, has the same summary.
//!
//! Contact amplifies rounding, since nodes come into contact slightly earlier or later. The scene ends while the growth is far below 10⁻⁶.

use crate::rig::{assert_at_most, plan, small_ball_on_block};
use contuse::measure::{Measures, MeasuringRecorder};
use contuse::mechanics::tensor::Vec3;
use contuse::step::{Ending, Interrupt, RunOptions, State, run_from};
use nalgebra::{Rotation3, Unit};
use serde_json::{Value, json};

/// Nothing holds the tissue, so that it may fly along.
fn scene(velocity: [f64; 3]) -> Value {
    let mut scene = small_ball_on_block([2, 1], [4, 4, 2], velocity, 4e-4);
    scene["bodies"][0]["role"] = json!("projectile");
    let block = scene["bodies"][1].as_object_mut().unwrap();
    block.insert("role".into(), json!("tissue"));
    block.remove("fixed");
    scene["contact"]["tolerance"] = json!(1e-12);
    scene
}

fn flying(mut scene: Value, common: [f64; 3]) -> Value {
    for body in scene["bodies"].as_array_mut().unwrap() {
        let own: [f64; 3] = serde_json::from_value(body["velocity_m_per_s"].clone()).unwrap_or_default();
        body["velocity_m_per_s"] = json!(std::array::from_fn::<f64, 3, _>(|i| own[i] + common[i]));
    }
    scene
}

/// The absorbed energy, the energy scale, the steps, impulse and friction, and what the summary says of pairs and tissue.
fn numbers(scene: &Value) -> Vec<(String, f64)> {
    let plan = plan(scene);
    let mut measuring = MeasuringRecorder::new(Measures::new());
    let options = RunOptions { threads: 1, interrupt: &|| None::<Interrupt> };
    let (outcome, _) = run_from(&plan, State::new(&plan), &options, &mut [&mut measuring]);
    assert_eq!(outcome.ending, Ending::Finished, "{outcome:#?}");
    let measures = measuring.measures();
    let summary = serde_json::to_value(measuring.summary(&plan, &outcome)).unwrap();
    let absorbed = summary["results"]["tissue"]["absorbed_energy_j"]["value"].as_f64().unwrap();
    let mut all = vec![("absorbed".to_owned(), absorbed), ("scale".to_owned(), measures.energy.scale_j)];
    all.push(("steps".to_owned(), outcome.steps as f64));
    let impulse = Vec3::from(measures.energy.pairs[0].impulse_n_s).norm();
    all.push(("impulse".to_owned(), impulse));
    all.push(("friction".to_owned(), measures.energy.pairs[0].friction_j));
    for name in ["tissue", "pairs"] {
        collect(name, &summary["results"][name], &mut all);
    }
    assert!(all.len() > 10, "{summary:#}");
    all
}

/// The numbers that are no place and no component of a vector.
fn collect(name: &str, value: &Value, all: &mut Vec<(String, f64)>) {
    match value {
        Value::Number(number) => all.push((name.to_owned(), number.as_f64().unwrap())),
        Value::Object(object) => {
            let turns = |key: &str| {
                ["position", "direction", "impulse", "axis", "place"].iter().any(|w| key.contains(w))
            };
            object
                .iter()
                .filter(|(key, _)| !turns(key))
                .for_each(|(key, v)| collect(&format!("{name}.{key}"), v, all));
        }
        Value::Array(list) if !list.iter().all(Value::is_number) => {
            list.iter().enumerate().for_each(|(i, v)| collect(&format!("{name}.{i}"), v, all));
        }
        _ => {}
    }
}

fn assert_same(scene: &Value, other: &Value, what: &str) {
    let (numbers, others) = (numbers(scene), numbers(other));
    assert_eq!(numbers.len(), others.len());
    let mut worst = (0.0, String::new());
    for ((name, a), (other, b)) in numbers.iter().zip(&others) {
        assert_eq!(name, other);
        // Parts of an energy are compared relative to the energy.
        let whole = if name.contains("split") { numbers[0].1 } else { a.abs() };
        let error = (a - b).abs() / whole;
        if a != b && error > worst.0 {
            worst = (error, name.clone());
        }
    }
    assert_at_most(worst.0, 1e-6, &format!("{what}: largest relative change of the summary ({})", worst.1));
}

const STRIKE: [f64; 3] = [8.0, 3.0, -40.0];

#[test]
fn a_common_velocity_changes_nothing() {
    let own = scene(STRIKE);
    assert_same(&own, &flying(own.clone(), [120.0, -130.0, 93.0]), "200 m/s for all");
}

#[test]
fn a_common_fall_changes_no_energy() {
    let own = scene(STRIKE);
    let mut falling = own.clone();
    falling["gravity_m_per_s2"] = json!([400, 0, -1000]);
    let energies = |scene: &Value| {
        let is_energy = |name: &str| name.contains("absorbed_energy") || name.contains("loss");
        let listed =
            numbers(scene).into_iter().filter(|(name, _)| is_energy(name) && name.ends_with("value"));
        listed.filter(|(name, _)| !name.contains("time")).collect::<Vec<_>>()
    };
    let (own, falling) = (energies(&own), energies(&falling));
    assert!(own.len() >= 4, "{own:?}");
    for ((name, a), (_, b)) in own.iter().zip(&falling) {
        assert_at_most((b / a - 1.0).abs(), 1e-5, &format!("{name}: relative change by gravity on all"));
    }
}

#[test]
fn a_turned_scene_has_the_same_summary() {
    let R = Rotation3::from_axis_angle(&Unit::new_normalize(Vec3::new(1.0, -2.0, 0.7)), 1.234);
    let rows: Vec<Vec<f64>> = (0..3).map(|i| (0..3).map(|j| R[(i, j)]).collect()).collect();
    let own = scene(STRIKE);
    let mut turned = scene((R * Vec3::from(STRIKE)).into());
    for body in turned["bodies"].as_array_mut().unwrap() {
        body["initial_deformation"] =
            json!({"kind": "affine", "center_m": [0.01, 0.02, 0.03], "deformation_gradient": rows});
    }
    assert_same(&own, &turned, "turned by 1.234 rad");
}

#[test]
fn a_mirrored_scene_has_the_same_summary() {
    let [x, y, z] = STRIKE;
    assert_same(&scene(STRIKE), &scene([-x, y, z]), "mirrored");
}
