//! One run of one scene: compile, step, measure, record. Used by the command line and the service.

use super::process::{peak_memory_bytes, process_cpu_s};
use super::progress::{Phase, Progress};
use crate::measure::artificial_end::ArtificialEnds;
use crate::measure::{
    ErrorBars, MeasuredEnd, MeasuredFrame, Measures, MeasuringRecorder, RequestedAccuracy, Sink, Summary,
};
use crate::plan::{CompileError, Integrator, Plan, PlanReport, compile};
use crate::record::on_own_thread;
use crate::scene::Scene;
use crate::step::{Ending, Energy, Interrupt, Outcome, Recorder, RecorderError, RunOptions, State, run};
use std::time::{Duration, Instant};

/// Minimum interval between progress reports.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// What to run, and how.
pub struct RunRequest<'a> {
    /// Loaded scene to run.
    pub scene: &'a Scene,
    /// Sinks of its measured frames, such as recordings. If there are any, frames are measured on a separate thread.
    pub sinks: Vec<&'a mut dyn Sink>,
    /// Optional recorder on the stepping thread: it receives every complete frame.
    pub also: Option<&'a mut dyn Recorder>,
    /// Worker threads, of which as many are used as shorten the run; the results do not depend on it.
    pub threads: usize,
    /// Called before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Receives the progress at a minimum interval of 50 ms, and at the end.
    pub progress: &'a mut (dyn FnMut(Progress) + Send),
}

/// Result of a run. A run that failed with a diagnosis is a result, not an error.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// How the run ended.
    pub outcome: Outcome,
    /// Clinical summary of the run.
    pub summary: Summary,
    /// Final state of the run.
    pub state: State,
    /// Energy ledger at the last step.
    pub energy: Energy,
    /// What the plan kept and omitted.
    pub plan_report: PlanReport,
    /// Wall time, compiling included [s]; of a run to an accuracy that of all its meshes.
    pub wall_s: f64,
    /// Processor time of the whole process meanwhile [s], including other runs in it; `None` if the system does not
    /// provide it.
    pub cpu_s: Option<f64>,
    /// Most resident memory of the process so far, the runs for error bars included [bytes]; `None` if the system does not provide it.
    pub peak_memory_bytes: Option<u64>,
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scene could not be compiled.
    #[error(transparent)]
    Compile(#[from] CompileError),
}

/// Runs a scene, with the error bars that `error_bars` estimates once the scene is known to compile, and the accuracy
/// requested of them.
///
/// # Errors
/// If the scene cannot be compiled, which validation should have found. Everything later is part of the outcome.
pub(super) fn run_with_error_bars(
    request: RunRequest,
    accuracy: Option<RequestedAccuracy>,
    error_bars: impl FnOnce(&RunRequest) -> ErrorBars,
) -> Result<RunResult, RunError> {
    let (wall, cpu) = (Instant::now(), process_cpu_s());
    // Compile, and run the cheaper runs for the error bars.
    (request.progress)(Progress::beginning(Phase::Loading));
    let plan = compile(request.scene)?;
    (request.progress)(Progress::beginning(Phase::EstimatingErrors));
    let error_bars = error_bars(&request);
    let result = run_plan(request, plan, error_bars, accuracy);
    let cpu_s = process_cpu_s().zip(cpu).map(|(end, start)| end - start);
    Ok(RunResult { wall_s: wall.elapsed().as_secs_f64(), cpu_s, ..result })
}

/// Runs the plan of a scene, which has these error bars.
pub(super) fn run_plan(
    request: RunRequest,
    plan: Plan,
    error_bars: ErrorBars,
    accuracy: Option<RequestedAccuracy>,
) -> RunResult {
    let (wall, cpu) = (Instant::now(), process_cpu_s());
    let phase = match (&plan.dynamic_relaxation, &plan.preload) {
        (Some(_), _) => Phase::DynamicRelaxation,
        (None, Some(_)) => Phase::Preload,
        (None, None) => Phase::Stepping,
    };
    (request.progress)(Progress::beginning(phase));

    let measures = measures_of(request.scene, &plan).with_error_bars(error_bars, accuracy);
    let mut reporter = Reporter { report: request.progress, last: None };
    let is_kept = !request.sinks.is_empty();
    let mut measuring = MeasuringRecorder::new(measures);
    for sink in request.sinks {
        measuring = measuring.with(sink);
    }
    // The last of the sinks: when it reports the end, the recordings are closed.
    let mut measuring = measuring.with(&mut reporter);
    // Run the steps, with the measures on a separate thread if anything is recorded.
    let options =
        RunOptions { threads: useful_threads(&plan, request.threads), interrupt: request.interrupt };
    let steps = |measuring: &mut dyn Recorder| {
        let mut recorders: Vec<&mut dyn Recorder> = vec![measuring];
        recorders.extend(request.also.map(|also| also as &mut dyn Recorder));
        run(&plan, &options, &mut recorders)
    };
    let (outcome, state) =
        if is_kept { on_own_thread(&plan, &mut measuring, steps) } else { steps(&mut measuring) };
    let (summary, energy) = (measuring.summary(&plan, &outcome), measuring.measures().energy.clone());
    RunResult {
        outcome,
        summary,
        state,
        energy,
        plan_report: plan.report,
        wall_s: wall.elapsed().as_secs_f64(),
        cpu_s: process_cpu_s().zip(cpu).map(|(end, start)| end - start),
        peak_memory_bytes: peak_memory_bytes(),
    }
}

/// Fewest elements per thread of an explicit run: with fewer the threads wait for each other longer than they work.
const LEAST_ELEMENTS: usize = 1000;

/// The number of threads, at most `most`, that shorten the run of a plan.
fn useful_threads(plan: &Plan, most: usize) -> usize {
    let computed = plan.sector.as_ref().map_or(plan, |of| &of.plan);
    match computed.integrator {
        Integrator::Explicit(_) => most.min(computed.element_count() / LEAST_ELEMENTS).max(1),
        Integrator::Implicit(_) => most,
    }
}

/// Measures of a run of a scene.
pub(super) fn measures_of(scene: &Scene, plan: &Plan) -> Measures {
    Measures::new()
        .with_artificial_ends(ArtificialEnds::of(scene, plan))
        .with_scene_warnings(scene.warnings.clone())
}

/// Ending of a run as written in tables and answers.
pub(super) fn ending_name(ending: &Ending) -> String {
    ending.failure().map_or_else(|| ending.name().into(), |failure| failure.cause.name())
}

/// Whether a run was stopped on request: then no other run should begin.
pub(super) fn is_stop(ending: &str) -> bool {
    matches!(ending, "cancelled" | "deadline")
}

/// A sink that reports the progress of the run.
struct Reporter<'a> {
    report: &'a mut (dyn FnMut(Progress) + Send),
    last: Option<Instant>,
}

impl Sink for Reporter<'_> {
    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        if self.last.is_none_or(|last| last.elapsed() >= PROGRESS_INTERVAL) {
            self.last = Some(Instant::now());
            let frame = measured.frame;
            let fraction = (frame.time / frame.plan.end_time).clamp(0.0, 1.0);
            (self.report)(Progress::at(Phase::Stepping, fraction, frame.step, frame.time));
        }
        Ok(())
    }

    fn finish(&mut self, end: &MeasuredEnd) -> Result<(), RecorderError> {
        let outcome = end.outcome;
        let fraction = match outcome.ending {
            Ending::Finished => 1.0,
            _ => (outcome.time_s / end.plan.end_time).clamp(0.0, 1.0),
        };
        (self.report)(Progress::at(Phase::Closing, fraction, outcome.steps, outcome.time_s));
        Ok(())
    }
}
