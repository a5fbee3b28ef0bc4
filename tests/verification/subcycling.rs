//! Subcycling against runs in which every element is evaluated in every step.

use crate::rig::{assert_close, plan, run, run_on};
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use contuse::step::{Ending, Interrupt, Outcome, RunOptions, State, run_from};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A soft bar strikes a short stiff one aslant, both free, with friction. `extras`: further keys of their parts.
fn bars(subcycling: bool, extras: &Value) -> Value {
    let body = |name: &str, from: f64, to: f64, elements: u32, stiffness: f64| {
        let mut part = json!({"part": "*", "density_kg_per_m3": 1000, "material": {
            "law": "neo_hookean", "c10_pa": 2e4 * stiffness, "bulk_modulus_pa": 2e6 * stiffness
        }});
        for (key, value) in extras.as_object().into_iter().flatten() {
            part[key] = value.clone();
        }
        json!({
            "name": name,
            "mesh": {"generator": {
                "kind": "block", "min_m": [from, 0, 0], "max_m": [to, 0.01, 0.01], "elements": [elements, 4, 4]
            }},
            "velocity_m_per_s": if from > 0.0 { [-2.0, 0.0, 0.5] } else { [0.0, 0.0, 0.0] },
            "parts": [part]
        })
    };
    json!({
        "name": "bars", "end_time_s": 1e-3,
        "bodies": [
            body("soft", 0.0101, 0.1101, 40, 1.0),
            body("stiff", 0.0, 0.01, 2, 36.0)
        ],
        "contact": {"friction": 0.2},
        "integrator": {"kind": "explicit", "subcycling": subcycling},
        "record": {"fields": [], "field_times_s": [5e-4]}
    })
}

/// The run to its end, and its state there.
fn finish(plan: &Plan, state: State, threads: usize) -> (Outcome, State) {
    let (outcome, state) = run_on(plan, state, threads, |_| {});
    assert_eq!(outcome.ending, Ending::Finished);
    (outcome, state)
}

/// Fraction of the elements that a step evaluates.
fn evaluated(outcome: &Outcome) -> f64 {
    outcome.evaluated_element_steps as f64 / outcome.element_steps as f64
}

fn momentum(plan: &Plan, state: &State) -> Vec3 {
    let of_body = |body: &contuse::plan::PlanBody| {
        let nodes = body.nodes.start as usize..body.nodes.end as usize;
        nodes.map(|node| (state.v[node] + body.flight_velocity) * plan.mass[node]).sum::<Vec3>()
    };
    plan.bodies.iter().map(of_body).sum()
}

#[test]
fn the_motion_is_that_of_equal_steps_with_half_of_the_evaluations() {
    for extras in [
        json!({}),
        json!({"shear_viscosity_pa_s": 2.0}),
        json!({"prony_series": {"branches": [{"relative_modulus": 0.4, "relaxation_time_s": 3e-4}]}}),
    ] {
        let [whole, subcycled] = [false, true].map(|subcycling| {
            let plan = plan(&bars(subcycling, &extras));
            let (outcome, state) = finish(&plan, State::new(&plan), 1);
            (plan, outcome, state)
        });
        assert!(evaluated(&whole.1) > 0.7, "{extras}: {}", evaluated(&whole.1));
        assert!(evaluated(&subcycled.1) < 0.5 * evaluated(&whole.1), "{extras}: {}", evaluated(&subcycled.1));
        // Energies, momentum and displacements.
        assert!(subcycled.1.balance_error < 2e-3, "{extras}: {}", subcycled.1.balance_error);
        let start = momentum(&whole.0, &State::new(&whole.0));
        assert!((momentum(&subcycled.0, &subcycled.2) - start).norm() < 1e-9 * start.norm(), "{extras}");
        let largest = whole.2.u.iter().map(Vec3::norm).fold(0.0, f64::max);
        let off = whole.2.u.iter().zip(&subcycled.2.u).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 0.01 * largest, "{extras}: {off} m of {largest} m");
        let dissipated = |state: &State| state.ledger.viscous.iter().sum::<f64>();
        let what = format!("dissipated by viscosity and relaxation [J], {extras}");
        assert_close(dissipated(&subcycled.2), dissipated(&whole.2), 0.05, &what);
    }
}

#[test]
fn a_mesh_with_nothing_to_gain_has_the_bits_of_equal_steps() {
    let bits = [false, true].map(|subcycling| {
        let mut scene = bars(subcycling, &json!({}));
        scene["bodies"].as_array_mut().unwrap().pop();
        scene["planes"] = json!([{"name": "wall", "point_m": [0.01, 0, 0], "normal": [1, 0, 0]}]);
        let plan = plan(&scene);
        let (_, state) = finish(&plan, State::new(&plan), 1);
        (state.u, state.v, state.step)
    });
    assert!(bits[0] == bits[1]);
}

#[test]
fn a_run_goes_on_within_a_cycle_with_the_same_bits_on_any_number_of_threads() {
    let extras =
        json!({"prony_series": {"branches": [{"relative_modulus": 0.4, "relaxation_time_s": 3e-4}]}});
    let plan = plan(&bars(true, &extras));
    let (_, uninterrupted) = finish(&plan, State::new(&plan), 1);
    for stop in [150, 151, 152, 153] {
        let requested = AtomicUsize::new(0);
        let interrupt = || (requested.fetch_add(1, Ordering::Relaxed) >= stop).then_some(Interrupt::Cancel);
        let options = RunOptions { threads: 1, interrupt: &interrupt };
        let (_, on_the_way) = run_from(&plan, State::new(&plan), &options, &mut []);
        assert_eq!(on_the_way.step, stop as u64);
        let (_, finished) = finish(&plan, on_the_way, 2);
        assert!(finished == uninterrupted, "a run that stopped at step {stop} differs");
    }
}

#[test]
fn balances_are_those_of_times_at_which_everything_is_known() {
    let plan = plan(&bars(true, &json!({})));
    let (mut known, mut all) = (0, 0);
    let mut before = f64::NAN;
    let (outcome, _) = run(&plan, |frame| {
        all += 1;
        known += usize::from(frame.energy.total_j.to_bits() != before.to_bits());
        before = frame.energy.total_j;
    });
    assert!(known > all / 5 && known < all / 2, "{known} of {all}");
    assert!(outcome.balance_error > 0.0);
}
