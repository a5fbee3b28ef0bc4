//! One run of one scene: compile, step, measure, record. The command line and the service both come through here.

use super::progress::{Phase, Progress};
use crate::measure::artificial_end::ArtificialEnds;
use crate::measure::{
    AskedAccuracy, ErrorBars, MeasuredEnd, MeasuredFrame, Measures, MeasuringRecorder, Sink, Summary,
};
use crate::plan::{CompileError, Plan, PlanReport, compile};
use crate::record::on_own_thread;
use crate::scene::Scene;
use crate::step::{Ending, Energy, Interrupt, Outcome, Recorder, RecorderError, RunOptions, State, run};
use std::time::{Duration, Instant};

/// Progress is told at most this often.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// What to run, and how.
pub struct RunRequest<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where its measured frames go, such as recordings. If anywhere, they are measured on a thread of their own.
    pub sinks: Vec<&'a mut dyn Sink>,
    /// A recorder beside the steps, if any: it sees every frame whole.
    pub also: Option<&'a mut dyn Recorder>,
    /// Worker threads; the results are the same for any number.
    pub threads: usize,
    /// Asked before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Told how far it is, every fiftieth of a second at most, and at the end.
    pub progress: &'a mut (dyn FnMut(Progress) + Send),
}

/// What came out. A run that failed with a diagnosis is a result, not an error.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// How it ended.
    pub outcome: Outcome,
    /// The clinical summary.
    pub summary: Summary,
    /// The state that it ended in.
    pub state: State,
    /// The ledger at its last step.
    pub energy: Energy,
    /// What the plan kept and left out.
    pub plan_report: PlanReport,
    /// Wall time, compiling included [s].
    pub wall_s: f64,
    /// Processor time of the whole process meanwhile [s]; `None` where the system does not tell. Other runs in the same
    /// process are in it.
    pub cpu_s: Option<f64>,
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scene could not be compiled.
    #[error(transparent)]
    Compile(#[from] CompileError),
}

/// Runs a scene, with the error bars that `error_bars` finds once it is known to compile, and the accuracy that is asked of them.
///
/// # Errors
/// When the scene cannot be compiled, which validation should have found. Everything later is part of the outcome.
pub(super) fn run_with_error_bars(
    request: RunRequest,
    accuracy: Option<AskedAccuracy>,
    error_bars: impl FnOnce(&RunRequest) -> ErrorBars,
) -> Result<RunResult, RunError> {
    let (wall, cpu) = (Instant::now(), process_cpu_s());
    (request.progress)(Progress::beginning(Phase::Loading));
    let plan = compile(request.scene)?;
    (request.progress)(Progress::beginning(Phase::EstimatingErrors));
    let error_bars = error_bars(&request);
    let phase =
        if plan.settle.is_some() || plan.preload.is_some() { Phase::Settling } else { Phase::Stepping };
    (request.progress)(Progress::beginning(phase));

    let measures = measures_of(request.scene, &plan).with_error_bars(error_bars, accuracy);
    let mut teller = Teller { tell: request.progress, told: None };
    let is_kept = !request.sinks.is_empty();
    let mut measuring = MeasuringRecorder::new(measures);
    for sink in request.sinks {
        measuring = measuring.with(sink);
    }
    // The last of the sinks: when it tells of the end, the recordings are closed.
    let mut measuring = measuring.with(&mut teller);
    let options = RunOptions { threads: request.threads, interrupt: request.interrupt };
    let steps = |measuring: &mut dyn Recorder| {
        let mut recorders: Vec<&mut dyn Recorder> = vec![measuring];
        recorders.extend(request.also.map(|also| also as &mut dyn Recorder));
        run(&plan, &options, &mut recorders)
    };
    let (outcome, state) =
        if is_kept { on_own_thread(&plan, &mut measuring, steps) } else { steps(&mut measuring) };
    let (summary, energy) = (measuring.summary(&plan, &outcome), measuring.measures().energy.clone());
    Ok(RunResult {
        outcome,
        summary,
        state,
        energy,
        plan_report: plan.report,
        wall_s: wall.elapsed().as_secs_f64(),
        cpu_s: process_cpu_s().zip(cpu).map(|(end, start)| end - start),
    })
}

/// What is measured in every run of a scene.
pub(super) fn measures_of(scene: &Scene, plan: &Plan) -> Measures {
    Measures::new()
        .with_artificial_ends(ArtificialEnds::of(scene, plan))
        .with_scene_warnings(scene.warnings.clone())
}

/// How a run ended, as it is written in tables and answers.
pub(super) fn ending_name(ending: &Ending) -> String {
    match ending {
        Ending::Finished => "finished".into(),
        Ending::Cancelled => "cancelled".into(),
        Ending::Failed { failure } => failure.cause.name(),
    }
}

/// Whether a run ended because it was told to: then no other one needs to begin.
pub(super) fn is_stop(ending: &str) -> bool {
    matches!(ending, "cancelled" | "deadline")
}

/// Processor time of the process so far [s].
#[cfg(unix)]
#[allow(clippy::unnecessary_wraps)] // not every system tells
pub fn process_cpu_s() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

/// Processor time of the process so far [s].
#[cfg(not(unix))]
pub fn process_cpu_s() -> Option<f64> {
    None
}

/// A sink that tells how far the run is.
struct Teller<'a> {
    tell: &'a mut (dyn FnMut(Progress) + Send),
    told: Option<Instant>,
}

impl Sink for Teller<'_> {
    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        if self.told.is_none_or(|told| told.elapsed() >= PROGRESS_INTERVAL) {
            self.told = Some(Instant::now());
            let frame = measured.frame;
            let share = (frame.time / frame.plan.end_time).clamp(0.0, 1.0);
            (self.tell)(Progress::at(Phase::Stepping, share, frame.step, frame.time));
        }
        Ok(())
    }

    fn finish(&mut self, end: &MeasuredEnd) -> Result<(), RecorderError> {
        let outcome = end.outcome;
        let share = match outcome.ending {
            Ending::Finished => 1.0,
            _ => (outcome.time_s / end.plan.end_time).clamp(0.0, 1.0),
        };
        (self.tell)(Progress::at(Phase::Closing, share, outcome.steps, outcome.time_s));
        Ok(())
    }
}
