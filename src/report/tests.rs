//! Recorded runs for tests, and how their numbers are read.

use super::RecordedRun;
use serde_json::{Value, json};

/// The run of the example in the documentation.
pub fn example() -> RecordedRun {
    let summary = include_str!("../../api/examples/summary.response.json");
    let mut run = RecordedRun { summary: serde_json::from_str(summary).unwrap(), ..RecordedRun::default() };
    run.take_numbers().unwrap();
    run
}

pub fn quantity_of(value: f64, error: f64, resolved: bool) -> Value {
    let error = json!({
        "total": error, "mesh": error, "step": 0.0, "contact": 0.0, "resolution": 0.0, "resolved": resolved
    });
    json!({"value": value, "error": error, "gate": "passed"})
}

#[test]
fn numbers_are_read_as_they_were_written() {
    let run = example();
    assert_eq!(serde_json::to_value(run.results()).unwrap(), run.summary["results"]);
    assert_eq!(serde_json::to_value(&run.criteria).unwrap(), run.summary["injury_measures"]);
}

#[test]
fn the_worst_instant_is_of_the_largest_stress_that_is_known() {
    let mut run = example();
    let known = run.summary["results"]["tissue"].clone();
    let worst = |run: &mut RecordedRun| {
        run.take_numbers().unwrap();
        (run.worst().time_s, run.worst().what)
    };
    let in_volume = known["exceeded_in_volume"]["von_mises_pa"]["time_s"].as_f64().unwrap();
    assert_eq!(worst(&mut run), (in_volume, "the largest stress in the tissue"));
    run.summary["results"]["tissue"].as_object_mut().unwrap().remove("exceeded_in_volume");
    let at_point = known["peak_von_mises_pa"]["time_s"].as_f64().unwrap();
    assert_eq!(worst(&mut run), (at_point, "the largest stress at a point of the tissue"));
    // No stress was above 0, as in a run that stopped at its start.
    run.summary["results"]["tissue"]["peak_von_mises_pa"]["value"] = json!(0.0);
    let peak = run.summary["results"]["impacts"][0]["peak_force_time_s"]["value"].as_f64().unwrap();
    assert_eq!(worst(&mut run), (peak, "the peak force"));
    run.summary["results"]["headline"] = json!({});
    assert_eq!(worst(&mut run), (run.summary["time_s"].as_f64().unwrap(), "the end of the run"));
}

#[test]
fn withheld_numbers_are_no_results_and_those_of_another_version_an_error() {
    let mut run = example();
    let values = run.summary["results"].take();
    run.summary = json!({"withheld": {"reason": "a gate failed", "values": values}});
    run.take_numbers().unwrap();
    assert!(run.results().is_none() && run.values.is_some() && run.withheld() == Some("a gate failed"));
    // A value that is not finite.
    run.summary["withheld"]["values"]["impacts"][0]["impulse_n_s"]["value"] = Value::Null;
    run.summary["numerics"]["balance_error"] = Value::Null;
    run.take_numbers().unwrap();
    assert!(run.values.is_none() && run.numerics.is_none());
    run.summary = json!({"results": {"impacts": []}});
    assert!(run.take_numbers().unwrap_err().to_string().contains("nothing_touched"));
}
