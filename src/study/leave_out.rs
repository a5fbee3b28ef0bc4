//! What leaving out saves, and that it changes nothing: a scene as it is compiled, then with each thing put back, then with
//! all of them.
//!
//! Whatever a plan leaves out adds exact zeros, or is never looked at, so putting it back must leave every bit of the
//! motion, of the impulses and of the energies ([`Theory::Bitwise`]); a run that does not is a fault of the program.

use super::run::run_scene;
use super::single::{RunError, RunRequest, RunResult, ending_name};
use crate::measure::Sink;
use crate::record::{McapRecorder, RecordingInfo};
use crate::scene::Scene;
use crate::scene::document::{ErrorBarsDocument, Keep};
use crate::step::{Ending, Interrupt};
use serde::Serialize;
use std::path::Path;

/// What to study, and how.
pub struct LeaveOutRequest<'a> {
    /// The scene; what it keeps itself is kept in every run.
    pub scene: &'a Scene,
    /// Its document as it came, for the recordings.
    pub document_json: &'a [u8],
    /// Runs of each kind, taken in turns so that a machine that changes its speed changes it for all; their median counts.
    pub repeat: u32,
    /// Worker threads of each run.
    pub threads: usize,
    /// Where to record each run, over the one before; `None` to record nothing.
    pub recording: Option<&'a Path>,
    /// Asked before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Told before each run: its number from 0, of how many, and what it puts back.
    pub progress: &'a mut dyn FnMut(usize, usize, &[Keep]),
}

/// The table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeaveOutStudy {
    /// Name of the scene.
    pub scene: String,
    /// Runs of each kind.
    pub repeat: u32,
    /// Worker threads of each run.
    pub threads: usize,
    /// Elements of the scene.
    pub elements: usize,
    /// Whether every run finished and agreed as theory says.
    pub holds: bool,
    /// The first is the scene as it is compiled; then each thing put back alone; then all together, if there are several.
    pub rows: Vec<LeaveOutRow>,
}

/// Runs of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeaveOutRow {
    /// What was put back.
    pub put_back: Vec<Keep>,
    /// How the runs ended: `finished`, `cancelled` or the cause of the failure.
    pub ending: String,
    /// Steps of a run.
    pub steps: u64,
    /// Elements swept, summed over the steps.
    pub element_steps: u64,
    /// Median wall time [s], compiling, measuring and recording included.
    pub wall_s: f64,
    /// Median processor time [s]; null where the system does not tell.
    pub cpu_s: Option<f64>,
    /// Bytes of a run, about, by the plan.
    pub memory_bytes: u64,
    /// Bytes of the recording; null when nothing was recorded.
    pub recording_bytes: Option<u64>,
    /// Difference of the results from those of the first row.
    pub difference: Difference,
    /// What theory says of it.
    pub theory: Theory,
    /// Whether it finished and agrees as theory says.
    pub holds: bool,
}

/// How results may differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Theory {
    /// Not at all: every bit is the same (the sign of a zero apart).
    Bitwise,
}

/// How far results are apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Difference {
    /// Every bit of displacement, velocity, impulses and energies is the same.
    Bitwise,
    /// They are not the same.
    Rounding {
        /// Largest difference over the largest value of the same quantity [-].
        largest_relative: f64,
        /// The quantity.
        quantity: String,
    },
}

/// Runs the study.
///
/// # Errors
/// When the scene cannot be compiled.
pub fn study_leave_out(request: &mut LeaveOutRequest) -> Result<LeaveOutStudy, RunError> {
    let repeat = request.repeat.max(1) as usize;
    let mut kinds: Vec<Kind> = vec![Kind::new(Vec::new())];
    kinds[0].run(request)?;
    let switches = kinds[0].switches();
    kinds.extend(switches.iter().map(|keep| Kind::new(vec![*keep])));
    if switches.len() > 1 {
        kinds.push(Kind::new(switches));
    }
    let (count, mut done) = (repeat * kinds.len(), 0);
    for round in 0..repeat {
        for (i, kind) in kinds.iter_mut().enumerate() {
            (request.progress)(done, count, &kind.put_back);
            done += 1;
            // The first run of all has told what there is to put back.
            if (round, i) != (0, 0) {
                kind.run(request)?;
            }
        }
    }
    let rows: Vec<LeaveOutRow> = kinds.iter().filter_map(|kind| kind.row(&kinds[0])).collect();
    Ok(LeaveOutStudy {
        scene: request.scene.document.name.clone(),
        repeat: request.repeat.max(1),
        threads: request.threads,
        elements: kinds[0].latest.as_ref().map_or(0, |r| r.plan_report.elements),
        holds: rows.iter().all(|row| row.holds),
        rows,
    })
}

/// Runs of one kind, so far.
struct Kind {
    put_back: Vec<Keep>,
    wall_s: Vec<f64>,
    cpu_s: Vec<f64>,
    recording_bytes: Option<u64>,
    latest: Option<RunResult>,
}

impl Kind {
    fn new(put_back: Vec<Keep>) -> Self {
        Self { put_back, wall_s: Vec::new(), cpu_s: Vec::new(), recording_bytes: None, latest: None }
    }

    fn run(&mut self, request: &LeaveOutRequest) -> Result<(), RunError> {
        let mut scene = request.scene.clone();
        scene.put_back(&self.put_back);
        // Error bars would be the same, and their time is not what is studied.
        scene.document.solver.error_bars = ErrorBarsDocument::None;
        let recorder_to = |path| McapRecorder::new(path, RecordingInfo::of(&scene, request.document_json));
        let mut recorder = request.recording.map(recorder_to);
        let result = run_scene(RunRequest {
            scene: &scene,
            sinks: recorder.iter_mut().map(|recorder| recorder as &mut dyn Sink).collect(),
            also: None,
            threads: request.threads,
            interrupt: request.interrupt,
            progress: &mut |_| {},
        })?;
        self.wall_s.push(result.wall_s);
        self.cpu_s.extend(result.cpu_s);
        self.recording_bytes = request.recording.and_then(|path| path.metadata().ok()).map(|file| file.len());
        self.latest = Some(result);
        Ok(())
    }

    /// What its plan left out and could put back.
    fn switches(&self) -> Vec<Keep> {
        let left_out = self.latest.iter().flat_map(|result| &result.plan_report.left_out);
        let mut switches: Vec<Keep> = left_out.filter_map(|l| l.switch).collect();
        switches.sort_unstable();
        switches.dedup();
        switches
    }

    /// The row of the table, compared with the runs of `base`; `None` before the first run.
    fn row(&self, base: &Self) -> Option<LeaveOutRow> {
        let (result, expected) = (self.latest.as_ref()?, base.latest.as_ref()?);
        let difference = compare(expected, result);
        let theory = Theory::Bitwise;
        let finished = result.outcome.ending == Ending::Finished;
        Some(LeaveOutRow {
            put_back: self.put_back.clone(),
            ending: ending_name(&result.outcome.ending),
            steps: result.outcome.steps,
            element_steps: result.outcome.swept_element_steps,
            wall_s: median(&self.wall_s).unwrap_or(f64::NAN),
            cpu_s: median(&self.cpu_s),
            memory_bytes: result.plan_report.memory_bytes,
            recording_bytes: self.recording_bytes,
            holds: finished && difference == Difference::Bitwise,
            difference,
            theory,
        })
    }
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len().is_multiple_of(2) { 0.5 * (sorted[middle - 1] + upper) } else { upper })
}

/// The largest difference of all that a run ends with.
fn compare(expected: &RunResult, got: &RunResult) -> Difference {
    let (expected, got) = (quantities(expected), quantities(got));
    let mut largest = Difference::Bitwise;
    for ((name, a), (_, b)) in expected.iter().zip(&got) {
        let Some(relative) = relative_difference(a, b) else { continue };
        if !matches!(largest, Difference::Rounding { largest_relative, .. } if largest_relative >= relative) {
            largest = Difference::Rounding { largest_relative: relative, quantity: (*name).to_owned() };
        }
    }
    largest
}

/// Largest |a − b| over the largest |a|; infinite where they are not even as many; `None` when every bit is the same.
fn relative_difference(a: &[f64], b: &[f64]) -> Option<f64> {
    // Adding +0 takes the sign off zeros and leaves all other bits.
    let bits = |x: &f64| (x + 0.0).to_bits();
    if a.iter().map(bits).eq(b.iter().map(bits)) {
        return None;
    }
    if a.len() != b.len() {
        return Some(f64::INFINITY);
    }
    let size = a.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    // A NaN against a number is as far apart as can be.
    Some(
        apart.fold(0.0, |most, d| if d.is_nan() { f64::INFINITY } else { d.max(most) })
            / size.max(f64::MIN_POSITIVE),
    )
}

/// What is compared, by name: the final state and its ledger, and the energies.
fn quantities(result: &RunResult) -> [(&'static str, Vec<f64>); 6] {
    let (state, energy) = (&result.state, &result.energy);
    let vectors = |values: &[crate::mechanics::tensor::Vec3]| values.iter().flatten().copied().collect();
    // Pairs that a plan left out are those that never touch: a pair of zeros more or less is no difference.
    let touched = || state.ledger.pairs.iter().filter(|p| p.impulse_n_s.iter().any(|i| *i != 0.0));
    let impulses = touched().flat_map(|p| p.impulse_n_s).collect();
    let of_pair =
        |p: &crate::step::PairLedger| [p.friction_j, p.numerical_j, p.work_on_slave_j, p.work_on_master_j];
    let of_body = |b: &crate::step::BodyEnergy| {
        [b.kinetic_j, b.strain_j, b.viscous_j, b.contact_work_j, b.external_work_j, b.projection_j]
    };
    [
        ("end time and steps", vec![state.time, state.step as f64]),
        ("displacement", vectors(&state.u)),
        ("velocity", vectors(&state.v)),
        ("impulse", impulses),
        ("energy of the contacts", touched().flat_map(of_pair).collect()),
        ("energy of the bodies", energy.bodies.iter().flat_map(of_body).collect()),
    ]
}

#[cfg(test)]
mod tests;
