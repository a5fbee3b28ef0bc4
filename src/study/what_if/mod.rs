//! What-if studies: a base scene, parameters that vary, and the results of many cases.
//!
//! 1. [`document`]: the question. [`check`](check()) validates it.
//! 2. [`change`]: a named, physical parameter and its value → an edited scene; `over_surface` moves an impact over the
//!    boundary surface of any mesh.
//! 3. [`cases()`]: explicit cases, one parameter at a time, and sampled ([`sampling`]).
//! 4. `runner`: the runs, one thread each, in parallel; meshes and plan are shared between cases that differ in motion
//!    only, and results are cached ([`Cache`]). Neither sharing, caching nor the number of threads changes a bit.
//! 5. [`statistics`] and [`limit`]: sensitivities, spread, Sobol indices, and the values up to which limits are met.
//! 6. [`surrogate`]: polynomials fitted to the cases, which predict the response in others.

mod answer;
mod base_facts;
mod cache;
mod case_answer;
mod cases;
pub mod change;
mod check;
mod composer;
pub mod distribution;
pub mod document;
pub mod limit;
mod misfit;
mod named;
mod over_surface;
mod rigid_motion;
mod runner;
pub mod sampling;
mod spread;
pub mod statistics;
pub mod surrogate;

pub use answer::{Answer, Effort, LimitAnswer, ParameterAnswer, Partial};
pub use base_facts::BaseFacts;
pub use cache::{Cache, Note, Numbers, name_of_build, trim_shelf};
pub use case_answer::{CaseAnswer, Number};
pub use cases::{Case, Matrix, Origin, cases, count};
pub use check::check;
pub use document::WhatIfDocument;
pub use misfit::Misfit;

use crate::scene::document::ErrorBarsDocument;
use crate::scene::{Budget, Loaded, MeshSource};
use crate::step::Interrupt;
use composer::Composer;
use document::ErrorSource;
use runner::{Runner, Task};

/// A what-if question with its context.
pub struct WhatIfRequest<'a> {
    /// The question, validated by [`check`](check()).
    pub question: &'a WhatIfDocument,
    /// The base scene as loaded.
    pub base: &'a Loaded,
    /// Source of the base's meshes.
    pub source: &'a (dyn MeshSource + Sync),
    /// Budget of a single run.
    pub budget: &'a Budget,
    /// Number of parallel runs.
    pub threads: usize,
    /// Cache of earlier results.
    pub cache: &'a Cache,
    /// Whether to reuse meshes and plans between cases that differ in motion only; it changes no bit.
    pub shares_plans: bool,
    /// Called before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Receives every answer as it becomes available, in the order of the cases.
    pub report: &'a mut dyn FnMut(Partial),
}

/// Runs the cases and limits of a question and composes the answer.
pub fn study_what_if(request: &mut WhatIfRequest) -> Answer {
    let question = request.question;
    let facts = BaseFacts::of(request.base, request.source, request.budget);
    let mut base = request.base.scene.clone();
    // The settings of the cases: no individual error bars, and no data needed only for recording.
    base.document.solver.error_bars = ErrorBarsDocument::None;
    base.document.record.fields.clear();
    // Depths at which limits need the stress.
    let mut depths: Vec<f64> = question.limits.iter().filter_map(|limit| limit.measure.depth()).collect();
    depths.sort_by(f64::total_cmp);
    depths.dedup();
    let runner = Runner {
        question,
        base: &base,
        facts: &facts,
        source: request.source,
        budget: request.budget,
        cache: request.cache,
        shares_plans: request.shares_plans,
        depths,
        interrupt: request.interrupt,
    };
    // Cases in order, then limits.
    let all = cases(question);
    let mut composer = Composer::new(question, &request.base.scene.document, &facts, all.len());
    let tasks = tasks(question.error_bars, &all);
    runner.answer_all(&tasks, request.threads, &mut |index, answered| {
        let is_base_again = index == 1 && question.error_bars == ErrorSource::Base;
        if is_base_again {
            composer.take_errors(&answered, request.report);
        } else {
            composer.take_case(tasks[index].case, answered, request.report);
        }
    });
    for limit in &question.limits {
        if (request.interrupt)().is_some() {
            break;
        }
        composer.take_limit(limit, &runner, request.threads, request.report);
    }
    composer.finish((request.interrupt)(), request.threads)
}

/// The runs: every case, and after the base, if its error bars apply to all, the base with them. So the first answer
/// does not wait for them.
fn tasks(errors: ErrorSource, cases: &[Case]) -> Vec<Task<'_>> {
    let with_errors = errors == ErrorSource::Full;
    let mut tasks: Vec<Task> = cases.iter().map(|case| Task { case, with_errors }).collect();
    if errors == ErrorSource::Base && !cases.is_empty() {
        tasks.insert(1, Task { case: &cases[0], with_errors: true });
    }
    tasks
}
