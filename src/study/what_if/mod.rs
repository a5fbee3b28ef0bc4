//! What if: a base scene, what varies, and what comes of it in many cases.
//!
//! 1. [`document`]: the question. [`check`](check()) finds all that is wrong with it.
//! 2. [`change`]: a named, physical parameter and its value → an edited scene; `over_skin` moves an impact over the skin of any mesh.
//! 3. [`cases()`]: the cases by hand, one parameter at a time, and sampled ([`sampling`]).
//! 4. `runner`: the runs, one thread each, side by side; meshes and plan are shared where only the motion changes, and what was
//!    said before is remembered ([`Cache`]). The bits are the same with and without, and for any number of threads.
//! 5. [`statistics`] and [`limit`]: sensitivities, spread, Sobol indices, and up to which value a limit is kept.
//! 6. [`surrogate`]: polynomials through the cases, which propose what the model would say of others.

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
mod over_skin;
mod rigid_motion;
mod runner;
pub mod sampling;
mod short_number;
pub mod statistics;
pub mod surrogate;

pub use answer::{Answer, Effort, LimitAnswer, ParameterAnswer, Partial, QuantityAnswer};
pub use base_facts::BaseFacts;
pub use cache::{Cache, Numbers};
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

/// What is asked.
pub struct WhatIfRequest<'a> {
    /// The question, checked by [`check`](check()).
    pub question: &'a WhatIfDocument,
    /// Its base.
    pub base: &'a Loaded,
    /// Meshes of the base.
    pub source: &'a (dyn MeshSource + Sync),
    /// What a run may cost.
    pub budget: &'a Budget,
    /// Runs side by side.
    pub threads: usize,
    /// What is known already.
    pub cache: &'a Cache,
    /// Whether meshes and plans are taken over from case to case where only the motion changes; it changes no bit.
    pub shares_plans: bool,
    /// Asked before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Told of every answer as it comes, in the order of the cases.
    pub tell: &'a mut dyn FnMut(Partial),
}

/// Answers a question.
pub fn study_what_if(request: &mut WhatIfRequest) -> Answer {
    let question = request.question;
    let facts = BaseFacts::of(request.base, request.source, request.budget);
    let mut base = request.base.scene.clone();
    // As the scenes of the cases are: no error bars of their own, and nothing that only a recording needs.
    base.document.solver.error_bars = ErrorBarsDocument::None;
    base.document.record.fields.clear();
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
    let all = cases(question);
    let mut composer = Composer::new(question, &request.base.scene.document, &facts, all.len());
    let tasks = tasks(question.error_bars, &all);
    runner.answer_all(&tasks, request.threads, &mut |index, answered| {
        let is_base_again = index == 1 && question.error_bars == ErrorSource::Base;
        if is_base_again {
            composer.take_errors(&answered, request.tell);
        } else {
            composer.take_case(tasks[index].case, answered, request.tell);
        }
    });
    for limit in &question.limits {
        if (request.interrupt)().is_some() {
            break;
        }
        composer.take_limit(limit, &runner, request.threads, request.tell);
    }
    composer.finish((request.interrupt)(), request.threads)
}

/// The runs: every case, and after the base, where its error bars are those of all, the base with them. So the first answer
/// does not wait for them.
fn tasks(errors: ErrorSource, cases: &[Case]) -> Vec<Task<'_>> {
    let with_errors = errors == ErrorSource::Full;
    let mut tasks: Vec<Task> = cases.iter().map(|case| Task { case, with_errors }).collect();
    if errors == ErrorSource::Base && !cases.is_empty() {
        tasks.insert(1, Task { case: &cases[0], with_errors: true });
    }
    tasks
}
