//! What ends a run, and what it says then: the energy gate, inversion, interruption, a recorder that fails.

use crate::rig::{plan, run, run_on};
use contuse::plan::Plan;
use contuse::step::{
    Ending, Failure, FailureCause, Frame, Interrupt, Outcome, Recorder, RecorderError, RunOptions, State,
    run_from,
};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A ball thrown at a wall.
fn scene(speed: f64) -> Value {
    json!({
        "name": "ball on wall",
        "end_time_s": 2e-3,
        "bodies": [{
            "name": "ball",
            "mesh": {"generator": {
                "kind": "hollow_ball", "center_m": [0, 0, 0.0151], "outer_radius_m": 0.015, "inner_radius_m": 0.010,
                "elements_around": 4, "elements_through": 2
            }},
            "velocity_m_per_s": [0, 0, -speed],
            "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": {
                "law": "neo_hookean", "c10_pa": 5e5, "bulk_modulus_pa": 1e7, "volumetric": "quadratic"
            }}]
        }],
        "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "integrator": {"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "record": {"fields": [], "field_times_s": []}
    })
}

fn failure(outcome: Outcome) -> Failure {
    match outcome.ending {
        Ending::Failed { failure } => failure,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_step_beyond_stability_fails_the_energy_gate() {
    let mut plan = plan(&scene(5.0));
    let (stable, _) = run(&plan, |_| {});
    assert!(stable.balance_error < 1e-3, "{}", stable.balance_error);
    // The bound is an upper one: three times the step is beyond it for certain.
    plan.explicit.safety = 3.0;
    let mut last = 0.0;
    let (outcome, state) = run_on(&plan, State::new(&plan), 1, |frame| last = frame.energy.balance_error);
    println!("{outcome:?}");
    let failure = failure(outcome);
    assert_eq!(failure.cause, FailureCause::EnergyGate);
    assert!(last > 0.01, "the last frame shows the error: {last}");
    assert_eq!((failure.time_s, failure.step), (state.time, state.step));
    assert!(failure.message.contains("gate 1.00 %"), "{}", failure.message);
    assert!(failure.remedy.contains("safety_factor"), "{}", failure.remedy);
}

#[test]
fn an_inversion_names_the_element_the_place_and_the_time() {
    let plan = plan(&scene(300.0));
    let mut frames = 0;
    let (outcome, state) = run_on(&plan, State::new(&plan), 1, |_| frames += 1);
    println!("{outcome:?} {frames}");
    let smallest = outcome.smallest_jacobian;
    let failure = failure(outcome);
    assert_eq!(failure.cause, FailureCause::ElementInverted);
    assert!(smallest <= 0.0);
    let place = failure.element.unwrap();
    assert_eq!((place.body.as_str(), place.part.as_str()), ("ball", "ball"));
    // At the wall, below the centre of the ball.
    let [x, y, z] = place.position_m;
    assert!(x.hypot(y) < 0.015 && (0.0..0.01).contains(&z), "{:?}", place.position_m);
    assert!(failure.time_s > 3e-7 && failure.time_s == state.time);
}
