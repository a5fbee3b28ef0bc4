//! Any number of sinks at once: all see every measured frame, whatever becomes of one of them.

use super::{NOT_INTERRUPTED, read, small_plan};
use contuse::measure::{MeasuredEnd, MeasuredFrame, Measures, MeasuringRecorder, Sink};
use contuse::record::{McapRecorder, MemoryRecorder, RecordingInfo, on_own_thread};
use contuse::step::{Ending, FailureCause, RecorderError, run};

#[test]
fn two_files_and_a_memory_hold_the_same_run() {
    let (plan, folder) = (small_plan(), tempfile::tempdir().unwrap());
    let paths = ["alone", "a", "b"].map(|name| folder.path().join(name));
    let [mut alone, mut a, mut b] =
        paths.each_ref().map(|path| McapRecorder::new(path, RecordingInfo::default()));
    let mut measuring = MeasuringRecorder::new(Measures::new()).with(&mut alone);
    run(&plan, &NOT_INTERRUPTED, &mut [&mut measuring]);
    let mut memory = MemoryRecorder::default();
    let mut measuring = MeasuringRecorder::new(Measures::new()).with(&mut a).with(&mut memory).with(&mut b);
    let (outcome, _) =
        on_own_thread(&plan, &mut measuring, |measuring| run(&plan, &NOT_INTERRUPTED, &mut [measuring]));
    assert_eq!(outcome.ending, Ending::Finished);
    let [alone, a, b] = paths.map(|path| std::fs::read(path).unwrap());
    assert!(alone == a && a == b, "sinks disturb each other");
    let last = memory.samples.last().unwrap();
    assert_eq!((last.step, memory.outcome.as_ref()), (outcome.steps, Some(&outcome)));
    assert!(memory.samples.iter().any(|sample| sample.forces[0].norm() > 0.0));
}

/// Notes the steps that it sees, and fails at one of them on request.
#[derive(Default)]
struct Noting {
    steps: Vec<u64>,
    fails_at: Option<u64>,
    is_finished: bool,
}

impl Sink for Noting {
    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        let step = measured.frame.step;
        assert_eq!(measured.measures.step, step, "it is measured before it is seen");
        self.steps.push(step);
        if self.fails_at == Some(step) { Err(RecorderError("no space left".into())) } else { Ok(()) }
    }
    fn finish(&mut self, end: &MeasuredEnd) -> Result<(), RecorderError> {
        self.is_finished = matches!(end.outcome.ending, Ending::Failed { .. });
        Ok(())
    }
}

#[test]
fn a_sink_that_fails_keeps_no_frame_from_the_others() {
    let (plan, folder) = (small_plan(), tempfile::tempdir().unwrap());
    let path = folder.path().join("run.mcap");
    let mut file = McapRecorder::new(&path, RecordingInfo::default());
    let (mut failing, mut other) = (Noting { fails_at: Some(20), ..Noting::default() }, Noting::default());
    let mut measuring =
        MeasuringRecorder::new(Measures::new()).with(&mut failing).with(&mut other).with(&mut file);
    let (outcome, _) =
        on_own_thread(&plan, &mut measuring, |measuring| run(&plan, &NOT_INTERRUPTED, &mut [measuring]));
    let Ending::Failed { failure } = &outcome.ending else { panic!("{:?}", outcome.ending) };
    assert_eq!(failure.cause, FailureCause::RecordingFailed);
    for noting in [failing, other] {
        assert_eq!(noting.steps, (0..=20).collect::<Vec<_>>());
        assert!(noting.is_finished);
    }
    let contents = read(&path);
    assert_eq!((&contents.ending["ending"][..], &contents.ending["step"][..]), ("failed", "20"));
}
