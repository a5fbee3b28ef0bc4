//! What-if questions as jobs: the answer is the summary, and every case is an event as it comes.

use super::engine::{CheckedScene, JsonDocument, RunEnding, RunOrder, RunReport, SceneProblem};
use super::simulator::{Simulator, invalid_scene};
use super::store::Event;
use super::study_job::{nothing_finished, out_of_time};
use super::{JobFailure, Phase, Progress};
use crate::scene::{Loaded, Problem};
use crate::service::meshes::MeshShelf;
use crate::study::what_if::{
    Answer, Cache, CaseAnswer, Partial, WhatIfDocument, WhatIfRequest, check as check_question, count,
    study_what_if,
};
use serde_json::Value;
use std::path::Path;
use std::sync::OnceLock;

/// Results that questions of one service share.
#[derive(Debug, Default)]
pub struct SharedResults(OnceLock<Cache>);

impl SharedResults {
    /// Those in a folder. A folder that cannot be used costs time and no answer.
    fn in_folder(&self, folder: &Path) -> &Cache {
        self.0.get_or_init(|| {
            Cache::in_folder(folder).unwrap_or_else(|error| {
                tracing::error!(%error, "results cannot be kept in the data folder");
                Cache::default()
            })
        })
    }
}

/// Judges a question; problems of its scene have their place in the whole document.
pub(super) fn check(
    simulator: &Simulator,
    document: &JsonDocument,
    meshes: &MeshShelf,
) -> Result<CheckedScene, Vec<SceneProblem>> {
    let question = read(&document.parsed.value).map_err(|problem| vec![problem.into()])?;
    let base = base(simulator, &question, meshes)?;
    let runs = count(&question);
    let mut problems: Vec<SceneProblem> = Vec::new();
    problems.extend(simulator.too_long(&base, runs, "/sample/count").map(SceneProblem::from));
    if let Err(found) = check_question(&question, &base, meshes, simulator.budget()) {
        problems.extend(found.into_iter().map(SceneProblem::from));
    }
    if problems.is_empty() {
        Ok(CheckedScene {
            name: format!("what if: {}", base.scene.document.name),
            content_hash: super::recordings::hexadecimal(&<sha2::Sha256 as sha2::Digest>::digest(
                &document.text,
            )),
            end_time_s: base.scene.document.end_time_s,
            warnings: base.warnings.into_iter().map(SceneProblem::from).collect(),
        })
    } else {
        Err(problems)
    }
}

/// The question of a document, or where it is none.
fn read(document: &Value) -> Result<WhatIfDocument, Problem> {
    serde_path_to_error::deserialize(document).map_err(|error| Problem::refused_by_serde(&error, document))
}

/// The scene of the question.
fn base(
    simulator: &Simulator,
    question: &WhatIfDocument,
    meshes: &MeshShelf,
) -> Result<Loaded, Vec<SceneProblem>> {
    let Some(scene) = &question.scene else {
        let problem = SceneProblem {
            code: "no_base".into(),
            limit: "one of `scene` and `job`".into(),
            remedy: "send the scene document of the base, or the id of its job".into(),
            ..SceneProblem::of_document("the question has no base")
        };
        return Err(vec![problem]);
    };
    simulator.load(&scene.clone().into(), meshes).map_err(|found| {
        let placed = |p: SceneProblem| SceneProblem { pointer: format!("/scene{}", p.pointer), ..p };
        found.into_iter().map(placed).collect()
    })
}

/// Answers a question that was judged before.
pub(super) fn run(
    simulator: &Simulator,
    document: &Value,
    order: &mut RunOrder<'_>,
) -> Result<RunReport, JobFailure> {
    let question = &read(document).map_err(|problem| invalid_scene(&[problem.into()]))?;
    let base = base(simulator, question, order.meshes).map_err(|problems| invalid_scene(&problems))?;
    let expected = count(question);
    let mut reached = Progress { expected_steps: Some(expected), ..Progress::beginning(Phase::Stepping) };
    (order.progress)(reached);
    let answer = study_what_if(&mut WhatIfRequest {
        question,
        base: &base,
        source: order.meshes,
        budget: simulator.budget(),
        threads: simulator.what_if_threads(),
        cache: simulator.results().in_folder(order.results),
        shares_plans: true,
        interrupt: &|| order.control.interrupt(),
        tell: &mut |partial| {
            if let Partial::Case { case, .. } = &partial {
                reached.step = case.index as u64 + 1;
                reached.progress = reached.step as f64 / expected as f64;
                (order.progress)(reached);
            }
            (order.tell)(event(&partial));
        },
    });
    let summary = serde_json::to_string_pretty(&answer).map_err(|error| {
        tracing::error!(%error, "an answer cannot be written as JSON");
        JobFailure::internal()
    })?;
    Ok(RunReport { ending: ending(&answer), summary: Some(summary), progress: reached })
}

/// A part of the answer as an event.
fn event(partial: &Partial) -> Event<'static> {
    let kind = match partial {
        Partial::Case { .. } => "case",
        Partial::ErrorBars { .. } => "error_bars",
        Partial::Limit(_) => "limit",
    };
    // Numbers and texts can always be written; were it not so, the event would say nothing.
    Event { kind, data: serde_json::to_value(partial).unwrap_or_default() }
}

fn ending(answer: &Answer) -> RunEnding {
    match answer.stopped {
        Some("deadline") => RunEnding::Failed(out_of_time()),
        Some(_) => RunEnding::Stopped,
        None if answer.cases.iter().any(CaseAnswer::has_finished) => RunEnding::Finished,
        None => RunEnding::Failed(nothing_finished()),
    }
}
