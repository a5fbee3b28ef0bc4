//! The same bits for every number of threads, and after a restart.

use crate::rig::{plan, run_on};
use contuse::plan::Plan;
use contuse::step::{Ending, Interrupt, RunOptions, State, run_from};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A small ball strikes a block aslant, with friction; `end` [s].
fn scene(end: f64) -> Value {
    let times: Vec<f64> = [1.1e-5, 2e-5, 4e-5].into_iter().filter(|t| *t < end).collect();
    json!({
        "name": "ball on block",
        "end_time_s": end,
        "bodies": [
            {
                "name": "ball",
                "mesh": {"generator": {
                    "kind": "hollow_ball", "center_m": [0, 0, 0.0652], "outer_radius_m": 0.015, "inner_radius_m": 0.012,
                    "elements_around": 6, "elements_through": 2
                }},
                "velocity_m_per_s": [30, 0, -90],
                "spin_rad_per_s": [0, 500, 0],
                "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "formulation": "reduced", "material": {
                    "law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7
                }}]
            },
            {
                "name": "block",
                "mesh": {"generator": {
                    "kind": "block", "min_m": [-0.05, -0.05, 0], "max_m": [0.05, 0.05, 0.05], "elements": [12, 12, 6]
                }},
                "fixed": [{"set": "z_min"}],
                "parts": [{"part": "block", "density_kg_per_m3": 1060.0, "material": {
                    "law": "holzapfel_gasser_ogden", "c_pa": 2e4, "k1_pa": 2e4, "k2": 0.8, "kappa": 0.1,
                    "fibres": {"angles_deg": [29.0, -29.0]}, "bulk_modulus_pa": 2e7
                }}]
            }
        ],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": times}
    })
}

fn finish(plan: &Plan, state: State, threads: usize) -> State {
    let (mut reactions, mut last) = (0, 0.0);
    let (outcome, state) = run_on(plan, state, threads, |frame| {
        reactions = reactions.max(frame.reactions.iter().filter(|r| r.impulse[0] > 0.0).count());
        last = frame.energy.balance_error;
    });
    assert_eq!(outcome.ending, Ending::Finished);
    assert!(reactions > 3, "only {reactions} contacts: the scene shows nothing");
    assert!(last < 0.01);
    state
}

#[test]
fn one_two_and_three_threads_give_the_same_bits() {
    let plan = plan(&scene(6e-5));
    let one = finish(&plan, State::new(&plan), 1);
    for threads in [2, 3] {
        assert!(finish(&plan, State::new(&plan), threads) == one, "{threads} threads differ");
    }
}

#[test]
fn a_copy_of_the_state_goes_on_as_if_never_stopped() {
    let whole = plan(&scene(6e-5));
    let uninterrupted = finish(&whole, State::new(&whole), 1);
    // Ends at a time that the whole run hits too, in the middle of contact.
    let first = plan(&scene(4e-5));
    let half = finish(&first, State::new(&first), 1);
    assert_eq!(half.time, 4e-5);
    let copy = half.clone();
    assert!(finish(&whole, copy, 1) == uninterrupted, "a restarted run differs");

    // That of a run stopped on the way is as good.
    let asked = AtomicUsize::new(0);
    let after_seven = || (asked.fetch_add(1, Ordering::Relaxed) >= 7).then_some(Interrupt::Cancel);
    let options = RunOptions { threads: 1, interrupt: &after_seven };
    let (_, on_the_way) = run_from(&whole, State::new(&whole), &options, &mut []);
    assert_eq!(on_the_way.step, 7);
    assert!(finish(&whole, on_the_way, 2) == uninterrupted, "a run restarted at step 7 differs");
}
