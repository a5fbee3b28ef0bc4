//! Runs cases on worker threads: each run has one thread, results come in the order of the cases.

use super::super::error_bars::error_bars;
use super::super::single::{ending_name, is_stop, measures_of};
use super::base_facts::BaseFacts;
use super::cache::{Cache, Numbers, key};
use super::case_answer::{FINISHED, NOTHING_TOUCHED};
use super::cases::Case;
use super::document::WhatIfDocument;
use crate::measure::QuantityOfInterest;
use crate::measure::depth_profile::DepthProfile;
use crate::measure::summary::{ErrorEstimate, Shown, lower_bounds};
use crate::measure::{ErrorBars, MeasuringRecorder, Summary};
use crate::plan::{CompileError, Plan, compile, recompile};
use crate::scene::document::ErrorBarsDocument;
use crate::scene::{Budget, MeshSource, Scene, load_document, with_motion};
use crate::step::{Ending, Interrupt, Outcome, RunOptions, run};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;

/// Context shared by all runs of a question.
pub(super) struct Runner<'a> {
    pub question: &'a WhatIfDocument,
    /// Base scene with the settings of the cases, see [`Case::scene`].
    pub base: &'a Scene,
    pub facts: &'a BaseFacts<'a>,
    pub source: &'a (dyn MeshSource + Sync),
    pub budget: &'a Budget,
    pub cache: &'a Cache,
    /// Whether meshes and plans are reused between cases that differ in motion only.
    pub shares_plans: bool,
    /// Depths below which stresses are requested [m], ascending.
    pub depths: Vec<f64>,
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
}

/// One run to make.
#[derive(Clone, Copy)]
pub(super) struct Task<'a> {
    pub case: &'a Case,
    /// Whether it has its own error bars.
    pub with_errors: bool,
}

/// Result of a run, and whether it came from the cache.
#[derive(Clone, Debug)]
pub(super) struct Answered {
    pub numbers: Numbers,
    pub from_cache: bool,
}

/// Data kept by a thread between cases: the latest scene and its plan.
#[derive(Default)]
pub(super) struct Memory(Option<(Plan, Scene)>);

impl Runner<'_> {
    /// Answers all tasks; `report` receives the answers in the order of the tasks, as soon as they and all before them
    /// are ready. After the first interrupted task no more are delivered.
    pub fn answer_all(&self, tasks: &[Task], threads: usize, report: &mut dyn FnMut(usize, Answered)) {
        let next = AtomicUsize::new(0);
        let (sender, receiver) = channel();
        std::thread::scope(|scope| {
            for _ in 0..threads.clamp(1, tasks.len().max(1)) {
                let (sender, next) = (sender.clone(), &next);
                scope.spawn(move || {
                    let mut memory = Memory::default();
                    while let Some((index, task)) = self.take(tasks, next) {
                        let answer = self.answer(&task, 1, &mut memory);
                        // The receiver is dropped only if this thread's own scope has unwound.
                        let _ = sender.send((index, answer));
                    }
                });
            }
            drop(sender);
            let (mut waiting, mut first) = (BTreeMap::new(), 0);
            for (index, answer) in receiver {
                waiting.insert(index, answer);
                // An interrupted task ends the sequence: no case is delivered without those before it.
                while let Some(Some(answer)) = waiting.remove(&first) {
                    report(first, answer);
                    first += 1;
                }
            }
        });
    }

    fn take<'t>(&self, tasks: &[Task<'t>], next: &AtomicUsize) -> Option<(usize, Task<'t>)> {
        if (self.interrupt)().is_some() {
            return None;
        }
        let index = next.fetch_add(1, Ordering::Relaxed);
        tasks.get(index).map(|task| (index, *task))
    }

    /// Answers one task; `None` if it was interrupted.
    pub fn answer(&self, task: &Task, threads: usize, memory: &mut Memory) -> Option<Answered> {
        let scene = match self.scene(task, memory) {
            Ok(scene) => scene,
            Err(reason) => return Some(Answered { numbers: invalid(reason), from_cache: false }),
        };
        let key = key(&scene, task.with_errors, &self.depths);
        if let Some(numbers) = self.cache.get(&key) {
            return Some(Answered { numbers, from_cache: true });
        }
        let numbers = self.run(&scene, task.with_errors, threads, memory)?;
        self.cache.put(&key, &numbers);
        Some(Answered { numbers, from_cache: false })
    }

    /// Scene of a task; reuses the meshes of the base or of the previous case if possible.
    fn scene(&self, task: &Task, memory: &Memory) -> Result<Scene, String> {
        let document = task
            .case
            .scene(self.question, &self.base.document, self.facts)
            .map_err(|(_, misfit)| misfit.message)?;
        let known = [Some(self.base), memory.0.as_ref().map(|(_, scene)| scene)];
        let shared = known
            .into_iter()
            .flatten()
            .filter(|_| self.shares_plans)
            .find_map(|scene| with_motion(scene, &document, self.budget));
        let loaded = match shared {
            Some(scene) => scene,
            None => load_document(document, self.source, self.budget).map(|loaded| loaded.scene),
        };
        loaded.map_err(|problems| {
            let first = problems.0.iter().find(|problem| problem.is_error()).map(ToString::to_string);
            first.unwrap_or_else(|| problems.to_string())
        })
    }

    fn plan(&self, scene: &Scene, memory: &mut Memory) -> Result<Plan, CompileError> {
        match memory.0.take().filter(|_| self.shares_plans) {
            Some((plan, before)) => recompile(plan, &before, scene),
            None => compile(scene),
        }
    }

    fn run(&self, scene: &Scene, with_errors: bool, threads: usize, memory: &mut Memory) -> Option<Numbers> {
        let plan = match self.plan(scene, memory) {
            Ok(plan) => plan,
            Err(error) => return Some(invalid(error.to_string())),
        };
        let bars = if with_errors { self.error_bars(scene, threads) } else { ErrorBars::NotRequested };
        let mut measuring =
            MeasuringRecorder::new(measures_of(scene, &plan).with_error_bars(bars.clone(), None));
        let mut profile = DepthProfile::new(self.depths.clone());
        let options = RunOptions { threads, interrupt: self.interrupt };
        let (outcome, _) = run(&plan, &options, &mut [&mut measuring, &mut profile]);
        let summary = measuring.summary(&plan, &outcome);
        memory.0 = Some((plan, scene.clone()));
        let is_stopped = is_stop(&ending_name(&outcome.ending));
        let mut numbers = numbers(&outcome, &summary);
        if numbers.ending == FINISHED {
            numbers.von_mises_below_pa = profile.peaks_from_each();
            numbers.von_mises_below_error_pa = errors_below(&numbers, &bars);
        }
        (!is_stopped).then_some(numbers)
    }

    fn error_bars(&self, scene: &Scene, threads: usize) -> ErrorBars {
        let mut asking = scene.clone();
        asking.document.solver.error_bars = ErrorBarsDocument::TwoLevels;
        error_bars(&asking, &self.depths, threads, self.interrupt)
    }
}

fn invalid(reason: String) -> Numbers {
    Numbers {
        ending: "invalid".into(),
        reason: Some(reason),
        steps: 0,
        values: BTreeMap::new(),
        errors: BTreeMap::new(),
        unresolved: BTreeSet::new(),
        reaches: Vec::new(),
        lower_bounds: BTreeSet::new(),
        von_mises_below_pa: Vec::new(),
        von_mises_below_error_pa: Vec::new(),
    }
}

/// Errors of the stresses below each depth [Pa]; empty if not requested.
fn errors_below(numbers: &Numbers, bars: &ErrorBars) -> Vec<Option<f64>> {
    let ErrorBars::From(runs) = bars else { return Vec::new() };
    let error = |(index, own): (usize, &f64)| runs.error_below(index, *own, numbers.steps);
    numbers.von_mises_below_pa.iter().enumerate().map(error).collect()
}

/// Numbers to keep of a run. A run that did not finish, failed its checks, or had no contact has none.
fn numbers(outcome: &Outcome, summary: &Summary) -> Numbers {
    let (ending, reason) = match (&outcome.ending, &summary.results) {
        (Ending::Failed { failure }, _) => (ending_name(&outcome.ending), Some(failure.message.clone())),
        (Ending::Finished, Shown::Withheld { reason, .. }) => ("withheld".into(), Some(reason.clone())),
        (Ending::Finished, Shown::Results(values)) if values.nothing_touched => {
            (NOTHING_TOUCHED.into(), Some("there was no impact that the numbers could describe".into()))
        }
        (ending, _) => (ending_name(ending), None),
    };
    // Only a finished run with contact has numbers.
    let is_good = ending == FINISHED;
    let of = |q: QuantityOfInterest| q.number(summary.values()).filter(|_| is_good).map(|number| (q, number));
    let all = || QuantityOfInterest::ALL.into_iter().filter_map(of);
    let values = summary.values();
    let tissue = values.tissue.as_ref().filter(|_| is_good);
    let significant =
        tissue.and_then(|tissue| tissue.significant_stress.get(values.headline.significant_stress?));
    Numbers {
        ending,
        reason,
        steps: outcome.steps,
        values: all().map(|(q, number)| (q, number.value)).collect(),
        errors: all()
            .filter_map(|(q, number)| match &number.error {
                ErrorEstimate::Estimated(error) => Some((q, error.total)),
                ErrorEstimate::NotEstimated | ErrorEstimate::NothingTouched => None,
            })
            .collect(),
        unresolved: all().filter(|(_, number)| number.error.is_unresolved()).map(|(q, _)| q).collect(),
        reaches: significant.map_or_else(Vec::new, |stress| stress.depth_reaches.clone()),
        lower_bounds: if is_good { lower_bounds(values) } else { BTreeSet::new() },
        von_mises_below_pa: Vec::new(),
        von_mises_below_error_pa: Vec::new(),
    }
}
