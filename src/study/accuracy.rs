//! Runs a scene on successively finer meshes until its numbers are as accurate as requested or the time is over.
//!
//! Each run is one level; the two before it give its error bars, so the only additional runs are one with smaller steps
//! and one with a looser contact tolerance on the coarser of these. Generated meshes get √2 times the numbers of
//! elements from one level to the next, above the scene's own 2, 3, 4, 6 … times its own where √2 cannot refine every direction; meshes
//! from a file have every element split into eight.

use super::bulk_modulus_choice::{BulkModulusEffect, lower};
use super::clock::Clock;
use super::levels::{Ahead, Done, LEVELS_USED, LevelMesh, Meshes};
use super::precision::in_single_precision;
use super::progress::{AccuracyProgress, Phase, Progress};
use super::single::{RunError, RunRequest, RunResult, ending_name, is_stop, run_plan};
use crate::measure::summary::Shown;
use crate::measure::{Compared, ErrorBars, MeasuredEnd, MeasuredFrame, RequestedAccuracy, Sink, Summary};
use crate::plan::{Plan, compile};
use crate::scene::document::AccuracyDocument;
use crate::step::{Ending, Interrupt, Recorder, RecorderError};
use std::cell::OnceCell;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs a scene to an accuracy. The result is that of the finest mesh whose run came to its end within the time, and it is the run
/// that the sinks hold.
///
/// # Errors
/// As for a single run.
pub(super) fn run_to(mut request: RunRequest, requested: &AccuracyDocument) -> Result<RunResult, RunError> {
    let (threads, interrupt) = (request.threads, request.interrupt);
    let mut clock = Clock::new(requested);
    // A finer mesh may be stopped by the time; the first one runs to its end.
    let (has_result, discards) = (AtomicBool::new(false), AtomicBool::new(false));
    let wall = clock.wall();
    let stop = || wall.interrupt(interrupt(), has_result.load(Ordering::Relaxed), &discards);
    // The scene itself, or with other bulk moduli.
    let mut scene = in_single_precision(request.scene);
    let mut bulk_modulus = OnceCell::new();
    if requested.lower_bulk_modulus {
        let meshes = Meshes::of(&scene, threads, &stop);
        let lowered = lower((&scene, &meshes.first().scene), requested, &meshes.variants, &mut clock);
        let warning = lowered.as_ref().err().map(|why| format!("The bulk moduli are not lowered: {why}"));
        let (change, lowered) = lowered.ok().unzip();
        scene = lowered.map_or(scene, |lowered| in_single_precision(&lowered));
        bulk_modulus = OnceCell::from(BulkModulusEffect { change, warning });
    }
    let mut meshes = Meshes::of(&scene, threads, &stop);
    meshes.bulk_modulus = bulk_modulus;
    // The meshes one after the other.
    let mut next = meshes.first();
    let mut sequence = Sequence::of(meshes, clock, requested, [&has_result, &discards]);
    loop {
        match sequence.run_level(&mut request, next)? {
            Step::Next(mesh) => next = *mesh,
            Step::End(result) => return Ok(*result),
        }
    }
}

/// The levels up to one.
struct Sequence<'a> {
    meshes: Meshes<'a>,
    clock: Clock,
    requested: &'a AccuracyDocument,
    /// Those that may serve error bars.
    done: Vec<Done>,
    /// Result of the last of them.
    best: Option<RunResult>,
    /// By how much checks of the latest level were missed, if its results are withheld: see [`Summary::excess`].
    missed_by: Option<f64>,
    place: AccuracyProgress,
    /// What the level is expected to take, and when it began [s].
    expected_s: Option<f64>,
    started_s: f64,
    has_result: &'a AtomicBool,
    discards: &'a AtomicBool,
}

/// By how much a failed check must come down from one mesh to the next for a finer one to be expected to pass it [-].
const NEARER: f64 = 0.9;

/// What follows a level.
enum Step {
    Next(Box<LevelMesh>),
    End(Box<RunResult>),
}

impl<'a> Sequence<'a> {
    fn of(
        meshes: Meshes<'a>,
        clock: Clock,
        requested: &'a AccuracyDocument,
        [has_result, discards]: [&'a AtomicBool; 2],
    ) -> Self {
        Self {
            meshes,
            requested,
            done: Vec::new(),
            best: None,
            missed_by: None,
            place: AccuracyProgress { run: 0, mesh_factor: 1.0, requested: requested.relative, before: None },
            expected_s: None,
            started_s: clock.elapsed_s(),
            clock,
            has_result,
            discards,
        }
    }

    /// Runs a level, and decides what follows.
    fn run_level(&mut self, request: &mut RunRequest, mut mesh: LevelMesh) -> Result<Step, RunError> {
        // What it and the next are expected to take; of the first mesh the next is made in advance, to know whether both can be run.
        let growth = self.meshes.growth_of_time(&mesh, self.done.last(), None);
        let mut ahead = Ahead { next: None, growth };
        let mut is_only = false;
        if self.clock.is_estimated() && self.done.is_empty() {
            let own_s = self.expected_s.map_or_else(|| mesh.expected_s(), Ok)?;
            let is_over_after = |next_s| self.clock.is_over_after(own_s + next_s);
            ahead = self.meshes.look_ahead(is_over_after, own_s, mesh.level);
            is_only = self.clock.is_over_after((1.0 + ahead.growth) * own_s);
        }
        if is_only && mesh.level < 0 {
            // Two levels are too many: the scene's own mesh, with the error bars of any run.
            return Ok(Step::Next(Box::new(self.meshes.own())));
        }
        let without_bars_s = self.clock.elapsed_s();
        let bars = self.meshes.bars(&self.done, &mut mesh, is_only, self.requested);
        let bars_s = self.clock.elapsed_s() - without_bars_s;
        let (result, must) = self.run(request, &mut mesh, bars, ahead.growth)?;
        self.clock.count(&result.plan_report, result.outcome.steps);
        let seconds = self.clock.elapsed_s() - self.started_s - bars_s;
        Ok(self.step_after(mesh, result, must, ahead, seconds))
    }

    /// Runs a level with its error bars; the next takes `growth` times as long. Results that are withheld are no answer where there is one.
    fn run(
        &mut self,
        request: &mut RunRequest,
        mesh: &mut LevelMesh,
        bars: ErrorBars,
        growth: f64,
    ) -> Result<(RunResult, Must), RunError> {
        let mesh_factor = self.meshes.factor(mesh.level);
        let accuracy = RequestedAccuracy {
            relative: self.requested.relative,
            of: self.requested.of.clone(),
            mesh_factor,
            next_s: self.expected_s.map(|seconds| growth * seconds).filter(|seconds| seconds.is_finite()),
            is_estimated: self.clock.is_estimated(),
        };
        let (next_s, expected_s) = (accuracy.next_s, self.expected_s.unwrap_or_default());
        let is_last = next_s.is_some_and(|next| self.clock.is_over_after(next + expected_s));
        let must = Must {
            finish: mesh.level > 0 && self.best.is_some(),
            show: self.best.as_ref().is_some_and(|best| !is_withheld(&best.summary)),
        };
        self.place = AccuracyProgress { run: self.place.run + 1, mesh_factor, ..self.place };
        let (discards, interrupt) = (self.discards, self.meshes.variants.interrupt);
        let clock = self.best.as_ref().map(|_| &self.clock);
        let run = LevelRun { place: self.place, is_last, must, discards, interrupt, clock };
        let result = run.run(request, mesh, accuracy, bars)?;
        self.place.before = largest_error(&result);
        Ok((result, must))
    }

    /// What follows a level that took so many `seconds`: the next, unless it is accurate enough, or there is nothing that a finer mesh would
    /// show, or no time.
    fn step_after(
        &mut self,
        mesh: LevelMesh,
        mut result: RunResult,
        must: Must,
        mut ahead: Ahead,
        seconds: f64,
    ) -> Step {
        let (level, coarser) = (mesh.level, self.done.len());
        let missed_by = result.summary.excess().filter(|_| is_withheld(&result.summary));
        let again = missed_by.zip(self.missed_by).is_some_and(|(now, before)| now > NEARER * before);
        self.missed_by = missed_by;
        let is_stopped = self.discards.load(Ordering::Relaxed);
        let lacks = must.lacks(&result).filter(|_| !is_stopped);
        let has_stopped = is_good_enough(&result, level, coarser, again);
        if self.clock.is_estimated() && ahead.next.is_none() && !has_stopped {
            let own_s = self.expected_s.unwrap_or(seconds);
            ahead = self.meshes.look_ahead(|next_s| self.clock.is_over_after(next_s), own_s, level);
        } else if !self.clock.is_estimated() {
            ahead.growth = self.meshes.growth_of_time(&mesh, self.done.last(), Some(seconds));
        }
        let Ahead { next, growth } = ahead;
        let is_over = is_over(&self.clock, &mut result, coarser, growth * seconds);
        // Of a mesh that is coarser than the scene's own, a discarded run says nothing about the finer ones.
        let is_discarded = is_stopped || (lacks.is_some() && (level >= 0 || is_over || has_stopped));
        if is_discarded && let Some(mut best) = self.best.take() {
            // More time would lead to that mesh again.
            if let Some(accuracy) = best.summary.accuracy.as_mut().filter(|_| lacks.is_some()) {
                accuracy.next_mesh_s = None;
            }
            best.summary.warnings.add_of_accuracy(discarded(self.meshes.factor(level), lacks));
            return Step::End(Box::new(best));
        }
        if is_over && !has_stopped && level < 0 {
            result.summary.warnings.add_of_accuracy(coarser_than_own(self.meshes.factor(level)));
        }
        if lacks.is_none() && (has_stopped || is_over) {
            return Step::End(Box::new(result));
        }
        self.started_s = self.clock.elapsed_s();
        let next = match next.unwrap_or_else(|| self.meshes.at(level + 1)) {
            Ok(next) => next,
            Err(why) => return Step::End(Box::new(without_finer_mesh(result, &why))),
        };
        self.expected_s = Some(growth * seconds);
        // A finished level serves later error bars.
        if result.outcome.ending == Ending::Finished && lacks.is_none() {
            let run = Compared::new(result.summary.values(), Vec::new(), result.outcome.steps);
            self.done.push(Done { level, scene: mesh.scene, run, seconds, others: OnceCell::new() });
            self.best = Some(result);
            self.has_result.store(true, Ordering::Relaxed);
        }
        Step::Next(Box::new(next))
    }
}

/// The run of a level.
struct LevelRun<'a> {
    place: AccuracyProgress,
    /// Whether no other follows, so that its progress is that of all.
    is_last: bool,
    must: Must,
    discards: &'a AtomicBool,
    interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// What limits its steps, once there is a result to fall back on.
    clock: Option<&'a Clock>,
}

impl LevelRun<'_> {
    /// Runs it with the sinks, the recorder and the progress of a request.
    fn run(
        &self,
        request: &mut RunRequest,
        mesh: &mut LevelMesh,
        accuracy: RequestedAccuracy,
        bars: ErrorBars,
    ) -> Result<RunResult, RunError> {
        let plan = mesh.plan.take().map_or_else(|| compile(&mesh.scene), Ok)?;
        let RunRequest { sinks, also, threads, progress, .. } = request;
        let mut report = |p: Progress| {
            let shown = if self.is_last { p } else { Progress::beginning(Phase::EstimatingErrors) };
            progress(Progress { accuracy: Some(self.place), ..shown });
        };
        let most = self.clock.and_then(|clock| clock.most_steps(&plan.report));
        let mut limit = most.map(|most| StepLimit { most, discards: self.discards });
        let discardable = |sink| Discardable { sink, discards: self.discards, must: self.must };
        let mut kept: Vec<_> = sinks.iter_mut().map(|sink| discardable(&mut **sink)).collect();
        let limit = limit.iter_mut().map(|limit| limit as &mut dyn Sink);
        let request = RunRequest {
            scene: &mesh.scene,
            sinks: limit.chain(kept.iter_mut().map(|sink| sink as &mut dyn Sink)).collect(),
            also: also.as_mut().map(|also| &mut **also as &mut dyn Recorder),
            threads: *threads,
            interrupt: &|| {
                let is_over = || self.discards.load(Ordering::Relaxed).then_some(Interrupt::Deadline);
                (self.interrupt)().or_else(is_over)
            },
            progress: &mut report,
        };
        Ok(run_plan(request, plan, bars, Some(accuracy)))
    }
}

/// Whether there is no time for the next level, which takes `next_s` [s] as the summary says. Without any error bar it is tried in whatever
/// time is left.
fn is_over(clock: &Clock, result: &mut RunResult, coarser: usize, next_s: f64) -> bool {
    if let Some(accuracy) = &mut result.summary.accuracy {
        accuracy.next_mesh_s = Some(next_s).filter(|seconds| seconds.is_finite());
    }
    let is_tried = coarser == 0 && !clock.is_estimated();
    clock.is_over_after(if is_tried { 0.0 } else { next_s })
}

/// Whether a level is the last whatever the time, after some `coarser` ones: two meshes may agree by chance. `again`: its results and those of
/// the level before are withheld, and it is hardly nearer to passing.
fn is_good_enough(result: &RunResult, level: i32, coarser: usize, again: bool) -> bool {
    let is_reached = coarser >= LEVELS_USED && has_reached(result);
    let is_final = result.summary.values().nothing_touched || again;
    match &result.outcome.ending {
        // Its results may be withheld where those of a finer one are not: up to twice the numbers of elements are tried.
        Ending::Finished => is_reached || (level >= 2 * i32::from(again) && is_final),
        // A mesh that is too coarse may fail where a finer one does not.
        ending => level >= 0 || is_stop(&ending_name(ending)),
    }
}

/// Whether the error bars are as small as requested.
fn has_reached(result: &RunResult) -> bool {
    result.summary.accuracy.as_ref().is_some_and(|accuracy| accuracy.reached)
}

/// The largest error bar of the requested numbers, as a fraction of each [-]; none where one of them has none.
fn largest_error(result: &RunResult) -> Option<f64> {
    let numbers = &result.summary.accuracy.as_ref()?.numbers;
    numbers.iter().map(|number| number.relative).try_fold(0.0, |most: f64, error| Some(most.max(error?)))
}

fn is_withheld(summary: &Summary) -> bool {
    matches!(summary.results, Shown::Withheld { .. })
}

/// What a run must do to replace that of a coarser mesh.
#[derive(Clone, Copy)]
struct Must {
    /// Finish: on a finer mesh than that of the scene.
    finish: bool,
    /// Have results that are not withheld.
    show: bool,
}

impl Must {
    /// Why a run is discarded: it failed where it must finish, or its results are withheld where they must be shown.
    fn lacks(self, result: &RunResult) -> Option<String> {
        match (&result.outcome.ending, &result.summary.results) {
            (Ending::Failed { failure }, _) if self.finish => Some(format!("failed: {failure}")),
            (_, Shown::Withheld { reason, .. }) if self.show => {
                Some(format!("has results that are withheld: {reason}"))
            }
            _ => None,
        }
    }
}

/// Warning of a finer mesh whose run was discarded.
fn discarded(mesh_factor: f64, failure: Option<String>) -> String {
    let how = failure.unwrap_or_else(|| "exceeded the time".into());
    format!("A finer mesh, with {mesh_factor:.2} times the numbers of elements, gave no result: it {how}.")
}

/// The result on the finest mesh that there is, with a warning if it is not accurate enough.
fn without_finer_mesh(mut result: RunResult, why: &str) -> RunResult {
    if !has_reached(&result) {
        result.summary.warnings.add_of_accuracy(format!(
            "There is no finer mesh to reach the accuracy with: {}.",
            why.trim_end_matches('.')
        ));
    }
    result
}

/// Warning of a mesh that is coarser than the scene's own.
fn coarser_than_own(mesh_factor: f64) -> String {
    format!(
        "The scene's own mesh would take too long: these are the results of one with {mesh_factor:.2} times the numbers of elements; \
         `--as-is` runs the scene's own."
    )
}

/// A sink that has a run discarded once it has taken too many steps. Frames reach it later than they are made, and the run stops later still: what
/// counts is whether there are too many at the end. It is the first of the sinks, so that the others know then.
struct StepLimit<'a> {
    most: u64,
    discards: &'a AtomicBool,
}

impl StepLimit<'_> {
    fn check(&self, steps: u64) {
        self.discards.fetch_or(steps > self.most, Ordering::Relaxed);
    }
}

impl Sink for StepLimit<'_> {
    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        self.check(measured.frame.step);
        Ok(())
    }

    fn finish(&mut self, end: &MeasuredEnd) -> Result<(), RecorderError> {
        self.check(end.outcome.steps);
        Ok(())
    }
}

/// A sink that discards a run which the time or the limit of its steps has stopped, or which does not do what it must.
struct Discardable<'a> {
    sink: &'a mut dyn Sink,
    discards: &'a AtomicBool,
    must: Must,
}

impl Sink for Discardable<'_> {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        self.sink.start(plan)
    }

    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        self.sink.record(measured)
    }

    fn finish(&mut self, end: &MeasuredEnd) -> Result<(), RecorderError> {
        let has_failed = self.must.finish && matches!(end.outcome.ending, Ending::Failed { .. });
        let is_no_answer = self.must.show && is_withheld(end.summary);
        if self.discards.load(Ordering::Relaxed) || has_failed || is_no_answer {
            self.sink.discard();
            return Ok(());
        }
        self.sink.finish(end)
    }
}
