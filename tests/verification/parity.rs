//! The same bits for every number of threads, and after a restart.

use crate::rig::{plan, run_on, small_ball_on_block};
use contuse::plan::Plan;
use contuse::step::{Ending, Interrupt, RunOptions, State, run_from};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A small ball strikes a block aslant, with friction; `end` [s].
fn scene(end: f64) -> Value {
    let times: Vec<f64> = [1.1e-5, 2e-5, 4e-5].into_iter().filter(|t| *t < end).collect();
    let mut scene = small_ball_on_block([6, 2], [12, 12, 6], [30.0, 0.0, -90.0], end);
    scene["bodies"][0]["spin_rad_per_s"] = json!([0, 500, 0]);
    scene["record"]["field_times_s"] = json!(times);
    scene
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
    let requested = AtomicUsize::new(0);
    let after_seven = || (requested.fetch_add(1, Ordering::Relaxed) >= 7).then_some(Interrupt::Cancel);
    let options = RunOptions { threads: 1, interrupt: &after_seven };
    let (_, on_the_way) = run_from(&whole, State::new(&whole), &options, &mut []);
    assert_eq!(on_the_way.step, 7);
    assert!(finish(&whole, on_the_way, 2) == uninterrupted, "a run restarted at step 7 differs");
}
