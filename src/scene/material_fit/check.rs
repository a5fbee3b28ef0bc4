//! Checks of the question of a fit.

use super::document::{Errors, FitQuestion, TestDocument, TestKind};
use super::parameter::Parameter;
use crate::scene::problem::{Pointer, Problem, suggest};
use crate::scene::validate::Findings;
use std::collections::BTreeSet;

/// Stretches that make no one ask whether they are per cent [-].
const USUAL_STRETCHES: [f64; 2] = [0.05, 8.0];

/// Upper bound of the number of points of all tests.
const MOST_POINTS: usize = 100_000;

/// Upper bound of the number of free parameters.
const MOST_FREE: usize = 16;

/// Collects all problems of the constants, the free parameters and the curves.
pub(super) fn check(question: &FitQuestion, out: &mut Findings) {
    out.0.extend(question.constants().check());
    check_free(question, out);
    for (index, test) in question.tests.iter().enumerate() {
        check_test(question, test, &TestDocument::place(index), out);
    }
    check_amounts(question, out);
}

fn check_free(question: &FitQuestion, out: &mut Findings) {
    let here = Pointer::root().key("free");
    let (constants, mut seen) = (question.constants(), BTreeSet::new());
    let known = constants.pointers();
    out.require((1..=MOST_FREE).contains(&question.free.len()), || {
        Problem::error("number_of_parameters", &here, "the number of free parameters is out of its range")
            .value(question.free.len())
            .limit(format!("1 to {MOST_FREE}"))
            .remedy("name the numbers to fit, such as \"/material/c10_pa\"")
    });
    for (i, pointer) in question.free.iter().enumerate() {
        let here = here.index(i);
        out.require(known.contains(pointer), || {
            Problem::error("unknown_parameter", &here, "there is no such number to fit")
                .value(pointer.as_str())
                .limit("a JSON pointer to a number in \"material\" or \"prony_series\"")
                .remedy(suggest(pointer, known.iter().map(String::as_str)))
        });
        out.require(seen.insert(pointer), || {
            Problem::error("repeated", &here, "the parameter is named twice")
                .value(pointer.as_str())
                .limit("once")
                .remedy("remove one of them")
        });
        let parameter = Parameter::of(&constants, pointer, question.largest_pa());
        out.require(parameter.is_none_or(|p| p.start != 0.0 || !p.has_fixed_sign), || {
            Problem::error("starts_at_zero", &here, "a parameter that must not be negative starts at 0")
                .value(0.0)
                .limit("a starting value > 0, since its logarithm is fitted")
                .remedy(format!("give {pointer} a positive value"))
        });
        let of_series = pointer.starts_with("/prony_series/");
        let relaxes = question.tests.iter().any(|test| test.kind == TestKind::Relaxation);
        out.require(!of_series || relaxes, || {
            Problem::error("parameter_without_effect", &here, "no test depends on the Prony series")
                .value(pointer.as_str())
                .limit("a parameter of \"material\", unless a test is of relaxation")
                .remedy("add a test {\"kind\": \"relaxation\", …}")
        });
    }
}

fn check_test(question: &FitQuestion, test: &TestDocument, here: &Pointer, out: &mut Findings) {
    out.require(!test.points.is_empty() || test.csv.is_some(), || {
        Problem::error("no_points", here, "the test has no points")
            .value(0)
            .limit("at least one point")
            .remedy("give \"points\": [[1.1, 2500], …], or \"csv\": the name of a file")
    });
    out.require(test.kind != TestKind::Relaxation || question.prony_series.is_some(), || {
        Problem::error("missing_field", &here.key("kind"), "there is no Prony series to relax")
            .value("relaxation")
            .limit("\"prony_series\" in the question")
            .remedy("add \"prony_series\" with starting values")
    });
    let list = here.key(if test.csv.is_some() { "csv" } else { "points" });
    for (i, &[x, y]) in test.points.iter().enumerate() {
        // Points from a file are named by their number.
        let place = if test.csv.is_some() { list.clone() } else { list.index(i) };
        let (is_possible, limit) = match test.kind {
            TestKind::Uniaxial | TestKind::Equibiaxial => (x > 0.0, "a stretch > 0"),
            TestKind::Shear => (true, ""),
            TestKind::Relaxation => (x >= 0.0, "a time >= 0"),
        };
        out.require(is_possible, || {
            let what = format!("point {i} has an impossible {}", test.kind.columns()[0]);
            Problem::error("out_of_range", &place, what)
                .value(x)
                .limit(limit)
                .remedy("30 % tension is a stretch of 1.3; times are from the step of strain on")
        });
        out.require(question.errors == Errors::Absolute || y != 0.0, || {
            Problem::error("out_of_range", &place, format!("point {i} is 0, which has no relative error"))
                .value(y)
                .limit("not 0, with \"errors\": \"relative\"")
                .remedy("remove the point at rest, or fit absolute errors")
        });
    }
    if matches!(test.kind, TestKind::Uniaxial | TestKind::Equibiaxial) {
        let most = test.points.iter().map(|[stretch, _]| *stretch).fold(1.0, f64::max);
        out.usual(&list, "the largest stretch", most, USUAL_STRETCHES, "30 % tension is a stretch of 1.3");
    }
}

fn check_amounts(question: &FitQuestion, out: &mut Findings) {
    let here = Pointer::root().key("tests");
    let points: usize = question.tests.iter().map(|test| test.points.len()).sum();
    let free = question.free.len();
    // Files that could not be read are reported already.
    let is_known = question.tests.iter().all(|test| !test.points.is_empty());
    out.require(!is_known || points >= free.max(1), || {
        Problem::error("too_few_points", &here, "the curves have fewer points than parameters are free")
            .value(points)
            .limit(format!("at least {}; intervals need more", free.max(1)))
            .remedy("add points, or fit fewer parameters")
    });
    out.require(points <= MOST_POINTS, || {
        Problem::error("too_many_items", &here, "the curves have very many points")
            .value(points)
            .limit(format!("at most {MOST_POINTS}"))
            .remedy("thin the curves out: neighbouring points carry the same information")
    });
}
