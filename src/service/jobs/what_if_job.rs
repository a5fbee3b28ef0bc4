//! What-if questions as jobs: the answer is the summary, and every case is an event.

use super::engine::{CheckedScene, JsonDocument, Meshes, RunOrder, RunReport};
use super::failures::{internal, invalid_scene, nothing_finished, out_of_time};
use super::scene_loader::SceneLoader;
use super::store::Event;
use super::study_job::scene_place;
use super::{Phase, Progress};
use crate::scene::json::Parsed;
use crate::scene::problem::Pointer;
use crate::scene::{Problem, Problems};
use crate::service::shelves::RESULTS;
use crate::step::{Ending, Failure};
use crate::study::what_if::{
    Answer, Cache, CaseAnswer, Partial, WhatIfDocument, WhatIfRequest, check as check_question, count,
    study_what_if,
};
use serde_json::Value;
use std::sync::Arc;

/// Validates a question; problems of its scene are located in the whole document.
pub(super) fn check(
    scenes: &SceneLoader,
    document: &JsonDocument,
    content: &Value,
    meshes: &dyn Meshes,
) -> Result<CheckedScene, Problems> {
    let question = read(content).map_err(Problem::alone)?;
    let scene = scene_of(&question).map_err(Problem::alone)?;
    let base = scenes.load(&scene, meshes).map_err(|problems| problems.under(&scene_place()))?;
    let runs = count(&question);
    let too_long = Problems(scenes.too_long(&base, runs, "/sample/count").into_iter().collect());
    too_long.then(check_question(&question, &base, meshes, scenes.budget()).map_err(Problems))?;
    Ok(CheckedScene {
        name: format!("what if: {}", base.scene.document.name),
        content_hash: document.digest(),
        end_time_s: base.scene.document.end_time_s,
        warnings: base.warnings.clone(),
        // Each thread has a run of its own.
        memory_bytes: base.estimate.memory_bytes.saturating_mul(runs.min(scenes.what_if_threads() as u64)),
    })
}

/// Reads the question from a document, or locates its errors.
fn read(document: &Value) -> Result<WhatIfDocument, Problem> {
    serde_path_to_error::deserialize(document).map_err(|error| Problem::refused_by_serde(&error, document))
}

/// The scene of the question, not yet loaded.
fn scene_of(question: &WhatIfDocument) -> Result<Parsed, Problem> {
    question.scene.clone().map(Parsed::from).ok_or_else(|| {
        Problem::error("no_base", &Pointer::root(), "the question has no base")
            .limit("one of `scene` and `job`")
            .remedy("send the scene document of the base, or the id of its job")
    })
}

/// Answers a validated question.
pub(super) fn run(
    scenes: &SceneLoader,
    document: &Value,
    order: &mut RunOrder<'_>,
) -> Result<RunReport, Failure> {
    let refused = |problem: Problem| invalid_scene(&problem.alone());
    let question = &read(document).map_err(refused)?;
    let base = scenes.scene_of(&scene_of(question).map_err(refused)?, order.meshes)?;
    let cache = Cache::on_shelf(Arc::clone(order.blobs), RESULTS).noting(Arc::clone(&order.note_result));
    let expected = count(question);
    let mut reached = Progress { expected_steps: Some(expected), ..Progress::beginning(Phase::Stepping) };
    (order.progress)(reached);
    // Each case is an event, and advances the progress.
    let answer = study_what_if(&mut WhatIfRequest {
        question,
        base: &base,
        source: order.meshes,
        budget: scenes.budget(),
        threads: scenes.what_if_threads(),
        cache: &cache,
        shares_plans: true,
        interrupt: &|| order.control.interrupt(),
        report: &mut |partial| {
            if let Partial::Case { case, .. } = &partial {
                reached.step = case.index as u64 + 1;
                reached.progress = reached.step as f64 / expected as f64;
                (order.progress)(reached);
            }
            (order.emit)(&event(&partial));
        },
    });
    let summary = serde_json::to_string_pretty(&answer).map_err(|error| {
        tracing::error!(%error, "an answer cannot be written as JSON");
        internal()
    })?;
    Ok(RunReport { ending: ending(&answer), summary: Some(summary), progress: reached })
}

/// Converts a part of the answer to an event.
fn event(partial: &Partial) -> Event<'static> {
    let kind = match partial {
        Partial::Case { .. } => "case",
        Partial::ErrorBars { .. } => "error_bars",
        Partial::Limit(_) => "limit",
    };
    // Serialisation of numbers and texts cannot fail; otherwise the event would be empty.
    Event { kind, data: serde_json::to_value(partial).unwrap_or_default() }
}

fn ending(answer: &Answer) -> Ending {
    match answer.stopped {
        Some("deadline") => out_of_time().into(),
        Some(_) => Ending::Cancelled,
        None if answer.cases.iter().any(CaseAnswer::has_finished) => Ending::Finished,
        None => nothing_finished().into(),
    }
}
