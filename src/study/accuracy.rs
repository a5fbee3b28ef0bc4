//! Runs a scene on successively finer meshes until its numbers are as accurate as requested or the time is over.
//!
//! Each run is one level; the two before it give its error bars, so the only additional runs are one with smaller steps
//! and one with a looser contact tolerance on the first mesh of all. Generated meshes get √2 times the numbers of
//! elements from one level to the next, or twice them above the scene's own where √2 cannot refine every direction; meshes from a file
//! have every element split into eight.

use super::bulk_modulus_choice::{BulkModulusEffect, effect_of_cap, lower, untried_cap};
use super::clock::Clock;
use super::error_bars::{compared_runs, error_bars, keeps_a_direction, relative_size, steps_and_contact};
use super::precision::in_single_precision;
use super::progress::{AccuracyProgress, Phase, Progress};
use super::setting::Setting;
use super::single::{RunError, RunRequest, RunResult, ending_name, is_stop, run_plan};
use super::variant::{Variants, split};
use crate::measure::summary::Shown;
use crate::measure::{
    Compared, ComparedRuns, ErrorBars, Level, MeasuredEnd, MeasuredFrame, RequestedAccuracy, Sink, Summary,
};
use crate::plan::{CompileError, Plan, compile};
use crate::scene::document::{AccuracyDocument, MeshDocument, SceneDocument};
use crate::scene::{Budget, Scene};
use crate::step::{Ending, Interrupt, Recorder, RecorderError};
use std::cell::OnceCell;
use std::f64::consts::SQRT_2;
use std::sync::atomic::{AtomicBool, Ordering};

/// Minimum number of elements of the first mesh, if the scene's own has as many [-].
const FEWEST_ELEMENTS: f64 = 100.0;
/// Number of coarser meshes for the error bars, if there are as many.
const LEVELS_USED: usize = 2;
/// Numbers of elements of the coarsest mesh relative to the scene's own [-].
const COARSEST: f64 = 0.25;
/// Most elements of a direction in which √2 times the number is no refinement by √2 (1 stays 1, 2 becomes 3) [-].
const THIN: u32 = 2;
/// Most numbers of elements of a mesh on which the bulk modulus of water is tried, relative to the scene's own [-]: where the scene has 50 MPa, the
/// run takes at most 0.4 of the time of one on the scene's own mesh.
const COARSE: f64 = 0.5;
/// Order of the run time in 1/h: elements and steps.
const ORDER_OF_TIME: f64 = 4.0;
/// The least it can be: a thin direction keeps its elements, and they limit the step.
const LEAST_ORDER_OF_TIME: f64 = 2.0;
/// Factor of safety on a predicted time: contact, and steps limited by strain, grow slightly faster.
const CAUTION: f64 = 1.2;

/// Ratio of the numbers of elements from one level to the next, above the scene's own mesh [-]: splitting doubles them, and so must the
/// sequence of a mesh with a thin direction, or its levels would differ in the ratio of thickness to width, too. Below the scene's own
/// mesh thin directions keep their elements whatever the ratio, so that it is √2 for every generated mesh.
fn ratio(document: &SceneDocument) -> f64 {
    let counts = document.bodies.iter().filter_map(|body| body.mesh.as_ref()).map(MeshDocument::counts);
    let is_thin = |counts: Vec<u32>| counts.into_iter().any(|count| count <= THIN);
    if document.has_mesh_file() || counts.into_iter().any(is_thin) { 2.0 } else { SQRT_2 }
}

/// The sequence of meshes of a scene.
struct Meshes<'a> {
    scene: &'a Scene,
    variants: Variants<'a>,
    /// Ratio of the numbers of elements from one level to the next, above the scene's own mesh [-].
    ratio: f64,
    /// What its bulk moduli change, once that is known.
    bulk_modulus: OnceCell<BulkModulusEffect>,
}

struct Done {
    level: i32,
    scene: Scene,
    run: Compared,
    /// The same with shorter steps, and with a looser contact tolerance, once an error bar needs them.
    others: OnceCell<Result<[Compared; 2], String>>,
}

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
    let meshes = Meshes { bulk_modulus, ..Meshes::of(&scene, threads, &stop) };
    // The meshes one after the other.
    let mut next = meshes.first();
    let mut sequence = Sequence::of(meshes, clock, requested, [&has_result, &discards]);
    loop {
        match sequence.run_level(&mut request, next)? {
            Step::Next(mesh) => next = mesh,
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
    /// Whether the results of the latest level are withheld.
    was_withheld: bool,
    place: AccuracyProgress,
    /// What the level is expected to take, and when it began [s].
    expected_s: Option<f64>,
    started_s: f64,
    has_result: &'a AtomicBool,
    discards: &'a AtomicBool,
}

/// What follows a level.
enum Step {
    Next(LevelMesh),
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
            was_withheld: false,
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
        let growth = self.meshes.growth_of_time(&mesh, self.done.last());
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
            return Ok(Step::Next(self.meshes.own()));
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
        let run = LevelRun { place: self.place, is_last, must, discards, interrupt };
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
        let again = is_withheld(&result.summary) && self.was_withheld;
        self.was_withheld = is_withheld(&result.summary);
        let lacks = must.lacks(&result);
        let has_stopped = is_good_enough(&result, level, coarser, again);
        if self.clock.is_estimated() && ahead.next.is_none() && !has_stopped {
            let own_s = self.expected_s.unwrap_or(seconds);
            ahead = self.meshes.look_ahead(|next_s| self.clock.is_over_after(next_s), own_s, level);
        }
        let Ahead { next, growth } = ahead;
        let is_over = is_over(&self.clock, &mut result, coarser, growth * seconds);
        // Of a mesh that is coarser than the scene's own, a discarded run says nothing about the finer ones.
        let is_discarded = self.discards.load(Ordering::Relaxed)
            || (lacks.is_some() && (level >= 0 || is_over || has_stopped));
        if is_discarded && let Some(mut best) = self.best.take() {
            best.summary.warnings.push(discarded(self.meshes.factor(level), lacks));
            return Step::End(Box::new(best));
        }
        if is_over && !has_stopped && level < 0 {
            result.summary.warnings.push(coarser_than_own(self.meshes.factor(level)));
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
            self.done.push(Done { level, scene: mesh.scene, run, others: OnceCell::new() });
            self.best = Some(result);
            self.has_result.store(true, Ordering::Relaxed);
        }
        Step::Next(next)
    }
}

/// The mesh of a level.
struct LevelMesh {
    level: i32,
    scene: Scene,
    /// Its plan, if that was made to estimate its time.
    plan: Option<Plan>,
}

impl LevelMesh {
    /// Estimated run time [s].
    fn expected_s(&mut self) -> Result<f64, CompileError> {
        let plan = self.plan.take().map_or_else(|| compile(&self.scene), Ok)?;
        Ok(self.plan.insert(plan).report.expected_run_time_s)
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
        let discardable = |sink| Discardable { sink, discards: self.discards, must: self.must };
        let mut kept: Vec<_> = sinks.iter_mut().map(|sink| discardable(&mut **sink)).collect();
        let request = RunRequest {
            scene: &mesh.scene,
            sinks: kept.iter_mut().map(|sink| sink as &mut dyn Sink).collect(),
            also: also.as_mut().map(|also| &mut **also as &mut dyn Recorder),
            threads: *threads,
            interrupt: self.interrupt,
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
/// the level before are withheld.
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
    format!("The run with {mesh_factor:.2} times the numbers of elements is discarded: it {how}")
}

/// The result on the finest mesh that there is, with a warning if it is not accurate enough.
fn without_finer_mesh(mut result: RunResult, why: &str) -> RunResult {
    if !has_reached(&result) {
        result.summary.warnings.push(format!("There is no finer mesh to reach the accuracy with: {why}"));
    }
    result
}

/// Warning of a mesh that is coarser than the scene's own.
fn coarser_than_own(mesh_factor: f64) -> String {
    format!(
        "The scene's own mesh would take too long: these are the results of one with {mesh_factor:.2} times the numbers of elements; \
         `--as-is` runs the scene's own"
    )
}

/// The level after one, and its time.
struct Ahead {
    /// The mesh, or why there is none; `None` if it is not made yet.
    next: Option<Result<LevelMesh, String>>,
    /// Its run time in units of that of the level itself [-].
    growth: f64,
}

/// A sink that discards a run which the time has stopped, or which does not do what it must.
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

impl<'a> Meshes<'a> {
    fn of(scene: &'a Scene, threads: usize, interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync)) -> Self {
        let document = &scene.document;
        let variants = Variants {
            document,
            source: &scene.kept_files,
            budget: &Budget::COMMAND_LINE,
            threads,
            interrupt,
        };
        Self { scene, variants, ratio: ratio(document), bulk_modulus: OnceCell::new() }
    }

    /// The level of the scene itself.
    fn own(&self) -> LevelMesh {
        LevelMesh { level: 0, scene: self.scene.clone(), plan: None }
    }

    /// The first level: some below the scene's own mesh, as long as a few elements are left and the mesh can be made so coarse.
    fn first(&self) -> LevelMesh {
        let elements = |level: i32| self.scene.element_count() as f64 * self.factor(level).powi(3);
        let below = if self.scene.document.has_mesh_file() { 0.0 } else { COARSEST.log(SQRT_2).round() };
        (below as i32..0)
            .filter(|level| elements(*level) >= FEWEST_ELEMENTS)
            .find_map(|level| self.at(level).ok())
            .unwrap_or_else(|| self.own())
    }

    /// The level after `level`, whose own estimated run time is `own_s` [s]. A mesh that is certainly too fine for the time that is left is
    /// not even made.
    fn look_ahead(&self, is_over_after: impl Fn(f64) -> bool, own_s: f64, level: i32) -> Ahead {
        let ratio = self.factor(level + 1) / self.factor(level);
        let [least, usual] = [LEAST_ORDER_OF_TIME, ORDER_OF_TIME].map(|order| ratio.powf(order));
        if is_over_after(least * own_s) {
            let next = Err("it would take longer than the estimates allow".into());
            return Ahead { next: Some(next), growth: usual };
        }
        let estimated = |mut mesh: LevelMesh| {
            let seconds = mesh.expected_s().map_err(|error| error.to_string())?;
            Ok((mesh, seconds))
        };
        match self.at(level + 1).and_then(estimated) {
            Ok((mesh, seconds)) => Ahead { next: Some(Ok(mesh)), growth: seconds / own_s },
            Err(why) => Ahead { next: Some(Err(why)), growth: f64::INFINITY },
        }
    }

    /// Run time of the level after one in units of its own [-]: h⁻¹ steps, and elements as their number grew from the level `before`,
    /// where thin directions and regions refined to a given size keep theirs. Infinite for more elements than there may be.
    fn growth_of_time(&self, LevelMesh { level, scene, .. }: &LevelMesh, before: Option<&Done>) -> f64 {
        let elements = scene.element_count() as f64;
        let dimensions = before.map_or(ORDER_OF_TIME - 1.0, |before| {
            let ratio = self.factor(*level) / self.factor(before.level);
            (elements / before.scene.element_count() as f64).log(ratio).clamp(1.0, ORDER_OF_TIME - 1.0)
        });
        let ratio = self.factor(level + 1) / self.factor(*level);
        if elements * ratio.powf(dimensions) > Budget::COMMAND_LINE.elements as f64 {
            return f64::INFINITY;
        }
        ratio.powf(dimensions + 1.0) * CAUTION
    }

    /// Numbers of elements of a level relative to the scene's own [-].
    fn factor(&self, level: i32) -> f64 {
        if level < 0 { SQRT_2.powi(level) } else { self.ratio.powi(level) }
    }

    /// Mesh of a level (0 for that of the document itself), or the reason why there is none: it cannot be made, or exceeds the budget.
    fn at(&self, level: i32) -> Result<LevelMesh, String> {
        let scene = if level == 0 {
            self.scene.clone()
        } else if self.scene.document.has_mesh_file() {
            split(self.scene, level.unsigned_abs())?
        } else {
            let setting = Setting { mesh_factor: self.factor(level), ..Setting::OWN };
            let scene = self.variants.scene(&setting, None, None);
            scene.map_err(|error| format!("no run on another mesh: {error}"))?
        };
        Ok(LevelMesh { level, scene, plan: None })
    }

    /// Element size of a completed level relative to that of a finer one [-].
    fn size(&self, coarse: &Done, fine: &Scene, level: i32) -> f64 {
        if self.scene.document.has_mesh_file() {
            self.factor(level) / self.factor(coarse.level)
        } else {
            relative_size(&fine.document, &coarse.scene.document)
        }
    }

    /// Error bars of a level: from the coarser ones, or, where it is the only one, those of any run; with what its bulk moduli change.
    fn bars(
        &self,
        done: &[Done],
        mesh: &mut LevelMesh,
        is_only: bool,
        requested: &AccuracyDocument,
    ) -> ErrorBars {
        let mut bars = if is_only {
            error_bars(&mesh.scene, &[], self.variants.threads, self.variants.interrupt)
        } else {
            self.bars_of_levels(done, &mesh.scene, mesh.level)
        };
        let of_cap = |first: &Done| {
            self.bulk_modulus.get_or_init(|| self.effect_of_cap(first, requested));
        };
        done.first().into_iter().for_each(of_cap);
        if let Some(BulkModulusEffect { change, warning }) = self.bulk_modulus.get() {
            mesh.scene.warnings.extend(warning.clone());
            if let ErrorBars::From(runs) = &mut bars {
                runs.bulk_modulus.clone_from(change);
            }
        }
        bars
    }

    /// What the bulk moduli of the scene in place of that of water change on the first mesh; not tried where that is not much coarser than the
    /// scene's own, so that the run would take longer than the others.
    fn effect_of_cap(&self, first: &Done, requested: &AccuracyDocument) -> BulkModulusEffect {
        if self.factor(first.level) > COARSE {
            return untried_cap(&first.scene);
        }
        effect_of_cap((&first.scene, &first.run), requested, &self.variants)
    }

    fn bars_of_levels(&self, done: &[Done], mesh: &Scene, level: i32) -> ErrorBars {
        let used = &done[done.len().saturating_sub(LEVELS_USED)..];
        let (Some(first), Some(coarsest)) = (done.first(), used.first()) else {
            return ErrorBars::Unknown("there is no coarser mesh to compare with".into());
        };
        // Steps and contact once, on the first mesh of all.
        let others = first
            .others
            .get_or_init(|| steps_and_contact(&self.variants, (&first.scene, first.run.steps), &[]));
        let of = |done: &Done| Level { size: self.size(done, mesh, level), run: done.run.clone() };
        let levels = used.iter().map(of).collect();
        let keeps_a_direction = keeps_a_direction(&mesh.document, &coarsest.scene.document);
        others.clone().map_or_else(ErrorBars::Unknown, |others| {
            let runs = compared_runs(&self.scene.document, first.run.clone(), others, levels);
            ErrorBars::From(Box::new(ComparedRuns { keeps_a_direction, ..runs }))
        })
    }
}
