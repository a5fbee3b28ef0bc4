//! Validates a question and reports all problems at once; pointers refer to the question.

use super::base_facts::BaseFacts;
use super::cases::{Case, Origin, cases, count};
use super::document::{Change, Distribution, LimitMeasure, ParameterDocument, SampleMethod, WhatIfDocument};
use super::misfit::Misfit;
use super::sampling::MOST_SOBOL_DIMENSIONS;
use super::spread;
use crate::measure::depth_profile::deepest_node;
use crate::measure::summary::short;
use crate::mesh::names::shortened;
use crate::plan::compile;
use crate::scene::problem::{Pointer, Problem, suggest};
use crate::scene::validate::names::check_name;
use crate::scene::validate::{Findings, check_document};
use crate::scene::{Budget, Loaded, MeshSource, load_document, on_meshes_of};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of parameters in a question.
const MOST_PARAMETERS: usize = 32;
/// Maximum number of limits in a question; each takes about a dozen runs.
const MOST_LIMITS: usize = 32;
/// Maximum number of runs in a question.
const MOST_CASES: u64 = 20_000;

/// Validates a question about a loaded base.
///
/// # Errors
/// All problems at once. Every parameter is tested at both ends of its range, every explicit case as given.
pub fn check(
    question: &WhatIfDocument,
    base: &Loaded,
    source: &(dyn MeshSource + Sync),
    budget: &Budget,
) -> Result<(), Vec<Problem>> {
    let mut out = Findings::default();
    let root = Pointer::root();
    amounts(question, &mut out);
    let facts = BaseFacts::of(base, source, budget);
    for (index, parameter) in question.parameters.iter().enumerate() {
        let here = root.key("parameters").index(index);
        check_parameter(&here, question, parameter, &mut out);
        if let Some(Distribution::Library { set }) = &parameter.distribution {
            spread::check(set, &parameter.change, &base.scene.document, &here.key("distribution"), &mut out);
        }
        if let Err(misfit) = parameter.change.value_in(&base.scene.document, &facts) {
            out.push(problem_of(&misfit, &here.key("change")));
        }
    }
    check_names(question, &mut out);
    check_cases(question, &mut out);
    check_sample(question, &mut out);
    check_limits(question, &mut out);
    if out.0.is_empty() {
        try_ends(question, base, &facts, source, budget, &mut out);
        try_cases(question, base, &facts, budget, &mut out);
        try_depths(question, base, &mut out);
    }
    if out.0.is_empty() { Ok(()) } else { Err(out.0.into_vec()) }
}

/// A problem for a change that does not fit the scene, at `here`.
fn problem_of(misfit: &Misfit, here: &Pointer) -> Problem {
    Problem::error("unfit_change", &here.key(misfit.field), misfit.message.clone())
        .value(misfit.value.clone())
        .limit(misfit.limit.clone())
        .remedy(misfit.remedy.clone())
}

/// A problem for a value that does not fit the scene, at the value itself rather than at a member of the change.
fn misplaced(misfit: &Misfit, here: &Pointer) -> Problem {
    Problem { pointer: here.as_str().to_owned(), ..problem_of(misfit, here) }
}

fn amounts(question: &WhatIfDocument, out: &mut Findings) {
    let root = Pointer::root();
    let asks = !question.cases.is_empty()
        || question.one_at_a_time
        || question.sample.is_some()
        || !question.limits.is_empty();
    out.require(asks, || {
        Problem::error(
            "nothing_requested",
            &root,
            "the question has no case, no sensitivity, no sample and no limit",
        )
        .limit("at least one of them")
        .remedy("give `cases`, `\"one_at_a_time\": true`, a `sample` or `limits`")
    });
    for (name, length, most) in [
        ("parameters", question.parameters.len(), MOST_PARAMETERS),
        ("limits", question.limits.len(), MOST_LIMITS),
    ] {
        out.require(length <= most, || {
            Problem::error("too_many_items", &root.key(name), format!("there are very many {name}"))
                .value(length)
                .limit(format!("at most {most}"))
                .remedy("ask more than one question")
        });
    }
    out.require(!question.parameters.is_empty(), || {
        Problem::error("no_parameters", &root.key("parameters"), "nothing varies")
            .value(0)
            .limit("at least one parameter")
            .remedy(
                "say what varies: on the command line `--vary speed=80..120`, in a question \
                 {\"name\": \"speed\", \"change\": {\"kind\": \"speed_m_per_s\"}, \"low\": 80, \"high\": 120}",
            )
    });
    // Total number of runs.
    let runs = count(question);
    out.require(runs <= MOST_CASES, || {
        Problem::error("too_many_cases", &root, format!("the question takes {runs} runs"))
            .value(runs)
            .limit(format!("at most {MOST_CASES}"))
            .remedy("take fewer points or parameters")
    });
}

fn check_parameter(
    here: &Pointer,
    question: &WhatIfDocument,
    parameter: &ParameterDocument,
    out: &mut Findings,
) {
    let index = |name: &str| here.key(name);
    // Ends of the range and parameters of the distribution.
    for (name, value) in [("low", parameter.low), ("high", parameter.high)] {
        out.require(value.is_none_or(f64::is_finite), || {
            Problem::error("not_finite", &index(name), "the end of the range is not finite")
                .limit("a finite number")
        });
    }
    let spread = here.key("distribution");
    match &parameter.distribution {
        // Between sources: with the scene, see `spread`.
        None | Some(Distribution::Library { .. }) => {}
        Some(Distribution::Normal { mean, standard_deviation }) => {
            out.require(mean.is_finite(), || {
                Problem::error("not_finite", &spread.key("mean"), "the mean is not finite")
                    .limit("a finite number")
                    .remedy("give the mean in the unit of the change")
            });
            let remedy = "give it in the unit of the change";
            out.positive(
                &spread.key("standard_deviation"),
                "the standard deviation",
                *standard_deviation,
                remedy,
            );
        }
        Some(Distribution::LogNormal { median, coefficient_of_variation }) => {
            out.positive(&spread.key("median"), "the median", *median, "give it in the unit of the change");
            let remedy = "0.3 is thirty per cent";
            out.positive(
                &spread.key("coefficient_of_variation"),
                "the variation",
                *coefficient_of_variation,
                remedy,
            );
        }
    }
    // A range is needed for sensitivities, limits, and samples without a distribution.
    let needs_range = question.one_at_a_time
        || (question.sample.is_some() && parameter.distribution.is_none())
        || question.limits.iter().any(|limit| limit.parameter == parameter.name);
    match parameter.range() {
        Some([low, high]) => out.require(low < high || !needs_range, || {
            Problem::error("empty_range", &index("high"), "the range is empty")
                .value(high)
                .limit(format!("> {}", short(low)))
                .remedy("give `low` below `high`")
        }),
        // A library that states none is reported with the scene.
        None if parameter.distribution.is_some() => {}
        None => out.require(!needs_range, || {
            Problem::error("no_range", here, format!("{:?} has no range", parameter.name))
                .limit("`low` and `high`, or a distribution")
                .remedy("give the range in which it varies")
        }),
    }
    check_change(&here.key("change"), &parameter.change, out);
}

/// Validates what can be checked without a scene.
fn check_change(here: &Pointer, change: &Change, out: &mut Findings) {
    match change {
        Change::Angle { about, .. } => out.direction(&here.key("about"), "the axis", *about),
        Change::Offset { along, .. } | Change::ImpactOffset { along, .. } => {
            out.direction(&here.key("along"), "the direction", *along);
        }
        Change::StiffnessPercentile { coefficient_of_variation: variation, .. } => {
            out.positive(
                &here.key("coefficient_of_variation"),
                "the variation",
                *variation,
                "0.3 is thirty per cent",
            );
        }
        _ => {}
    }
}

fn check_names(question: &WhatIfDocument, out: &mut Findings) {
    let mut seen = BTreeSet::new();
    for (index, parameter) in question.parameters.iter().enumerate() {
        let here = Pointer::root().key("parameters").index(index).key("name");
        check_name(&parameter.name, &here, out);
        out.require(!parameter.name.is_empty() && seen.insert(&parameter.name), || {
            Problem::error("bad_name", &here, "the name is empty, or that of an earlier parameter")
                .value(shortened(&parameter.name))
                .limit("a name of its own")
                .remedy("name it after what it changes")
        });
    }
}

fn check_cases(question: &WhatIfDocument, out: &mut Findings) {
    let names = || question.parameters.iter().map(|parameter| parameter.name.as_str());
    for (index, case) in question.cases.iter().enumerate() {
        let here = Pointer::root().key("cases").index(index);
        check_name(case.name.as_deref().unwrap_or_default(), &here.key("name"), out);
        let here = here.key("set");
        for (name, value) in &case.set {
            out.require(names().any(|known| known == name), || unknown(&here.key(name), name, names()));
            out.require(value.is_finite(), || {
                Problem::error("not_finite", &here.key(name), "the value is not finite")
                    .limit("a finite number")
            });
        }
    }
}

fn unknown<'a>(here: &Pointer, name: &str, names: impl Iterator<Item = &'a str>) -> Problem {
    Problem::error("unknown_parameter", here, format!("no parameter is called {name:?}"))
        .value(name)
        .limit("the name of a parameter")
        .remedy(suggest(name, names))
}

fn check_sample(question: &WhatIfDocument, out: &mut Findings) {
    let Some(sample) = question.sample else { return };
    let here = Pointer::root().key("sample");
    out.require(sample.count >= 2, || {
        Problem::error("out_of_range", &here.key("count"), "a sample has two points or more")
            .value(sample.count)
            .limit(">= 2")
            .remedy("64 is a beginning")
    });
    let parameters = question.parameters.len();
    let dimensions = if sample.indices { 2 * parameters } else { parameters };
    out.require(sample.method != SampleMethod::Sobol || dimensions <= MOST_SOBOL_DIMENSIONS, || {
        Problem::error(
            "too_many_dimensions",
            &here,
            "the sequence of Sobol is not known in so many dimensions",
        )
        .value(dimensions)
        .limit(format!("at most {MOST_SOBOL_DIMENSIONS} dimensions; indices take two for each parameter"))
        .remedy("vary fewer parameters, or take \"latin_hypercube\"")
    });
}

fn check_limits(question: &WhatIfDocument, out: &mut Findings) {
    let names = || question.parameters.iter().map(|parameter| parameter.name.as_str());
    for (index, limit) in question.limits.iter().enumerate() {
        let here = Pointer::root().key("limits").index(index);
        let name = limit.parameter.as_str();
        out.require(names().any(|known| known == name), || unknown(&here.key("parameter"), name, names()));
        out.between(
            &here.key("tolerance"),
            "the tolerance",
            limit.tolerance,
            [1e-6, 0.5],
            "1e-3 is the default",
        );
        out.require(limit.at_most.is_finite(), || {
            Problem::error("not_finite", &here.key("at_most"), "the limit is not finite")
                .limit("a finite number")
        });
        if let LimitMeasure::VonMisesPaBelowDepthM(depth) = limit.measure {
            let place = here.key("measure").key("von_mises_pa_below_depth_m");
            out.not_negative(&place, "the depth", depth, "give it in metres: 10 mm is 0.01");
        }
    }
}

/// Loads the scene in full with each parameter at each end of its range.
fn try_ends(
    question: &WhatIfDocument,
    base: &Loaded,
    facts: &BaseFacts,
    source: &dyn MeshSource,
    budget: &Budget,
    out: &mut Findings,
) {
    for (index, parameter) in question.parameters.iter().enumerate() {
        // Ends that are not given follow from the distribution.
        let ends = [("low", parameter.low), ("high", parameter.high)]
            .map(|(end, written)| if written.is_some() { end } else { "distribution" });
        for (end, value) in ends.into_iter().zip(parameter.range().into_iter().flatten()) {
            let here = Pointer::root().key("parameters").index(index).key(end);
            let values = BTreeMap::from([(index, value)]);
            let case = Case { name: String::new(), origin: Origin::Base, values };
            let found = match case.scene(question, &base.scene.document, facts) {
                Err((_, misfit)) => {
                    out.push(misplaced(&misfit, &here));
                    continue;
                }
                // Most changes leave the meshes unchanged, whose generation and validation dominate the cost.
                Ok(scene) => on_meshes_of(&base.scene, &scene, budget)
                    .unwrap_or_else(|| load_document(scene, source, budget).map(|loaded| loaded.scene))
                    .map_or_else(|problems| problems.0, |_| Vec::new()),
            };
            let what = format!("with {:?} = {}", parameter.name, short(value));
            out.0.extend(found.into_iter().filter(Problem::is_error).map(|p| placed(p, &here, &what, value)));
        }
    }
}

/// Validates the documents of the explicit cases; their meshes are generated when they run.
fn try_cases(
    question: &WhatIfDocument,
    base: &Loaded,
    facts: &BaseFacts,
    budget: &Budget,
    out: &mut Findings,
) {
    let by_hand = cases(question).into_iter().filter(|case| case.origin == Origin::Case).enumerate();
    for (index, case) in by_hand {
        let here = Pointer::root().key("cases").index(index);
        let place = |parameter: usize| here.key("set").key(&question.parameters[parameter].name);
        let what = format!("in the case {:?}", case.name);
        let found = match case.scene(question, &base.scene.document, facts) {
            Err((parameter, misfit)) => {
                let problem = misplaced(&misfit, &place(parameter));
                out.push(Problem { message: format!("{what}: {}", problem.message), ..problem });
                continue;
            }
            Ok(scene) => check_document(&scene, budget).0.into_vec(),
        };
        // With several values, the offending one cannot be identified.
        let mut set = case.values.keys();
        let here = match (set.next(), set.next()) {
            (Some(only), None) => place(*only),
            _ => here,
        };
        let mut reported: Vec<Problem> = Vec::new();
        for problem in found.into_iter().filter(Problem::is_error) {
            // One value may occur in several places of the scene: it is reported once.
            if reported.iter().all(|t| (&t.code, &t.value) != (&problem.code, &problem.value)) {
                let value = problem.value.clone();
                reported.push(placed(problem, &here, &what, value));
            }
        }
        out.0.extend(reported);
    }
}

/// Checks that the tissue of the base is deep enough for the limits.
fn try_depths(question: &WhatIfDocument, base: &Loaded, out: &mut Findings) {
    let depths = question.limits.iter().map(|limit| limit.measure.depth());
    if depths.clone().all(|depth| depth.is_none()) {
        return;
    }
    // A base that cannot be compiled fails with its own message when it runs.
    let Ok(plan) = compile(&base.scene) else { return };
    let deepest = deepest_node(&plan);
    for (index, depth) in depths.enumerate().filter_map(|(index, depth)| Some((index, depth?))) {
        let here = Pointer::root().key("limits").index(index).key("measure");
        out.require(deepest.is_some_and(|deepest| depth <= deepest), || {
            let here = here.key("von_mises_pa_below_depth_m");
            Problem::error("too_deep", &here, "the base's tissue is not that deep")
                .value(depth)
                .limit(deepest.map_or_else(
                    || "a tissue with a surface to measure depth from".into(),
                    |d| format!("at most {} m", short(d)),
                ))
                .remedy("give a smaller depth in metres: 10 mm is 0.01")
        });
    }
}

/// A problem of a modified scene, located at the place in the question that modified it.
fn placed(problem: Problem, here: &Pointer, what: &str, value: impl Into<serde_json::Value>) -> Problem {
    let message = format!("{what}, {} of the scene: {}", problem.pointer, problem.message);
    Problem { pointer: here.as_str().to_owned(), message, value: value.into(), ..problem }
}
