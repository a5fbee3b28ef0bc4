//! A scene on finer and finer meshes, until its numbers are as exact as was asked for or the time is over.
//!
//! Each run is one level; the two before it give its error bars, so nothing is run for the error bars alone but a run with smaller steps
//! and one with a looser contact solver on the coarsest of the three. Generated meshes get √2 times the numbers of elements from one level
//! to the next; where a mesh is from a file, every element of the scene is split into eight.

use super::error_bars::{relative_size, step_and_contact};
use super::progress::{Phase, Progress};
use super::setting::Setting;
use super::single::{RunError, RunRequest, RunResult, ending_name, is_stop, run_with_error_bars};
use super::variant::Variants;
use crate::measure::{AskedAccuracy, Cheaper, CheaperRuns, ErrorBars, Level, Sink};
use crate::scene::document::AccuracyDocument;
use crate::scene::{Budget, NoFiles, Scene};
use crate::step::{Ending, Recorder};
use std::f64::consts::SQRT_2;
use std::time::Instant;

/// The first mesh has so many elements at least, if the scene's own has [-].
const FEWEST_ELEMENTS: f64 = 300.0;
/// Coarser meshes that the error bars of one come from, where there are as many.
const LEVELS_USED: usize = 2;
/// The coarsest mesh that is tried, in levels below the scene's own.
const LEVELS_BELOW: i32 = 4;
/// Time of a run by the size of its elements, h⁻⁴: elements and steps.
const ORDER_OF_TIME: i32 = 4;
/// What a prediction of time is multiplied by: contact, and steps that strain shortens, grow a little faster.
const CAUTION: f64 = 1.2;

/// The meshes that a scene is run on.
struct Meshes<'a> {
    scene: &'a Scene,
    variants: Variants<'a>,
    /// Ratio of the numbers of elements from one level to the next [-].
    ratio: f64,
}

/// A level that was run.
struct Done {
    level: i32,
    scene: Scene,
    run: Cheaper,
}

/// Runs a scene to an accuracy; the result is that of the finest mesh, and every sink has seen its run last.
///
/// # Errors
/// As of a single run.
pub(super) fn run_to(request: RunRequest, asked: &AccuracyDocument) -> Result<RunResult, RunError> {
    let RunRequest { scene, mut sinks, mut also, threads, interrupt, progress } = request;
    let document = &scene.document;
    let variants = Variants { document, source: &NoFiles, budget: &Budget::COMMAND_LINE, threads, interrupt };
    let meshes = Meshes { scene, variants, ratio: if document.has_mesh_file() { 2.0 } else { SQRT_2 } };
    let (begin, mut last_s) = (Instant::now(), None);
    let (mut done, mut level): (Vec<Done>, i32) = (Vec::new(), meshes.first());
    // A mesh may be refused for being too coarse.
    let mut mesh = loop {
        match meshes.scene_of(level) {
            Ok(mesh) => break mesh,
            Err(_) => level += 1,
        }
    };
    loop {
        // Bars of this level, and what it and the next are expected to take.
        let started = Instant::now();
        let bars = meshes.error_bars(&done, &mesh, level);
        let growth = meshes.ratio.powi(ORDER_OF_TIME) * CAUTION;
        let expected = last_s.map(|seconds: f64| growth * seconds);
        let accuracy = AskedAccuracy {
            relative: asked.relative,
            of: asked.of.clone(),
            mesh_factor: meshes.factor(level),
            next_s: expected.map(|seconds| growth * seconds),
        };
        let spent = |seconds: f64| begin.elapsed().as_secs_f64() + seconds > asked.time_budget_s;
        let is_last = accuracy.next_s.is_some_and(|next| spent(next + expected.unwrap_or_default()));
        let mut tell = |p: Progress| {
            progress(if is_last { p } else { Progress::beginning(Phase::EstimatingErrors) });
        };
        let request = RunRequest {
            scene: &mesh,
            sinks: sinks.iter_mut().map(|sink| &mut **sink as &mut dyn Sink).collect(),
            also: also.as_mut().map(|also| &mut **also as &mut dyn Recorder),
            threads,
            interrupt,
            progress: &mut tell,
        };
        let result = run_with_error_bars(request, Some(accuracy), |_| bars)?;

        // Whether it is good enough, or the next mesh too dear.
        let seconds = started.elapsed().as_secs_f64();
        let is_reached = result.summary.accuracy.as_ref().is_some_and(|accuracy| accuracy.reached);
        let has_stopped = match &result.outcome.ending {
            Ending::Finished => is_reached,
            // A mesh that is too coarse may fail where a finer one does not.
            ending => level >= 0 || is_stop(&ending_name(ending)),
        };
        if has_stopped || spent(growth * seconds) {
            return Ok(result);
        }
        let Ok(next) = meshes.scene_of(level + 1) else { return Ok(result) };
        if result.outcome.ending == Ending::Finished {
            let run = Cheaper::new(result.summary.values(), Vec::new(), result.outcome.steps);
            done.push(Done { level, scene: mesh, run });
        }
        (mesh, last_s, level) = (next, Some(seconds), level + 1);
    }
}

impl Meshes<'_> {
    /// The first level: some below the scene's own mesh, as long as a few elements are left.
    fn first(&self) -> i32 {
        if self.scene.document.has_mesh_file() {
            return 0;
        }
        let elements = |level: &i32| self.scene.element_count() as f64 * self.factor(*level).powi(3);
        (-LEVELS_BELOW..0).find(|level| elements(level) >= FEWEST_ELEMENTS).unwrap_or(0)
    }

    /// Numbers of elements of a level in units of the scene's own [-].
    fn factor(&self, level: i32) -> f64 {
        self.ratio.powi(level)
    }

    /// The scene of a level, that of the document at 0, or why there is none: its mesh cannot be made, or is beyond what may be run.
    fn scene_of(&self, level: i32) -> Result<Scene, String> {
        if level == 0 {
            return Ok(self.scene.clone());
        }
        if !self.scene.document.has_mesh_file() {
            let setting = Setting { mesh_factor: self.factor(level), ..Setting::OWN };
            return self
                .variants
                .scene(&setting, None, None)
                .map_err(|error| format!("no run on another mesh: {error}"));
        }
        let elements = self.scene.element_count() as f64 * self.factor(level).powi(3);
        if elements > Budget::COMMAND_LINE.elements as f64 {
            return Err(format!("{elements:.0} elements are too many"));
        }
        let mut scene = self.scene.clone();
        (0..level).try_for_each(|_| scene.split_on_facets()).map_err(|error| error.to_string())?;
        Ok(scene)
    }

    /// Element size of a level that was run in units of that of a finer one [-].
    fn size(&self, coarse: &Done, fine: &Scene, level: i32) -> f64 {
        if self.scene.document.has_mesh_file() {
            self.factor(level) / self.factor(coarse.level)
        } else {
            relative_size(&fine.document, &coarse.scene.document)
        }
    }

    /// Error bars of a level, from those before.
    fn error_bars(&self, done: &[Done], mesh: &Scene, level: i32) -> ErrorBars {
        let used = &done[done.len().saturating_sub(LEVELS_USED)..];
        let Some(coarsest) = used.first() else {
            return ErrorBars::Unknown("there is no coarser mesh to compare with".into());
        };
        let of = |done: &Done| Level { size: self.size(done, mesh, level), run: done.run.clone() };
        let levels = used.iter().map(of).collect();
        match step_and_contact(&self.variants, &coarsest.scene, coarsest.run.steps, &[]) {
            Ok([small_steps, loose_contact]) => {
                ErrorBars::From(Box::new(CheaperRuns { levels, small_steps, loose_contact }))
            }
            Err(why) => ErrorBars::Unknown(why),
        }
    }
}
