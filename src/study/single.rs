//! One run of one scene: compile, step, measure, record. The command line and the service both come through here.

use super::error_bars::error_bars;
use crate::measure::artificial_end::ArtificialEnds;
use crate::measure::{Measures, Summary};
use crate::plan::{CompileError, Plan, PlanReport, compile};
use crate::record::{McapRecorder, NullRecorder, RecordingInfo, on_own_thread};
use crate::scene::Scene;
use crate::step::{
    Ending, Energy, Frame, Interrupt, Outcome, Recorder, RecorderError, RunOptions, State, run,
};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

/// Progress is told at most this often.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// What a run is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Scene → plan.
    Compiling,
    /// Cheaper runs for the error bars.
    EstimatingErrors,
    /// Settling, or loading quasi-statically, before the clock starts.
    Settling,
    /// Stepping.
    Running,
    /// Done with stepping; the recording is closed.
    Finished,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Progress {
    /// Share of the simulated time, 0 to 1.
    pub fraction: f64,
    /// Simulated time [s].
    pub time_s: f64,
    /// Steps done.
    pub step: u64,
    /// What it is doing.
    pub phase: Phase,
}

/// What to run, and how.
pub struct RunRequest<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its document as it came, for the recording.
    pub document_json: &'a [u8],
    /// Where to record, if at all. The file has its name when it is whole, see [`crate::record::partial_path`].
    pub recording: Option<&'a Path>,
    /// Another recorder that sees every frame, if any.
    pub also: Option<&'a mut dyn Recorder>,
    /// Worker threads; the results are the same for any number.
    pub threads: usize,
    /// Asked before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Told how far it is, every fiftieth of a second at most, and at the end.
    pub progress: &'a mut dyn FnMut(Progress),
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

/// Runs a scene.
///
/// # Errors
/// When the scene cannot be compiled, which validation should have found. Everything later is part of the outcome.
pub fn run_scene(request: RunRequest) -> Result<RunResult, RunError> {
    let (wall, cpu) = (Instant::now(), process_cpu_s());
    let progress = request.progress;
    progress(Progress { fraction: 0.0, time_s: 0.0, step: 0, phase: Phase::Compiling });
    let plan = compile(request.scene)?;
    progress(Progress { fraction: 0.0, time_s: 0.0, step: 0, phase: Phase::EstimatingErrors });
    let error_bars = error_bars(request.scene, &[], request.threads, request.interrupt);
    let phase =
        if plan.settle.is_some() || plan.preload.is_some() { Phase::Settling } else { Phase::Running };
    progress(Progress { fraction: 0.0, time_s: 0.0, step: 0, phase });

    let measures = measures_of(request.scene, &plan).with_error_bars(error_bars);
    let options = RunOptions { threads: request.threads, interrupt: request.interrupt };
    let mut teller = Teller { tell: progress, told: None };
    let mut nothing = NullRecorder;
    let also = request.also.unwrap_or(&mut nothing);
    let (outcome, state, summary, energy) = if let Some(path) = request.recording {
        let info = recording_info(request.scene, request.document_json);
        let mut recorder = McapRecorder::new(path, info, measures);
        let (outcome, state) = on_own_thread(&plan, &mut recorder, |recorder| {
            run(&plan, &options, &mut [recorder, &mut teller, also])
        });
        let summary = final_summary(recorder.measures(), &plan, &outcome);
        (outcome, state, summary, recorder.measures().energy.clone())
    } else {
        run_measured(&plan, measures, &options, &mut [&mut teller, also])
    };
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

/// Runs a plan without recording it.
pub(super) fn run_measured(
    plan: &Plan,
    mut measures: Measures,
    options: &RunOptions,
    also: &mut [&mut dyn Recorder],
) -> (Outcome, State, Summary, Energy) {
    let mut recorders: Vec<&mut dyn Recorder> = vec![&mut measures];
    recorders.extend(also.iter_mut().map(|recorder| &mut **recorder as &mut dyn Recorder));
    let (outcome, state) = run(plan, options, &mut recorders);
    let summary = final_summary(&measures, plan, &outcome);
    (outcome, state, summary, measures.energy)
}

/// The summary of the outcome. It is composed anew when the outcome changed after the measures were finished: when closing
/// the recording failed.
fn final_summary(measures: &Measures, plan: &Plan, outcome: &Outcome) -> Summary {
    match &measures.summary {
        Some(summary) if summary.is_of(outcome) => summary.clone(),
        _ => Summary::compose(measures, plan, Some(outcome)),
    }
}

/// Where the recording comes from.
fn recording_info(scene: &Scene, document_json: &[u8]) -> RecordingInfo {
    let bodies = scene.document.bodies.iter().zip(&scene.bodies).filter(|(_, body)| body.rigid.is_none());
    RecordingInfo {
        document_json: document_json.to_vec(),
        scene_hash: scene.content_hash.clone(),
        mesh_hashes: bodies.map(|(document, body)| (document.name.clone(), mesh_hash(&body.mesh))).collect(),
    }
}

/// SHA-256 of a mesh as it was placed: node positions, elements, parts.
fn mesh_hash(mesh: &crate::mesh::Mesh) -> String {
    let mut hash = Sha256::new();
    mesh.nodes.iter().flat_map(|x| x.iter()).for_each(|x| hash.update(x.to_le_bytes()));
    mesh.hexes.iter().flatten().for_each(|node| hash.update(node.to_le_bytes()));
    mesh.part_of.iter().for_each(|part| hash.update(part.to_le_bytes()));
    hash.finalize().iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// How a run ended, as it is written in tables and answers.
pub(super) fn ending_name(ending: &Ending) -> String {
    match ending {
        Ending::Finished => "finished".into(),
        Ending::Cancelled => "cancelled".into(),
        Ending::Failed { failure } => serde_json::to_value(failure.cause)
            .ok()
            .and_then(|cause| cause.as_str().map(str::to_owned))
            .unwrap_or_else(|| "failed".into()),
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

/// A recorder that tells how far the run is.
struct Teller<'a> {
    tell: &'a mut dyn FnMut(Progress),
    told: Option<Instant>,
}

impl Recorder for Teller<'_> {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        Ok(())
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        if self.told.is_none_or(|told| told.elapsed() >= PROGRESS_INTERVAL) {
            self.told = Some(Instant::now());
            let fraction = (frame.time / frame.plan.end_time).clamp(0.0, 1.0);
            let phase = if frame.time < 0.0 { Phase::Settling } else { Phase::Running };
            (self.tell)(Progress { fraction, time_s: frame.time, step: frame.step, phase });
        }
        Ok(())
    }

    fn finish(&mut self, plan: &Plan, outcome: &Outcome) -> Result<(), RecorderError> {
        let fraction = match outcome.ending {
            Ending::Finished => 1.0,
            _ => (outcome.time_s / plan.end_time).clamp(0.0, 1.0),
        };
        let phase = Phase::Finished;
        (self.tell)(Progress { fraction, time_s: outcome.time_s, step: outcome.steps, phase });
        Ok(())
    }
}
