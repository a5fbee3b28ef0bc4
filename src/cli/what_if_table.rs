//! What-if answers as tables and CSV.

use super::plan::write_table;
use crate::measure::QuantityOfInterest;
use crate::measure::summary::{marked, number, rounded, within};
use crate::report::csv::text_cell;
use crate::study::what_if::document::LimitMeasure;
use crate::study::what_if::limit::Verdict;
use crate::study::what_if::surrogate::Surrogate;
use crate::study::what_if::{Answer, CaseAnswer, LimitAnswer, Matrix, Number, Origin};
use std::io::{self, Write};

/// Remark on a change that the mesh does not resolve.
const BELOW_ERROR: &str = "smaller than the numerical error of the number itself";

/// Remark on a sensitivity over a range that excludes the base.
const BASE_OUTSIDE: &str = "the base lies outside of the range: elasticity is at mid-range";

/// Maximum number of cases shown in the table.
const MOST_ROWS: usize = 40;

/// Prints one case; marks cases whose error bars are not yet known.
pub(super) fn write_case_line(
    case: &CaseAnswer,
    of: usize,
    awaits_errors: bool,
    out: &mut dyn Write,
) -> io::Result<()> {
    let number = |q: QuantityOfInterest| {
        let (title, unit) = (q.short_title(), q.unit());
        let is_lower_bound = case.lower_bounds.contains(&q);
        case.numbers.get(&q).map(|n| format!("{title} {} {unit}", with_error(n, is_lower_bound)))
    };
    let numbers: Vec<String> = QuantityOfInterest::HEADLINE.into_iter().filter_map(number).collect();
    let what = if numbers.is_empty() { case.ending.replace('_', " ") } else { numbers.join(", ") };
    let remark = if awaits_errors && !numbers.is_empty() { " (numerical errors not yet known)" } else { "" };
    writeln!(out, "{:>3} of {of}  {}: {what}{remark}", case.index + 1, case.name)
}

/// Describes what is missing of a stopped answer; `None` for a complete one.
pub(super) fn stopped(answer: &Answer) -> Option<String> {
    let why = answer.stopped?;
    let looked_for = match (answer.limits.len(), answer.requested_limits) {
        (_, 0) => String::new(),
        (0, _) => "; no limits were evaluated".into(),
        (found, requested) => format!("; {found} of {requested} limit(s) were evaluated"),
    };
    Some(format!("STOPPED ({why}): {} of {} case(s){looked_for}", answer.cases.len(), answer.requested_cases))
}

/// Writes the complete answer.
pub(super) fn write_answer(answer: &Answer, out: &mut dyn Write) -> io::Result<()> {
    let stopped = stopped(answer);
    let extent = stopped.clone().unwrap_or_else(|| format!("{} case(s)", answer.cases.len()));
    writeln!(out, "\n{}: {extent}\n", answer.scene)?;
    // Headline numbers of the first cases.
    let mut header = vec!["case".to_owned()];
    header.extend(QuantityOfInterest::HEADLINE.map(|q| title(answer, q)));
    let rows: Vec<Vec<String>> = answer.cases.iter().take(MOST_ROWS).map(cells).collect();
    write_table(&header, &rows, out)?;
    let has_brackets = |case: &CaseAnswer| {
        QuantityOfInterest::HEADLINE
            .iter()
            .filter_map(|q| case.numbers.get(q))
            .any(|number| !number.is_resolved())
    };
    if answer.cases.iter().any(has_brackets) {
        writeln!(
            out,
            "(in brackets: error not estimated, or not resolved by the mesh: smaller than its numerical error, or a pointwise peak)"
        )?;
    }
    if answer.cases.len() > MOST_ROWS {
        writeln!(out, "… and {} more: --csv or --json has them all", answer.cases.len() - MOST_ROWS)?;
    }
    // Source of the errors, failed cases, and truncated regions.
    writeln!(out, "errors: {}", answer.error_bars)?;
    for case in answer.cases.iter().filter(|case| case.reason.is_some()) {
        let ending = case.ending.replace('_', " ");
        writeln!(out, "{}: {ending}: {}", case.name, case.reason.as_deref().unwrap_or_default())?;
    }
    for case in answer.cases.iter().filter(|case| !case.reaches.is_empty()) {
        let ends = case.reaches.join(" and ");
        writeln!(out, "{}: the significant stress reaches {ends}: its depth is a lower bound", case.name)?;
    }
    for case in &answer.cases {
        let has_grown =
            |q: &&QuantityOfInterest| case.reaches.is_empty() || **q != QuantityOfInterest::StressDepthMm;
        let titles: Vec<&str> = case.lower_bounds.iter().filter(has_grown).map(|q| q.short_title()).collect();
        if !titles.is_empty() {
            let titles = titles.join(", ");
            writeln!(out, "{}: contact had not ended, lower bounds: {titles}", case.name)?;
        }
    }
    // Statistics and limits.
    write_sensitivities(answer, out)?;
    write_sample(answer, out)?;
    write_surrogates(answer, out)?;
    for limit in &answer.limits {
        writeln!(out, "\n{}", in_words(limit))?;
    }
    let effort = &answer.effort;
    writeln!(
        out,
        "\n{} run(s) computed, {} from the cache, {} in parallel, {:.2} s (first answer after {:.2} s)",
        effort.computed, effort.from_cache, effort.threads, effort.wall_s, effort.first_answer_s
    )?;
    stopped.map_or(Ok(()), |stopped| writeln!(out, "{stopped}"))?;
    writeln!(out, "\n{}", answer.notice)
}

/// Remark on results from fewer cases than requested.
fn of_stopped(answer: &Answer) -> &'static str {
    if answer.cases.len() < answer.requested_cases { " (STOPPED: not all that were requested)" } else { "" }
}

fn cells(case: &CaseAnswer) -> Vec<String> {
    let number = |q: QuantityOfInterest| {
        let shown = case.numbers.get(&q);
        shown.map_or_else(|| "-".into(), |shown| with_error(shown, case.lower_bounds.contains(&q)))
    };
    let mut cells: Vec<String> =
        std::iter::once(case.name.clone()).chain(QuantityOfInterest::HEADLINE.map(number)).collect();
    if case.numbers.is_empty() {
        cells[1] = case.ending.replace('_', " ");
    }
    cells
}

/// Title with unit, such as "depth of stress above 10 kPa [mm]".
fn title(answer: &Answer, quantity: QuantityOfInterest) -> String {
    let (title, unit) = answer.title(quantity);
    format!("{title} [{unit}]")
}

/// A number with its error, marked as in a summary.
fn with_error(shown: &Number, is_lower_bound: bool) -> String {
    let value = marked(&within(shown.value, shown.error), shown.is_resolved(), is_lower_bound);
    shown.error.map_or(value.clone(), |error| format!("{value} ± {}", rounded(error)))
}

/// Accuracy of the surrogates.
fn write_surrogates(answer: &Answer, out: &mut dyn Write) -> io::Result<()> {
    let shown: Vec<&Surrogate> =
        answer.surrogates.iter().filter(|s| QuantityOfInterest::HEADLINE.contains(&s.quantity)).collect();
    let Some(first) = shown.first() else { return Ok(()) };
    let degrees = if shown.iter().all(|s| s.degree == 2) { "second" } else { "first" };
    writeln!(
        out,
        "\nPolynomials of {degrees} degree through {} cases{} predict others (`surrogates` in --json); errors in leave-one-out cross-validation:",
        first.cases,
        of_stopped(answer)
    )?;
    let header = ["number", "", "fraction of the variance predicted"];
    let rows: Vec<[String; 3]> = shown
        .iter()
        .map(|s| {
            let explained = |s: &Surrogate| {
                s.hold_out_explained_variance.map_or_else(|| "the number is constant".into(), number)
            };
            let (title, unit) = answer.title(s.quantity);
            [title.to_owned(), format!("{} {unit}", rounded(s.hold_out_error)), explained(s)]
        })
        .collect();
    write_table(&header, &rows, out)
}

fn write_sensitivities(answer: &Answer, out: &mut dyn Write) -> io::Result<()> {
    if answer.sensitivities.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nOne at a time, low end, base and high end, the largest difference first:")?;
    let header = [
        "number",
        "rank",
        "parameter",
        "range",
        "difference",
        "from end to end",
        "per unit",
        "elasticity",
        "",
    ];
    let unit_of = |name: &str| answer.parameters.iter().find(|p| p.name == name).map_or("-", |p| p.unit);
    let shown = answer.sensitivities.iter().filter(|s| QuantityOfInterest::HEADLINE.contains(&s.quantity));
    // One row per number and parameter.
    let rows: Vec<[String; 9]> = shown
        .map(|s| {
            let (title, unit) = answer.title(s.quantity);
            let mut remarks = Vec::new();
            remarks.extend((!s.is_monotone).then_some("not monotone"));
            remarks.extend((!s.is_base_in_range).then_some(BASE_OUTSIDE));
            remarks.extend((s.exceeds_numerical_error == Some(false)).then_some(BELOW_ERROR));
            [
                title.to_owned(),
                s.rank.to_string(),
                s.parameter.clone(),
                format!(
                    "{} … {} {}",
                    number(s.parameter_values[0]),
                    number(s.parameter_values[2]),
                    unit_of(&s.parameter)
                ),
                format!("{} {unit}", number(s.span)),
                format!("{}{} {unit}", if s.change > 0.0 { "+" } else { "" }, number(s.change)),
                number(s.per_unit),
                s.elasticity.map_or_else(|| "-".into(), number),
                remarks.join(", "),
            ]
        })
        .collect();
    write_table(&header, &rows, out)
}

fn write_sample(answer: &Answer, out: &mut dyn Write) -> io::Result<()> {
    if !answer.spread.is_empty() {
        // Distribution and correlations.
        writeln!(out, "\nSpread over the sample{}:", of_stopped(answer))?;
        let header =
            ["number", "cases", "mean", "deviation", "P5", "median", "P95", "correlates with (Spearman)", ""];
        let shown = answer.spread.iter().filter(|s| QuantityOfInterest::HEADLINE.contains(&s.quantity));
        let rows: Vec<[String; 9]> = shown
            .map(|s| {
                let with = answer.correlations.iter().filter(|c| c.quantity == s.quantity);
                let with: Vec<String> = with.map(|c| format!("{} {:+.2}", c.parameter, c.spearman)).collect();
                let [mean, deviation, p5, median, p95] =
                    [s.mean, s.standard_deviation, s.p5, s.median, s.p95].map(number);
                let title = title(answer, s.quantity);
                [
                    title,
                    s.count.to_string(),
                    mean,
                    deviation,
                    p5,
                    median,
                    p95,
                    with.join(", "),
                    remark(answer, s.quantity),
                ]
            })
            .collect();
        write_table(&header, &rows, out)?;
    }
    if !answer.sobol_indices.is_empty() {
        // Sobol indices.
        writeln!(out, "\nSobol indices: fraction of the variance, with 90 % bootstrap intervals:")?;
        let rows: Vec<[String; 5]> = answer
            .sobol_indices
            .iter()
            .filter(|s| QuantityOfInterest::HEADLINE.contains(&s.quantity))
            .map(|s| {
                let interval = |x: f64, [low, high]: [f64; 2]| format!("{x:.2} ({low:.2} … {high:.2})");
                let (first, total) =
                    (interval(s.first, s.first_interval), interval(s.total, s.total_interval));
                let remark = if s.is_converged {
                    remark(answer, s.quantity)
                } else {
                    "too few points: the interval is too wide".into()
                };
                [answer.title(s.quantity).0.to_owned(), s.parameter.clone(), first, total, remark]
            })
            .collect();
        write_table(&["number", "parameter", "first order", "total", ""], &rows, out)?;
    } else if answer.cases.len() < answer.requested_cases && answer.cases.iter().any(is_for_indices) {
        writeln!(out, "\nNo Sobol indices: they take all points of the sample")?;
    }
    Ok(())
}

/// Whether a case was run for Sobol indices only.
fn is_for_indices(case: &CaseAnswer) -> bool {
    matches!(case.origin, Origin::Sample { matrix: Matrix::B | Matrix::Mixed(_), .. })
}

/// Remark on the spread of a number.
fn remark(answer: &Answer, quantity: QuantityOfInterest) -> String {
    let spread = answer.spread.iter().find(|s| s.quantity == quantity);
    let is_below = spread.is_some_and(|s| s.exceeds_numerical_error == Some(false));
    if is_below { BELOW_ERROR.into() } else { String::new() }
}

/// "speed: von Mises stress from 10 mm on stays at or below 30000 Pa up to 93.2 m/s (…)".
fn in_words(answer: &LimitAnswer) -> String {
    let what = match answer.measure {
        LimitMeasure::Quantity(quantity) => quantity.short_title().to_owned(),
        LimitMeasure::VonMisesPaBelowDepthM(depth) => {
            format!("von Mises stress from {} mm below the surface on", number(1e3 * depth))
        }
    };
    let (name, unit, limit) = (&answer.parameter, answer.unit, number(answer.at_most));
    let measured = answer.measure.unit();
    let ends = |values: &[f64; 2]| format!("{} and {} {measured}", number(values[0]), number(values[1]));
    let head = format!("{name}: the {what} stays at or below {limit} {measured}");
    // The bracket in words.
    let bracket = |word: &str, kept: f64, value: f64, broken: f64, value_broken: f64| {
        format!(
            "{head} {word} {} {unit} ({} {measured} there, {} {measured} at {} {unit}; {} runs; {})",
            number(kept),
            number(value),
            number(value_broken),
            number(broken),
            answer.runs,
            error_in_words(answer)
        )
    };
    match &answer.verdict {
        Verdict::KeptUpTo { kept_at, value, broken_at, value_broken } => {
            bracket("up to", *kept_at, *value, *broken_at, *value_broken)
        }
        Verdict::KeptFrom { kept_at, value, broken_at, value_broken } => {
            bracket("from", *kept_at, *value, *broken_at, *value_broken)
        }
        Verdict::KeptAtBothEnds { values } => format!(
            "{head} at both ends of the range ({}): no crossing is bracketed; {}",
            ends(values),
            error_in_words(answer)
        ),
        Verdict::BrokenAtBothEnds { values } => format!(
            "{name}: the {what} is above {limit} {measured} at both ends of the range ({}): no crossing is bracketed; {}",
            ends(values),
            error_in_words(answer)
        ),
        Verdict::Open { at, at_least } => format!(
            "{name}: no answer, since at {} {unit} the {what} is only known to be at least {} {measured}, which does not show \
             whether it stays at or below {limit} {measured}",
            number(*at),
            number(*at_least)
        ),
        Verdict::NoNumber { at, reason } => {
            format!("{name}: no answer, since there is no number at {} {unit}: {reason}", number(*at))
        }
    }
}

/// Effect of the numerical error of the number on the limit.
fn error_in_words(answer: &LimitAnswer) -> String {
    let Some(error) = answer.relative_error else { return "numerical error not estimated".into() };
    let at = |verdict: &Option<Verdict>| match verdict {
        Some(Verdict::KeptUpTo { kept_at, .. }) => format!("up to {} {}", number(*kept_at), answer.unit),
        Some(Verdict::KeptFrom { kept_at, .. }) => format!("from {} {} on", number(*kept_at), answer.unit),
        Some(Verdict::KeptAtBothEnds { .. }) => "kept at both ends of the range".into(),
        Some(Verdict::BrokenAtBothEnds { .. }) => "broken at both ends of the range".into(),
        Some(Verdict::Open { .. } | Verdict::NoNumber { .. }) | None => "no answer".into(),
    };
    let percent = format!("± {} %", rounded(100.0 * error));
    if answer.resolved == Some(false) {
        let why =
            if error < 1.0 { ", and is a peak for which two meshes cannot show convergence" } else { "" };
        return format!("NOT RESOLVED: the number has a numerical error of {percent}{why}");
    }
    format!(
        "with the numerical error of {percent}: {} if the number is larger by it, {} if it is smaller",
        at(&answer.if_larger),
        at(&answer.if_smaller)
    )
}

/// One line per case: parameters, without edits, and every number with its error.
pub(super) fn write_csv(answer: &Answer, out: &mut dyn Write) -> io::Result<()> {
    let mut header = vec!["case".to_owned(), "ending".into(), "steps".into()];
    header.extend(answer.parameters.iter().map(|p| text_cell(&format!("{} [{}]", p.name, p.unit))));
    header.extend(QuantityOfInterest::ALL.into_iter().flat_map(|q| [q.to_string(), format!("{q}_error")]));
    writeln!(out, "{}", header.join(","))?;
    for case in &answer.cases {
        let mut line = vec![text_cell(&case.name), case.ending.clone(), case.steps.to_string()];
        line.extend(answer.parameters.iter().map(|p| case.parameters[&p.name].to_string()));
        for quantity in QuantityOfInterest::ALL {
            let number = case.numbers.get(&quantity);
            line.push(number.map_or_else(String::new, |n| n.value.to_string()));
            line.push(number.and_then(|n| n.error).map_or_else(String::new, |error| error.to_string()));
        }
        writeln!(out, "{}", line.join(","))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(verdict: Verdict, relative_error: Option<f64>, resolved: Option<bool>) -> LimitAnswer {
        LimitAnswer {
            parameter: "speed".into(),
            unit: "m/s",
            measure: LimitMeasure::Quantity(QuantityOfInterest::PeakForceN),
            at_most: 2000.0,
            verdict,
            relative_error,
            resolved,
            if_larger: None,
            if_smaller: None,
            runs: 2,
        }
    }

    #[test]
    fn limits_without_a_bracket_have_the_error() {
        let kept = || Verdict::KeptAtBothEnds { values: [1500.0, 1900.0] };
        let broken = || Verdict::BrokenAtBothEnds { values: [2100.0, 2900.0] };
        for verdict in [kept(), broken()] {
            let words = in_words(&limit(verdict.clone(), Some(1.2), Some(false)));
            assert!(words.contains("NOT RESOLVED: the number has a numerical error of ± 120 %"), "{words}");
            let words = in_words(&limit(verdict.clone(), Some(0.62), Some(false)));
            assert!(words.contains("NOT RESOLVED") && words.contains("a peak"), "{words}");
            assert!(in_words(&limit(verdict, None, None)).contains("numerical error not estimated"));
        }
        let bracket =
            Verdict::KeptUpTo { kept_at: 93.0, value: 1999.0, broken_at: 93.1, value_broken: 2001.0 };
        let words = in_words(&LimitAnswer {
            if_larger: Some(bracket),
            if_smaller: Some(kept()),
            ..limit(kept(), Some(0.1), Some(true))
        });
        assert!(words.contains("up to 93.00 m/s if the number is larger by it"), "{words}");
        assert!(words.contains("kept at both ends of the range if it is smaller"), "{words}");
    }

    #[test]
    fn numbers_that_are_not_resolved_stand_in_brackets() {
        let written = |value, error, may_be_resolved, is_lower_bound| {
            with_error(&Number::new(value, error, may_be_resolved), is_lower_bound)
        };
        assert_eq!(written(2734.0, Some(140.0), true, false), "2730 ± 140");
        assert_eq!(written(2734.0, Some(140.0), true, true), "≥ 2730 ± 140");
        assert_eq!(written(2734.0, Some(140.0), false, false), "(2730) ± 140");
        assert_eq!(written(2734.0, Some(2800.0), true, false), "(2700) ± 2800");
        assert_eq!(written(0.0, Some(0.0), true, false), "0 ± 0");
        assert_eq!(written(2734.0, None, true, false), "(2734)");
    }
}
