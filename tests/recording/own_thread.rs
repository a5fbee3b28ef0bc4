//! A recorder on a thread of its own sees what it would see beside the steps, and is heard when it fails.

use super::{NOT_INTERRUPTED, small_plan};
use contuse::measure::{Measures, MeasuringRecorder};
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use contuse::record::{McapRecorder, MemoryRecorder, RecordingInfo, on_own_thread};
use contuse::step::{Ending, FailureCause, Frame, Outcome, Recorder, RecorderError, run};
use std::time::Duration;

#[test]
fn the_file_is_the_same_as_beside_the_steps() {
    let folder = tempfile::tempdir().unwrap();
    let plan = small_plan();
    let bytes = [false, true].map(|own_thread| {
        let path = folder.path().join(if own_thread { "a" } else { "b" });
        let mut recorder = McapRecorder::new(&path, RecordingInfo::default());
        let mut recorder = MeasuringRecorder::new(Measures::new()).with(&mut recorder);
        let (outcome, _) = if own_thread {
            on_own_thread(&plan, &mut recorder, |recorder| run(&plan, &NOT_INTERRUPTED, &mut [recorder]))
        } else {
            run(&plan, &NOT_INTERRUPTED, &mut [&mut recorder])
        };
        assert_eq!(outcome.ending, Ending::Finished);
        std::fs::read(path).unwrap()
    });
    assert!(bytes[0] == bytes[1], "the thread makes a difference");
}

/// Notes what it sees, slowly, and fails or panics on request.
#[derive(Default)]
struct Slow {
    steps: Vec<u64>,
    deepest: Vec<f64>,
    fails_at: Option<u64>,
    panics_at: Option<u64>,
    finished: bool,
}

impl Recorder for Slow {
    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        assert_ne!(self.panics_at, Some(frame.step), "requested");
        if frame.step.is_multiple_of(7) {
            std::thread::sleep(Duration::from_millis(3));
        }
        self.steps.push(frame.step);
        self.deepest.push(deepest(frame));
        if self.fails_at == Some(frame.step) { Err(RecorderError("no space left".into())) } else { Ok(()) }
    }
    fn finish(&mut self, _: &Plan, _: &Outcome) -> Result<(), RecorderError> {
        self.finished = true;
        Ok(())
    }
}

/// Of all nodes of all boundaries: each must be up to date.
fn deepest(frame: &Frame) -> f64 {
    let boundaries = frame.plan.bodies.iter().flat_map(|body| &body.boundary.nodes);
    boundaries
        .map(|&node| frame.position(node).z)
        .fold(f64::INFINITY, |a, z| if z < a || z.is_nan() { z } else { a })
}

#[test]
fn a_slow_recorder_misses_nothing() {
    let plan = small_plan();
    let (mut slow, mut beside, mut memory) = (Slow::default(), Slow::default(), MemoryRecorder::default());
    let mut measuring = MeasuringRecorder::new(Measures::new()).with(&mut memory);
    let (outcome, _) = on_own_thread(&plan, &mut slow, |slow| run(&plan, &NOT_INTERRUPTED, &mut [slow]));
    run(&plan, &NOT_INTERRUPTED, &mut [&mut beside]);
    on_own_thread(&plan, &mut measuring, |measuring| run(&plan, &NOT_INTERRUPTED, &mut [measuring]));
    assert_eq!(outcome.ending, Ending::Finished);
    assert_eq!(slow.steps, (0..=outcome.steps).collect::<Vec<_>>());
    assert_eq!(slow.deepest, beside.deepest);
    assert!(slow.finished);
    // At the field times all nodes are there, not only the boundaries'.
    let snapshot = memory.snapshots.last().unwrap();
    assert!(
        snapshot.u.iter().all(|u| u.iter().all(|x| x.is_finite()))
            && snapshot.u.iter().any(|u| *u != Vec3::zeros())
    );
}

#[test]
fn a_recorder_that_fails_ends_the_run_soon_and_is_closed() {
    let plan = small_plan();
    let mut slow = Slow { fails_at: Some(20), ..Slow::default() };
    let (outcome, state) = on_own_thread(&plan, &mut slow, |slow| run(&plan, &NOT_INTERRUPTED, &mut [slow]));
    let Ending::Failed { failure } = &outcome.ending else { panic!("{:?}", outcome.ending) };
    assert_eq!(failure.cause, FailureCause::RecordingFailed);
    assert!(failure.message.contains("no space left"), "{}", failure.message);
    assert!(slow.finished && slow.steps.last() == Some(&20), "nothing is recorded after a failure");
    assert!((20..60).contains(&state.step), "reported at step {}", state.step);
}

#[test]
fn a_failure_in_the_last_frame_is_reported_at_the_end() {
    let plan = small_plan();
    let (all, _) = run(&plan, &NOT_INTERRUPTED, &mut []);
    let mut slow = Slow { fails_at: Some(all.steps), ..Slow::default() };
    let (outcome, _) = on_own_thread(&plan, &mut slow, |slow| run(&plan, &NOT_INTERRUPTED, &mut [slow]));
    let Ending::Failed { failure } = &outcome.ending else { panic!("{:?}", outcome.ending) };
    assert_eq!((failure.cause, slow.finished), (FailureCause::RecordingFailed, true));
}

#[test]
#[should_panic(expected = "requested")]
fn a_panic_is_passed_on() {
    let plan = small_plan();
    let mut slow = Slow { panics_at: Some(5), ..Slow::default() };
    on_own_thread(&plan, &mut slow, |slow| run(&plan, &NOT_INTERRUPTED, &mut [slow]));
}
