//! Stability study: a matrix of stiff and extreme cases and one of ordinary impacts, each of which must finish within
//! its limits or be diagnosed.

mod ordinary;
mod picture;
mod scenes;
mod watch;

pub use ordinary::ordinary_impacts;
pub use picture::picture;
pub use scenes::{Case, cases};

use super::single::{ending_name, is_stop};
use crate::measure::penetration::TOO_DEEP;
use crate::mechanics::tensor::Vec3;
use crate::plan::{Plan, compile};
use crate::scene::{Budget, NoFiles, load_parsed};
use crate::step::{Ending, Interrupt, RunOptions, run};
use serde::Serialize;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::time::Instant;
use watch::Watch;

/// Reason and remedy for a cell that was stopped by the user.
const STOPPED: (&str, &str) = (
    "it was stopped by hand.",
    "let it finish; if it takes too long, request the short matrix, or omit implicit steps as short as the explicit ones",
);

/// Time integration of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stepping {
    /// Central differences, the default explicit scheme.
    Explicit,
    /// The θ scheme at a multiple of the explicit step.
    Implicit {
        /// Ratio of its step to the explicit one.
        step_ratio: u32,
    },
}

impl Stepping {
    /// The explicit scheme, and the implicit one with each of some step ratios; a ratio of zero is omitted.
    pub fn with_implicit(step_ratios: &[u32]) -> Vec<Self> {
        let implicit = step_ratios.iter().filter(|ratio| **ratio > 0);
        let implicit = implicit.map(|step_ratio| Self::Implicit { step_ratio: *step_ratio });
        std::iter::once(Self::Explicit).chain(implicit).collect()
    }
}

impl std::fmt::Display for Stepping {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Explicit => f.write_str("explicit"),
            Self::Implicit { step_ratio } => write!(f, "implicit, step × {step_ratio}"),
        }
    }
}

/// Verdict on a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The run finished within its limits.
    Finished,
    /// The scene was refused before the run, with a reason.
    Refused,
    /// The run ended with a diagnosis.
    Diagnosed,
    /// The run gave NaN, or grew unnoticed: a defect.
    Wrong,
}

/// One cell of the matrix.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// Name of the varied parameter.
    pub axis: String,
    /// Value of the parameter.
    pub value: String,
    /// Time integration of the cell.
    pub stepping: Stepping,
    /// Whether such an impact is physically possible.
    pub is_physical: bool,
    /// Verdict on the case.
    pub verdict: Verdict,
    /// `finished`, `refused`, or the cause of the failure.
    pub ending: String,
    /// Why it did not finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Remedy suggested by the diagnosis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// Largest error of the energy balance [-].
    pub balance_error: f64,
    /// Largest total energy over the initial total energy [-].
    pub growth: f64,
    /// Numerical contact dissipation over the energy scale [-].
    pub contact_loss: f64,
    /// Smallest Jacobian J [-].
    pub smallest_jacobian: f64,
    /// Deepest penetration of a contact at the start of a step, over the shortest edge [-].
    pub penetration: f64,
    /// Deepest penetration of a node or element at the field times, over the face size [-].
    pub face_penetration: f64,
    /// Largest deflection of the tissue's surface [m].
    pub deflection_m: f64,
    /// Fraction of the simulated time reached; 1 if contact is over.
    pub reached: f64,
    /// Number of steps of the run.
    pub steps: u64,
    /// Wall time of the run [s].
    pub wall_s: f64,
}

/// Results of the whole matrix.
#[derive(Clone, Debug, Serialize)]
pub struct StabilityStudy {
    /// Cells in the order of the cases.
    pub cells: Vec<Cell>,
    /// Number of physically possible cells.
    pub physical: usize,
    /// Number of those that finished within their limits.
    pub physical_finished: usize,
    /// Number of cells that neither finished nor were diagnosed: must be zero.
    pub wrong: usize,
    /// Why it was stopped early: `cancelled` or `deadline`; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<String>,
}

/// Runs each case with each time integration, several cases in parallel; the cells are in the order of the cases.
pub fn study_stability(
    cases: &[Case],
    steppings: &[Stepping],
    threads: usize,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
    progress: &mut dyn FnMut(&Cell),
) -> StabilityStudy {
    let (next, is_stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    // Each thread takes the next case and runs all its time integrations.
    let run_cases = &|ended: Sender<(usize, Cell)>| {
        while let (index, Some(case)) = take_next(&next, cases) {
            let explicit = compiled(&case.document);
            for stepping in steppings {
                if is_stopped.load(Ordering::Relaxed) {
                    return;
                }
                let cell = eval_cell(case, explicit.as_ref(), *stepping, interrupt);
                is_stopped.fetch_or(is_stop(&cell.ending), Ordering::Relaxed);
                if ended.send((index, cell)).is_err() {
                    return;
                }
            }
        }
    };
    let mut done: Vec<(usize, Cell)> = Vec::new();
    std::thread::scope(|scope| {
        let (sender, ended) = channel();
        for sender in vec![sender; threads.max(1)] {
            scope.spawn(move || run_cases(sender));
        }
        done.extend(ended.into_iter().inspect(|(_, cell)| progress(cell)));
    });
    // Restore the order of the cases.
    done.sort_by_key(|(index, _)| *index);
    let cells: Vec<Cell> = done.into_iter().map(|(_, cell)| cell).collect();
    let physical = cells.iter().filter(|c| c.is_physical);
    StabilityStudy {
        physical: physical.clone().count(),
        physical_finished: physical.filter(|c| c.verdict == Verdict::Finished).count(),
        wrong: cells.iter().filter(|c| c.verdict == Verdict::Wrong).count(),
        stopped: cells.iter().map(|c| &c.ending).find(|ending| is_stop(ending)).cloned(),
        cells,
    }
}

/// Next case to run, with its index.
fn take_next<'a>(next: &AtomicUsize, cases: &'a [Case]) -> (usize, Option<&'a Case>) {
    let index = next.fetch_add(1, Ordering::Relaxed);
    (index, cases.get(index))
}

/// `explicit`: the case compiled with explicit steps.
fn eval_cell(
    case: &Case,
    explicit: Result<&Compiled, &Refusal>,
    stepping: Stepping,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
) -> Cell {
    let cell = Cell {
        axis: case.axis.clone(),
        value: case.label.clone(),
        stepping,
        is_physical: case.is_physical,
        verdict: Verdict::Refused,
        ending: "refused".into(),
        reason: None,
        remedy: None,
        balance_error: 0.0,
        growth: 1.0,
        contact_loss: 0.0,
        smallest_jacobian: 1.0,
        penetration: 0.0,
        face_penetration: 0.0,
        deflection_m: 0.0,
        reached: 0.0,
        steps: 0,
        wall_s: 0.0,
    };
    let refused = |refusal: &Refusal| Cell {
        reason: Some(refusal.reason.clone()),
        remedy: Some(refusal.remedy.clone()),
        ..cell.clone()
    };
    let ran = |compiled: &Compiled| run_cell(compiled, case.ends_with_contact, interrupt, &cell);
    match (explicit, stepping) {
        (Err(refusal), _) => refused(refusal),
        (Ok(explicit), Stepping::Explicit) => ran(explicit),
        (Ok(explicit), Stepping::Implicit { step_ratio }) => {
            compiled_implicit(case, explicit, step_ratio).as_ref().map_or_else(refused, ran)
        }
    }
}

/// A case ready to run.
struct Compiled {
    plan: Plan,
    /// Shortest element edge [m].
    shortest_edge: f64,
}

/// Why a case is not run, and the remedy.
struct Refusal {
    reason: String,
    remedy: String,
}

/// A case with implicit steps of `step_ratio` explicit ones.
fn compiled_implicit(case: &Case, explicit: &Compiled, step_ratio: u32) -> Result<Compiled, Refusal> {
    let mut document = case.document.clone();
    let plan = &explicit.plan;
    // At least two steps.
    let step = (f64::from(step_ratio) * plan.report.stable_step_s).min(0.5 * plan.end_time);
    document["integrator"] = json!({"kind": "implicit", "step_s": step});
    compiled(&document)
}

fn compiled(document: &Value) -> Result<Compiled, Refusal> {
    let internal = |reason: String| Refusal { reason, remedy: "report this scene".into() };
    let loaded =
        load_parsed(&document.clone().into(), &NoFiles, &Budget::COMMAND_LINE).map_err(|problems| {
            problems.first_error().map_or_else(
                || internal("refused without a reason".into()),
                |p| Refusal { reason: format!("{}: {}", p.pointer, p.message), remedy: p.remedy.clone() },
            )
        })?;
    // Rigid bodies have no edges.
    let edges =
        loaded.bodies.iter().filter_map(|body| body.quality.as_ref()).map(|quality| quality.min_edge_m);
    let shortest_edge = edges.fold(f64::INFINITY, f64::min);
    let plan = compile(&loaded.scene).map_err(|error| internal(error.to_string()))?;
    Ok(Compiled { plan, shortest_edge })
}

/// Runs a plan, to the end of contact if requested; `blank` provides the rest of the cell.
fn run_cell(
    Compiled { plan, shortest_edge }: &Compiled,
    ends_with_contact: bool,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
    blank: &Cell,
) -> Cell {
    let clock = Instant::now();
    let contact_is_over = AtomicBool::new(false);
    let is_over = || ends_with_contact && contact_is_over.load(Ordering::Relaxed);
    let interrupt = || interrupt().or_else(|| is_over().then_some(Interrupt::Cancel));
    let mut watch = Watch::new(&contact_is_over);
    let (outcome, state) = run(plan, &RunOptions { threads: 1, interrupt: &interrupt }, &mut [&mut watch]);
    // A finished run with non-finite results is wrong.
    let is_sound = |all: &[Vec3]| all.iter().all(|v| v.iter().all(|x| x.is_finite()));
    let is_finite = is_sound(&state.u) && is_sound(&state.v) && outcome.balance_error.is_finite();
    let ending = match &outcome.ending {
        Ending::Cancelled if is_over() => &Ending::Finished,
        ending => ending,
    };
    let failure = match ending {
        Ending::Failed { failure } => Some(failure),
        Ending::Finished | Ending::Cancelled => None,
    };
    // A stopped run has not failed.
    let stopped = (*ending == Ending::Cancelled).then_some(STOPPED);
    // Numbers of interpenetrating bodies would be withheld.
    let overlap = watch.penetration.excess().filter(|_| *ending == Ending::Finished);
    let verdict = match (ending, is_finite) {
        (Ending::Finished, false) => Verdict::Wrong,
        (Ending::Finished, true) if overlap.is_none() => Verdict::Finished,
        _ => Verdict::Diagnosed,
    };
    let is_deep = overlap.is_some();
    let reason = overlap.clone().or_else(|| failure.map(|f| f.message.clone()));
    let remedy = overlap.map(|_| TOO_DEEP).or(failure.map(|f| f.remedy.as_str()));
    Cell {
        verdict,
        ending: if is_deep { "bodies overlap".into() } else { ending_name(ending) },
        reason: reason.or(stopped.map(|(reason, _)| reason.to_owned())),
        remedy: remedy.or(stopped.map(|(_, remedy)| remedy)).map(str::to_owned),
        balance_error: outcome.balance_error,
        growth: watch.growth(),
        contact_loss: watch.contact_loss(),
        smallest_jacobian: outcome.smallest_jacobian,
        penetration: watch.deepest / shortest_edge,
        face_penetration: watch.penetration.deepest.fraction,
        deflection_m: watch.deflection.largest,
        reached: if is_over() { 1.0 } else { outcome.time_s / plan.end_time },
        steps: outcome.steps,
        wall_s: clock.elapsed().as_secs_f64(),
        ..blank.clone()
    }
}
