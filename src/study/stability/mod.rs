//! Stability: a matrix of stiff and extreme cases and one of ordinary impacts, each finished within its gates or diagnosed.

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

/// Why a cell that was stopped did not finish, and what to do.
const STOPPED: (&str, &str) = (
    "it was stopped by hand.",
    "let it run to its end; if it takes too long, ask for the short matrix, or for no implicit steps as short as the explicit ones",
);

/// How a cell is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stepping {
    /// Central differences.
    Explicit,
    /// The θ scheme at so many times the explicit step.
    Implicit {
        /// Its step over the explicit one.
        step_ratio: u32,
    },
}

impl Stepping {
    /// The explicit scheme, and the implicit one with each of some ratios; a ratio of none is left out.
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

/// What became of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It came to its end within its gates.
    Finished,
    /// It was refused before the run, with a reason.
    Refused,
    /// It ended with a diagnosis.
    Diagnosed,
    /// It gave a number that is none, or grew without being noticed: a defect.
    Wrong,
}

/// One cell of the matrix.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// What is varied.
    pub axis: String,
    /// Its value.
    pub value: String,
    /// How it was integrated.
    pub stepping: Stepping,
    /// Whether such an impact could happen.
    pub is_physical: bool,
    /// What became of it.
    pub verdict: Verdict,
    /// `finished`, `refused`, or the cause of the failure.
    pub ending: String,
    /// Why it did not finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// Largest error of the energy balance [-].
    pub balance_error: f64,
    /// Largest total energy over that of the start [-].
    pub growth: f64,
    /// Numerical contact dissipation, as a share of the energy [-].
    pub contact_loss: f64,
    /// Smallest Jacobian.
    pub smallest_jacobian: f64,
    /// Deepest that a contact was inside when a step began, over the shortest edge [-].
    pub penetration: f64,
    /// Deepest that a node or element was inside another body at the field times, over the size of a face [-].
    pub face_penetration: f64,
    /// Largest deflection of the tissue's skin [m].
    pub deflection_m: f64,
    /// Share of the simulated time that was reached; all of it where contact is over.
    pub reached: f64,
    /// Steps.
    pub steps: u64,
    /// Wall time of the run [s].
    pub wall_s: f64,
}

/// The matrix.
#[derive(Clone, Debug, Serialize)]
pub struct StabilityStudy {
    /// The cells.
    pub cells: Vec<Cell>,
    /// Cells that could happen.
    pub physical: usize,
    /// Those of them that finished within their gates.
    pub physical_finished: usize,
    /// Cells without a finish and without a diagnosis: must be none.
    pub wrong: usize,
    /// Why it was stopped before its end: `cancelled` or `deadline`; absent when it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<String>,
}

/// Runs each case with each stepping, so many cases side by side; the cells are in the order of the cases.
pub fn study_stability(
    cases: &[Case],
    steppings: &[Stepping],
    threads: usize,
    interrupt: &(dyn Fn() -> Option<Interrupt> + Sync),
    progress: &mut dyn FnMut(&Cell),
) -> StabilityStudy {
    let (next, is_stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
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

/// The case whose turn it is, with its number.
fn take_next<'a>(next: &AtomicUsize, cases: &'a [Case]) -> (usize, Option<&'a Case>) {
    let index = next.fetch_add(1, Ordering::Relaxed);
    (index, cases.get(index))
}

/// `explicit`: what the case is compiled to with explicit steps.
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

/// A case that is ready to be run.
struct Compiled {
    plan: Plan,
    /// [m]
    shortest_edge: f64,
}

/// Why a case is not run, and what to do.
struct Refusal {
    reason: String,
    remedy: String,
}

/// A case with implicit steps of so many explicit ones.
fn compiled_implicit(case: &Case, explicit: &Compiled, step_ratio: u32) -> Result<Compiled, Refusal> {
    let mut document = case.document.clone();
    let plan = &explicit.plan;
    // Two steps at the least, or nothing is stepped.
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
    let edges = loaded.bodies.iter().map(|body| body.min_edge_m).filter(|edge| *edge > 0.0);
    let shortest_edge = edges.fold(f64::INFINITY, f64::min);
    let plan = compile(&loaded.scene).map_err(|error| internal(error.to_string()))?;
    Ok(Compiled { plan, shortest_edge })
}

/// Runs a plan, to the end of contact if that is asked for; the rest of the cell is in `blank`.
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
    // A run that was stopped failed in nothing.
    let stopped = (*ending == Ending::Cancelled).then_some(STOPPED);
    // Numbers of bodies that are in each other would be withheld.
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
        face_penetration: watch.penetration.deepest.share,
        deflection_m: watch.deflection.largest,
        reached: if is_over() { 1.0 } else { outcome.time_s / plan.end_time },
        steps: outcome.steps,
        wall_s: clock.elapsed().as_secs_f64(),
        ..blank.clone()
    }
}
