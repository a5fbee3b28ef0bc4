//! Savings of omitted computations, and proof that they change nothing: a scene as compiled, then with each item
//! restored, then with all of them.
//!
//! Whatever a plan omits adds exact zeros, or is never read, so restoring it must preserve every bit of the motion,
//! the impulses and the energies ([`Theory::Bitwise`]); a run that does not is a defect of the program. Mirror images alone follow from what is
//! computed ([`Theory::Symmetric`]).

use super::run::run_scene;
use super::single::{RunError, RunRequest, RunResult, ending_name};
use crate::measure::Sink;
use crate::record::{McapRecorder, RecordingInfo};
use crate::scene::Scene;
use crate::scene::document::{ErrorBarsDocument, Keep};
use crate::step::{Ending, Interrupt};
use serde::Serialize;
use std::path::Path;

/// Subject and settings of the study.
pub struct OmissionsRequest<'a> {
    /// Scene to run; anything it keeps itself is kept in every run.
    pub scene: &'a Scene,
    /// Its document as received, for the recordings.
    pub document_json: &'a [u8],
    /// Runs of each kind, interleaved so that changes of the machine's speed affect all alike; their median counts.
    pub repeat: u32,
    /// Worker threads of each run.
    pub threads: usize,
    /// Path of the recording, overwritten by each run; `None` to record nothing.
    pub recording: Option<&'a Path>,
    /// Called before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Called before each run with its index, the number of runs, and the items that it restores.
    pub progress: &'a mut dyn FnMut(usize, usize, &[Keep]),
}

/// Results of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OmissionsStudy {
    /// Name of the scene.
    pub scene: String,
    /// Runs of each kind.
    pub repeat: u32,
    /// Worker threads of each run.
    pub threads: usize,
    /// Elements of the scene.
    pub elements: usize,
    /// Whether every run finished and agreed with the theory.
    pub holds: bool,
    /// First the scene as compiled, then each item restored alone, then all together if there are several.
    pub rows: Vec<OmissionsRow>,
}

/// Runs of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OmissionsRow {
    /// Items restored in these runs.
    pub restored: Vec<Keep>,
    /// Ending of the runs: `finished`, `cancelled` or the cause of the failure.
    pub ending: String,
    /// Steps of each run.
    pub steps: u64,
    /// Active elements, summed over the steps.
    pub element_steps: u64,
    /// Median wall time [s], compiling, measuring and recording included.
    pub wall_s: f64,
    /// Median processor time [s]; null if the system does not provide it.
    pub cpu_s: Option<f64>,
    /// Approximate memory of a run, estimated by the plan.
    pub memory_bytes: u64,
    /// Bytes of the recording; null when nothing was recorded.
    pub recording_bytes: Option<u64>,
    /// Difference of the results from those of the first row.
    pub difference: Difference,
    /// Difference allowed by the theory.
    pub theory: Theory,
    /// Whether it finished and agrees with the theory.
    pub holds: bool,
}

/// Admissible difference of the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Theory {
    /// None: every bit is the same (except the sign of a zero).
    Bitwise,
    /// At most [`ASYMMETRY`], and steps and velocities are not compared: computed in whole, a symmetric scene is not quite symmetric, since nodes in
    /// a plane of symmetry are held by one of the two faces that they are between.
    Symmetric,
}

/// Largest difference of displacements, impulses and energies of a scene that is computed in whole from one of which a part is, relative to
/// the largest value of the same quantity [-].
pub const ASYMMETRY: f64 = 0.02;

impl Theory {
    /// Of runs with these items restored.
    fn of(restored: &[Keep]) -> Self {
        if restored.contains(&Keep::MirrorImages) { Self::Symmetric } else { Self::Bitwise }
    }
    /// Whether it is about a quantity.
    fn compares(self, quantity: &str) -> bool {
        self == Self::Bitwise || ![STEPS, VELOCITY].contains(&quantity)
    }
    /// Whether it allows a difference.
    fn allows(self, difference: &Difference) -> bool {
        match (self, difference) {
            (_, Difference::Bitwise) => true,
            (Self::Bitwise, Difference::Rounding { .. }) => false,
            (Self::Symmetric, Difference::Rounding { largest_relative, .. }) => {
                *largest_relative <= ASYMMETRY
            }
        }
    }
}

/// Names of quantities that depend on the lengths of the steps.
const STEPS: &str = "end time and steps";
const VELOCITY: &str = "velocity";

/// Observed difference of the results.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Difference {
    /// Every bit of displacement, velocity, impulses and energies is the same.
    Bitwise,
    /// The results differ, if only by rounding.
    Rounding {
        /// Largest difference over the largest value of the same quantity [-].
        largest_relative: f64,
        /// Quantity with that difference.
        quantity: String,
    },
}

/// Runs the study.
///
/// # Errors
/// If the scene cannot be compiled.
pub fn study_omissions(request: &mut OmissionsRequest) -> Result<OmissionsStudy, RunError> {
    let repeat = request.repeat.max(1) as usize;
    // The first run determines the items; then one kind per item, and all together.
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
            (request.progress)(done, count, &kind.restored);
            done += 1;
            // The very first run has determined what there is to restore.
            if (round, i) != (0, 0) {
                kind.run(request)?;
            }
        }
    }
    let rows: Vec<OmissionsRow> = kinds.iter().filter_map(|kind| kind.row(&kinds[0])).collect();
    Ok(OmissionsStudy {
        scene: request.scene.document.name.clone(),
        repeat: request.repeat.max(1),
        threads: request.threads,
        elements: kinds[0].latest.as_ref().map_or(0, |r| r.plan_report.elements),
        holds: rows.iter().all(|row| row.holds),
        rows,
    })
}

/// Completed runs of one kind.
struct Kind {
    restored: Vec<Keep>,
    wall_s: Vec<f64>,
    cpu_s: Vec<f64>,
    recording_bytes: Option<u64>,
    latest: Option<RunResult>,
}

impl Kind {
    fn new(restored: Vec<Keep>) -> Self {
        Self { restored, wall_s: Vec::new(), cpu_s: Vec::new(), recording_bytes: None, latest: None }
    }

    fn run(&mut self, request: &OmissionsRequest) -> Result<(), RunError> {
        let mut scene = request.scene.clone();
        scene.restore(&self.restored);
        // Error bars would be the same, and their cost is not the subject.
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

    /// Items that its plan omitted and could restore.
    fn switches(&self) -> Vec<Keep> {
        let omitted = self.latest.iter().flat_map(|result| &result.plan_report.omitted);
        let mut switches: Vec<Keep> = omitted.filter_map(|l| l.switch).collect();
        switches.sort_unstable();
        switches.dedup();
        switches
    }

    /// Row of the table, compared with the runs of `base`; `None` before the first run.
    fn row(&self, base: &Self) -> Option<OmissionsRow> {
        let (result, expected) = (self.latest.as_ref()?, base.latest.as_ref()?);
        let theory = Theory::of(&self.restored);
        let difference = compare(expected, result, theory);
        let finished = result.outcome.ending == Ending::Finished;
        Some(OmissionsRow {
            restored: self.restored.clone(),
            ending: ending_name(&result.outcome.ending),
            steps: result.outcome.steps,
            element_steps: result.outcome.evaluated_element_steps,
            wall_s: median(&self.wall_s).unwrap_or(f64::NAN),
            cpu_s: median(&self.cpu_s),
            memory_bytes: result.plan_report.memory_bytes,
            recording_bytes: self.recording_bytes,
            holds: finished && theory.allows(&difference),
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

/// Largest difference over all final quantities that a theory compares.
fn compare(expected: &RunResult, got: &RunResult, theory: Theory) -> Difference {
    let (expected, got) = (quantities(expected), quantities(got));
    let mut largest = Difference::Bitwise;
    for ((name, a), (_, b)) in expected.iter().zip(&got).filter(|((name, _), _)| theory.compares(name)) {
        let Some(relative) = relative_difference(a, b) else { continue };
        if !matches!(largest, Difference::Rounding { largest_relative, .. } if largest_relative >= relative) {
            largest = Difference::Rounding { largest_relative: relative, quantity: (*name).to_owned() };
        }
    }
    largest
}

/// Largest |a − b| over the largest |a|; infinite if their lengths differ; `None` if every bit is the same.
fn relative_difference(a: &[f64], b: &[f64]) -> Option<f64> {
    // Adding +0 removes the sign of zeros and preserves all other bits.
    let bits = |x: &f64| (x + 0.0).to_bits();
    if a.iter().map(bits).eq(b.iter().map(bits)) {
        return None;
    }
    if a.len() != b.len() {
        return Some(f64::INFINITY);
    }
    let size = a.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    // A NaN against a number counts as an infinite difference.
    Some(
        apart.fold(0.0, |most, d| if d.is_nan() { f64::INFINITY } else { d.max(most) })
            / size.max(f64::MIN_POSITIVE),
    )
}

/// Compared quantities by name: the final state with its ledger, and the energies.
fn quantities(result: &RunResult) -> [(&'static str, Vec<f64>); 6] {
    let (state, energy) = (&result.state, &result.energy);
    let vectors = |values: &[crate::mechanics::tensor::Vec3]| values.iter().flatten().copied().collect();
    // Pairs omitted by a plan never touch: a pair of zeros makes no difference.
    let touched = || energy.pairs.values().filter(|p| p.impulse_n_s.iter().any(|i| *i != 0.0));
    let impulses = touched().flat_map(|p| p.impulse_n_s).collect();
    let of_pair =
        |p: &crate::step::PairLedger| [p.friction_j, p.numerical_j, p.work_on_slave_j, p.work_on_master_j];
    let of_body = |b: &crate::step::BodyEnergy| {
        [b.kinetic_j, b.strain_j, b.viscous_j, b.contact_work_j, b.external_work_j, b.projection_j]
    };
    [
        (STEPS, vec![state.time, state.step as f64]),
        ("displacement", vectors(&state.u)),
        (VELOCITY, vectors(&state.v)),
        ("impulse", impulses),
        ("energy of the contacts", touched().flat_map(of_pair).collect()),
        ("energy of the bodies", energy.bodies.iter().flat_map(of_body).collect()),
    ]
}

#[cfg(test)]
mod tests;
