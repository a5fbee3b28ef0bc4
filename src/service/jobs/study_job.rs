//! Studies as jobs: many runs of one scene in one job, whose summary contains the results.

use super::engine::{CheckedScene, JsonDocument, Meshes, RunOrder, RunReport};
use super::failures::{internal, invalid_scene, nothing_finished, out_of_time};
use super::scene_loader::{SceneLoader, checked};
use super::study_entries::{Entries, too_many};
use super::{Phase, Progress};
use crate::measure::QuantityOfInterest;
use crate::scene::document::{ContactSolver, Formulation};
use crate::scene::problem::{Pointer, ProblemList, Severity};
use crate::scene::{Problem, Problems};
use crate::step::{Ending, Failure};
use crate::study::Setting;
use crate::study::error::{
    COARSEST, ErrorRequest, FINEST, Ladder, Reference, Row, USUAL_LEVELS, study_error,
};
use crate::study::stability::{Stepping, cases, study_stability};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use utoipa::ToSchema;

/// Admissible ratios of implicit to explicit steps.
const STEP_RATIOS: RangeInclusive<u32> = 1..=100_000;
/// Shortest admissible implicit step [s].
const SHORTEST_STEP_S: f64 = 1e-12;

/// Request for a study.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum StudyDocument {
    /// Error against run time of one scene.
    Error(ErrorStudyDocument),
    /// The matrix of stiff and extreme cases.
    Stability(StabilityStudyDocument),
}

/// Error against run time of one scene.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorStudyDocument {
    /// Scene document to study.
    #[schema(value_type = Object)]
    scene: Value,
    /// Coarsest mesh: −1 halves the numbers of elements of generated meshes.
    #[serde(default = "usual_coarsest")]
    coarsest: i32,
    /// Finest mesh: each level splits every element into eight.
    #[serde(default = "usual_finest")]
    finest: i32,
    /// Formulations in addition to the scene's own.
    #[serde(default)]
    #[schema(value_type = Vec<String>)]
    formulations: Vec<Formulation>,
    /// Whether there is a mesh between each level and the next, √2 times as fine, so that limits are fitted to more meshes.
    #[serde(default)]
    half_levels: bool,
    /// Lengths of additional implicit steps, from 1e-12 to `end_time_s` of the scene, without repetition [s].
    #[serde(default)]
    implicit_steps_s: Vec<f64>,
    /// Additional solvers of contact problems, with the scene's own time integration and with each of those steps.
    #[serde(default)]
    contact_solvers: Vec<ContactSolver>,
    /// Whether to separate the geometry error, by a run of the next finer mesh on the facets of the scene's own.
    #[serde(default)]
    geometry: bool,
    /// Whether reduced boundary mass and implicit steps are combined with every mesh and formulation.
    #[serde(default)]
    combined: bool,
    /// Exact values by the name of the quantity, if known.
    #[serde(default)]
    exact: BTreeMap<String, f64>,
}

/// The matrix of stiff and extreme cases.
#[derive(Clone, Debug, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StabilityStudyDocument {
    /// Only the ends of each axis.
    #[serde(default = "yes")]
    short: bool,
    /// Ratios of implicit to explicit steps, from 1 to 100000, without repetition; no step is longer than half its run.
    /// None by default, which omits the implicit scheme; `contuse study stability` runs 1, 10, 100 and 1000 by default,
    /// and with `--short` all but the first.
    #[serde(default)]
    implicit: Vec<u32>,
}

fn usual_coarsest() -> i32 {
    *USUAL_LEVELS.start()
}
fn usual_finest() -> i32 {
    *USUAL_LEVELS.end()
}
fn yes() -> bool {
    true
}

impl StudyDocument {
    /// Reads the study from a document, or locates its errors. Serde loses error locations in a tagged enum, so the tag
    /// is read first.
    fn read(mut document: Value) -> Result<Self, Problem> {
        let kind = document.as_object_mut().and_then(|members| members.remove("kind"));
        let read = match kind.as_ref().and_then(Value::as_str) {
            Some("error") => serde_path_to_error::deserialize(&document).map(Self::Error),
            Some("stability") => serde_path_to_error::deserialize(&document).map(Self::Stability),
            _ => {
                return Err(Problem::error("wrong_structure", &Pointer::root().key("kind"), "no such study")
                    .value(kind.unwrap_or_default())
                    .limit("\"error\" or \"stability\"")
                    .remedy("name the kind of the study; its members are described at /docs"));
            }
        };
        read.map_err(|error| Problem::refused_by_serde(&error, &document))
    }
}

/// Validates a study; problems of its scene are located in the whole document.
pub(super) fn check(
    scenes: &SceneLoader,
    document: &JsonDocument,
    content: &Value,
    meshes: &dyn Meshes,
) -> Result<CheckedScene, Problems> {
    match StudyDocument::read(content.clone()).map_err(Problem::alone)? {
        StudyDocument::Error(study) => check_error(scenes, study, meshes),
        StudyDocument::Stability(study) => problems_of_ratios(&study.implicit).then(Ok(CheckedScene {
            name: "stability".into(),
            content_hash: document.digest(),
            end_time_s: 1.0,
            warnings: Vec::new(),
            memory_bytes: 0,
        })),
    }
}

fn problems_of_ratios(ratios: &[u32]) -> Problems {
    let list = Entries {
        name: "implicit",
        written: ratios,
        limit: format!("from {} to {}", STEP_RATIOS.start(), STEP_RATIOS.end()),
        remedy: "give implicit steps as multiples of the explicit one, such as 1, 10 and 100; none omits the scheme",
    };
    Problems(list.problems(|ratio| STEP_RATIOS.contains(&ratio)))
}

fn problems_of_steps(steps_s: &[f64], scene: &Value) -> Vec<Problem> {
    // A scene without an end is rejected elsewhere.
    let end_s = scene.get("end_time_s").and_then(Value::as_f64).filter(|end_s| *end_s > 0.0);
    let list = Entries {
        name: "implicit_steps_s",
        written: steps_s,
        limit: match end_s {
            Some(end_s) => format!("from {SHORTEST_STEP_S:e} to {end_s}, the end of the scene"),
            None => format!("from {SHORTEST_STEP_S:e} to the end of the scene"),
        },
        remedy: "give steps in seconds, about as long as an explicit one or some times that",
    };
    list.problems(|step_s| step_s >= SHORTEST_STEP_S && end_s.is_none_or(|end_s| step_s <= end_s))
}

fn check_error(
    scenes: &SceneLoader,
    study: ErrorStudyDocument,
    meshes: &dyn Meshes,
) -> Result<CheckedScene, Problems> {
    let lists =
        [("formulations", study.formulations.len()), ("contact_solvers", study.contact_solvers.len())];
    let long = lists.into_iter().filter_map(|(name, count)| too_many(name, count));
    let bad_steps = problems_of_steps(&study.implicit_steps_s, &study.scene);
    let levels = [("coarsest", study.coarsest, COARSEST), ("finest", study.finest, FINEST)].into_iter();
    let bad_levels = levels.filter(|(_, level, offered)| !offered.contains(level));
    let bad_levels = bad_levels.map(|(name, level, offered)| out_of_range(name, level, &offered));
    let mut problems: ProblemList = long.chain(bad_steps).chain(bad_levels).collect();
    for name in study.exact.keys().filter(|name| QuantityOfInterest::from_name(name).is_none()) {
        problems.push_with(Severity::Error, || no_quantity(name));
    }
    let loaded = scenes.load(&study.scene.into(), meshes).map_err(|found| found.under(&scene_place()));
    let loaded = Problems::from(problems).then(loaded)?;
    let checked = checked(&loaded);
    // Each level has eight times the elements of the one before it, within the budget of a run.
    let finest = 8_u64.saturating_pow(u32::try_from(study.finest).unwrap_or(0));
    let memory_bytes = checked.memory_bytes.saturating_mul(finest).min(scenes.budget().memory_bytes);
    let name = format!("error of {}", checked.name);
    Ok(CheckedScene { name, memory_bytes, ..checked })
}

/// Location of the scene in the document of a study or a question.
pub(super) fn scene_place() -> Pointer {
    Pointer::root().key("scene")
}

fn out_of_range(name: &str, level: i32, range: &RangeInclusive<i32>) -> Problem {
    let message = format!("{name} is not an available mesh level");
    Problem::error("out_of_range", &Pointer::root().key(name), message)
        .value(level)
        .limit(format!("{} to {}", range.start(), range.end()))
        .remedy("each level takes sixteen times the work of the one before")
}

fn no_quantity(name: &str) -> Problem {
    let place = Pointer::root().key("exact").key(name);
    Problem::error("unknown_quantity", &place, format!("no quantity is called {name:?}"))
        .value(name)
        .limit("a quantity of interest")
        .remedy(format!("there are {}", QuantityOfInterest::ALL.map(QuantityOfInterest::name).join(", ")))
}

/// Runs a validated study.
pub(super) fn run(
    scenes: &SceneLoader,
    document: Value,
    order: &mut RunOrder<'_>,
) -> Result<RunReport, Failure> {
    let study = StudyDocument::read(document).map_err(|problem| invalid_scene(&problem.alone()))?;
    let mut reached = Progress::beginning(Phase::Stepping);
    // Progress counts the runs of the study.
    let mut report = |number: usize, count: usize| {
        reached.progress = number as f64 / count.max(1) as f64;
        reached.step = number as u64;
        reached.expected_steps = Some(count as u64);
        (order.progress)(reached);
    };
    let interrupt = || order.control.interrupt();
    let (summary, stopped, has_finished) = match study {
        StudyDocument::Error(study) => {
            let ladder = Ladder {
                levels: study.coarsest..=study.finest,
                half_levels: study.half_levels,
                formulations: &study.formulations,
                implicit_steps_s: &study.implicit_steps_s,
                contact_solvers: &study.contact_solvers,
                geometry: study.geometry,
                combined: study.combined,
            };
            let document = scenes.scene_of(&study.scene.into(), order.meshes)?.scene.document;
            let exact = study.exact.iter();
            let known = exact.filter_map(|(name, value)| {
                Some((QuantityOfInterest::from_name(name)?, Reference::Exact { value: *value }))
            });
            let known = known.collect();
            let study = study_error(&mut ErrorRequest {
                document: &document,
                source: order.meshes,
                budget: scenes.budget(),
                ladder: &ladder.settings(),
                known: &known,
                threads: order.threads,
                interrupt: &interrupt,
                progress: &mut |number, count, _: &Setting| report(number, count),
            });
            let has_finished = study.rows.iter().any(Row::is_finished);
            (serde_json::to_string_pretty(&study), study.stopped, has_finished)
        }
        StudyDocument::Stability(StabilityStudyDocument { short, implicit }) => {
            let cases = cases(short);
            let steppings = Stepping::with_implicit(&implicit);
            let (mut done, count) = (0, cases.len() * steppings.len());
            let study = study_stability(&cases, &steppings, order.threads, &interrupt, &mut |_| {
                done += 1;
                report(done, count);
            });
            (serde_json::to_string_pretty(&study), study.stopped, true)
        }
    };
    let summary = summary.map_err(|error| {
        tracing::error!(%error, "a study cannot be written as JSON");
        internal()
    })?;
    // A stopped study has a summary of the completed part.
    let ending = match () {
        () if stopped.as_deref() == Some("deadline") => out_of_time().into(),
        () if stopped.is_some() => Ending::Cancelled,
        () if has_finished => Ending::Finished,
        () => nothing_finished().into(),
    };
    Ok(RunReport { ending, summary: Some(summary), progress: reached })
}
