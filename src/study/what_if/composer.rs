//! Composes the answer case by case, with the statistics at the end.

use super::answer::{Answer, Effort, LimitAnswer, ParameterAnswer, Partial};
use super::base_facts::BaseFacts;
use super::cache::Numbers;
use super::case_answer::{CaseAnswer, Number};
use super::cases::{Case, Matrix, Origin};
use super::document::{ErrorSource, LimitDocument, LimitMeasure, WhatIfDocument};
use super::limit::{Evaluated, find_limit};
use super::runner::{Answered, Memory, Runner, Task};
use super::statistics::{
    Correlation, Sensitivity, SobolIndex, SobolRow, Spread, is_converged, rank, sobol_indices, spearman,
};
use super::surrogate::surrogates;
use crate::measure::QuantityOfInterest;
use crate::measure::summary::NOTICE;
use crate::scene::document::SceneDocument;
use crate::step::Interrupt;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

/// Accumulates the answer as cases and limits complete.
pub(super) struct Composer<'a> {
    question: &'a WhatIfDocument,
    base: &'a SceneDocument,
    facts: &'a BaseFacts<'a>,
    count: usize,
    parameters: Vec<ParameterAnswer>,
    relative_errors: BTreeMap<QuantityOfInterest, f64>,
    /// Numbers that the base does not resolve.
    unresolved: BTreeSet<QuantityOfInterest>,
    /// Relative error of the stress below each requested depth, in the base [-].
    relative_errors_below: Vec<Option<f64>>,
    cases: Vec<CaseAnswer>,
    limits: Vec<LimitAnswer>,
    limit_was_stopped: bool,
    started: Instant,
    effort: Effort,
}

impl<'a> Composer<'a> {
    pub fn new(
        question: &'a WhatIfDocument,
        base: &'a SceneDocument,
        facts: &'a BaseFacts<'a>,
        count: usize,
    ) -> Self {
        let parameters = question.parameters.iter().map(|parameter| ParameterAnswer {
            name: parameter.name.clone(),
            unit: parameter.change.unit(),
            // The question has been validated: every change fits the base.
            base_value: parameter.change.value_in(base, facts).unwrap_or(f64::NAN),
            range: parameter.range(),
        });
        Self {
            question,
            base,
            facts,
            count,
            parameters: parameters.collect(),
            relative_errors: BTreeMap::new(),
            unresolved: BTreeSet::new(),
            relative_errors_below: Vec::new(),
            cases: Vec::new(),
            limits: Vec::new(),
            limit_was_stopped: false,
            started: Instant::now(),
            effort: Effort { threads: 0, computed: 0, from_cache: 0, first_answer_s: 0.0, wall_s: 0.0 },
        }
    }

    fn note(&mut self, answered: &Answered) {
        *(if answered.from_cache { &mut self.effort.from_cache } else { &mut self.effort.computed }) += 1;
    }

    /// Adds the error bars of the base, which apply to all cases, including those already present.
    pub fn take_errors(&mut self, answered: &Answered, report: &mut dyn FnMut(Partial)) {
        self.note(answered);
        self.take_errors_below(&answered.numbers);
        let Numbers { values, errors, unresolved, .. } = &answered.numbers;
        self.unresolved.clone_from(unresolved);
        let relative = |(quantity, error): (&QuantityOfInterest, &f64)| {
            let value = values.get(quantity).filter(|value| **value != 0.0)?;
            Some((*quantity, (error / value).abs()))
        };
        self.relative_errors = errors.iter().filter_map(relative).collect();
        for case in &mut self.cases {
            for (quantity, number) in &mut case.numbers {
                let error = relative_error(&self.relative_errors, *quantity, number.value);
                *number = Number::new(number.value, error, !unresolved.contains(quantity));
            }
        }
        report(Partial::ErrorBars { relative_errors: &self.relative_errors });
    }

    /// Adds the errors of the stresses below depths, as found in the base.
    fn take_errors_below(&mut self, numbers: &Numbers) {
        let Numbers { von_mises_below_pa, von_mises_below_error_pa, .. } = numbers;
        let relative = |(error, value): (&Option<f64>, &f64)| error.map(|e| relative_to(e, *value));
        self.relative_errors_below =
            von_mises_below_error_pa.iter().zip(von_mises_below_pa).map(relative).collect();
    }

    /// Adds the answer of a case.
    pub fn take_case(&mut self, case: &Case, answered: Answered, report: &mut dyn FnMut(Partial)) {
        self.note(&answered);
        // The first case is the base.
        if self.cases.is_empty() {
            self.take_errors_below(&answered.numbers);
            self.effort.first_answer_s = self.started.elapsed().as_secs_f64();
        }
        let Numbers { ending, reason, reaches, lower_bounds, steps, values, errors, unresolved, .. } =
            answered.numbers;
        // Numbers with their own errors, otherwise with the relative errors of the base.
        let number = |(quantity, value): (QuantityOfInterest, f64)| {
            let (error, unresolved) = match errors.get(&quantity) {
                Some(own) => (Some(*own), &unresolved),
                None => (relative_error(&self.relative_errors, quantity, value), &self.unresolved),
            };
            (quantity, Number::new(value, error, !unresolved.contains(&quantity)))
        };
        let of_parameter = |(index, parameter): (usize, &ParameterAnswer)| {
            (parameter.name.clone(), case.values.get(&index).copied().unwrap_or(parameter.base_value))
        };
        let answer = CaseAnswer {
            index: self.cases.len(),
            name: case.name.clone(),
            origin: case.origin.clone(),
            parameters: self.parameters.iter().enumerate().map(of_parameter).collect(),
            edits: case.edits(self.question, self.base, self.facts),
            ending,
            reason,
            reaches,
            lower_bounds,
            steps,
            numbers: values.into_iter().map(number).collect(),
        };
        let units =
            self.parameters.iter().map(|parameter| (parameter.name.as_str(), parameter.unit)).collect();
        report(Partial::Case { of: self.count, units, case: &answer });
        self.cases.push(answer);
    }

    /// Searches for a limit by running the model.
    pub fn take_limit(
        &mut self,
        limit: &LimitDocument,
        runner: &Runner,
        threads: usize,
        report: &mut dyn FnMut(Partial),
    ) {
        let Some(index) = self.question.parameters.iter().position(|p| p.name == limit.parameter) else {
            return;
        };
        let Some(range) = self.question.parameters[index].range() else { return };
        let error_of_base = self.relative_error_of(limit.measure, &runner.depths);
        let relative_error = error_of_base.map(|(error, _)| error);
        let resolved = error_of_base.map(|(_, resolved)| resolved);
        let (mut memory, mut runs, mut was_stopped) = (Memory::default(), 0, false);
        // Each evaluation of the search is a run of the model.
        let mut find = |at_most: f64| {
            find_limit(range, at_most, limit.tolerance, &mut |value| {
                let values = BTreeMap::from([(index, value)]);
                let case = Case { name: String::new(), origin: Origin::Case, values };
                let answered = runner.answer(&Task { case: &case, with_errors: false }, threads, &mut memory);
                was_stopped |= answered.is_none();
                let answered = answered.ok_or("stopped before completion")?;
                runs += 1;
                self.note(&answered);
                number_of(limit.measure, &answered.numbers, &runner.depths)
            })
        };
        // The limit itself, and with the number larger or smaller by its error.
        let verdict = find(limit.at_most);
        let known = relative_error.filter(|_| resolved == Some(true));
        let if_larger = known.map(|error| find(limit.at_most / (1.0 + error)));
        let if_smaller = known.map(|error| find(limit.at_most / (1.0 - error)));
        self.limit_was_stopped |= was_stopped;
        let answer = LimitAnswer {
            parameter: limit.parameter.clone(),
            unit: self.parameters[index].unit,
            measure: limit.measure,
            at_most: limit.at_most,
            verdict,
            relative_error,
            resolved,
            if_larger,
            if_smaller,
            runs,
        };
        report(Partial::Limit(&answer));
        self.limits.push(answer);
    }

    /// Relative error of a number of the base [-], if known, and whether the number is resolved.
    fn relative_error_of(&self, measure: LimitMeasure, depths: &[f64]) -> Option<(f64, bool)> {
        let quantity = match measure {
            LimitMeasure::Quantity(quantity) => quantity,
            LimitMeasure::VonMisesPaBelowDepthM(depth) => {
                let error = (*self.relative_errors_below.get(index_of(depth, depths)?)?)?;
                return Some((error, error < 1.0));
            }
        };
        let number = self.cases.first()?.numbers.get(&quantity)?;
        Some((relative_to(number.error?, number.value), number.resolved?))
    }

    /// Whether every requested case and limit has its answer.
    fn is_complete(&self) -> bool {
        let has_limits = self.limits.len() == self.question.limits.len() && !self.limit_was_stopped;
        self.has_all_cases() && has_limits
    }

    fn has_all_cases(&self) -> bool {
        self.cases.len() == self.count
    }

    /// Completes the answer with the statistics.
    pub fn finish(self, interrupt: Option<Interrupt>, threads: usize) -> Answer {
        let (spread, correlations) = self.spread();
        // A stop after completion has no effect.
        let interrupt = interrupt.filter(|_| !self.is_complete());
        Answer {
            notice: NOTICE,
            engine_version: env!("CARGO_PKG_VERSION"),
            scene: self.base.name.clone(),
            quantities: QuantityOfInterest::titles(self.base.measures.stress_thresholds_pa.first().copied()),
            error_bars: self.error_bars_in_words(),
            sensitivities: self.sensitivities(),
            spread,
            correlations,
            sobol_indices: self.sobol_indices(),
            surrogates: surrogates(&self.cases),
            parameters: self.parameters,
            cases: self.cases,
            requested_cases: self.count,
            limits: self.limits,
            requested_limits: self.question.limits.len(),
            stopped: interrupt.map(|interrupt| match interrupt {
                Interrupt::Cancel => "cancelled",
                Interrupt::Deadline => "deadline",
                Interrupt::Steps { .. } | Interrupt::RecordingBytes { .. } => "budget",
            }),
            effort: Effort { threads, wall_s: self.started.elapsed().as_secs_f64(), ..self.effort },
        }
    }

    fn error_bars_in_words(&self) -> String {
        match self.question.error_bars {
            ErrorSource::None => "not estimated: error bars were not requested".into(),
            ErrorSource::Full => "of each case, from runs of it on another mesh: two levels, first order assumed, factor of safety 3".into(),
            ErrorSource::Base if self.cases.len() <= 1 && !self.has_all_cases() => "not estimated: stopped early".into(),
            ErrorSource::Base if self.relative_errors.is_empty() => "not estimated: the base has no error bars".into(),
            ErrorSource::Base => "the relative errors of the base, applied to every case: from runs of the base on another mesh \
                 (two levels, first order assumed, factor of safety 3)"
                .into(),
        }
    }

    fn sensitivities(&self) -> Vec<Sensitivity> {
        let Some(base) = self.cases.first() else { return Vec::new() };
        let mut all = Vec::new();
        for (index, parameter) in self.parameters.iter().enumerate() {
            let end = |high: bool| {
                let wanted = Origin::OneAtATime { parameter: index, is_high: high };
                self.cases.iter().find(|case| case.origin == wanted)
            };
            let (Some(low), Some(high)) = (end(false), end(true)) else { continue };
            for (quantity, number) in &base.numbers {
                let value = |case: &CaseAnswer| case.numbers.get(quantity).map(|number| number.value);
                let (Some(at_low), Some(at_high)) = (value(low), value(high)) else { continue };
                let at = |case: &CaseAnswer| case.parameters[&parameter.name];
                all.push(Sensitivity::new(
                    *quantity,
                    &parameter.name,
                    [at(low), parameter.base_value, at(high)],
                    [at_low, number.value, at_high],
                    number.error,
                ));
            }
        }
        rank(&mut all, |s| (s.quantity, s.span), |s| &mut s.rank);
        all.sort_by_key(|s| (s.quantity, s.rank));
        all
    }

    /// Cases of the sample, in order.
    fn sample(&self) -> impl Iterator<Item = &CaseAnswer> {
        self.cases.iter().filter(|case| matches!(case.origin, Origin::Sample { matrix: Matrix::A, .. }))
    }

    fn spread(&self) -> (Vec<Spread>, Vec<Correlation>) {
        let (mut spread, mut correlations) = (Vec::new(), Vec::new());
        for quantity in QuantityOfInterest::ALL {
            let given: Vec<(&CaseAnswer, f64)> =
                self.sample().filter_map(|case| Some((case, case.numbers.get(&quantity)?.value))).collect();
            let values: Vec<f64> = given.iter().map(|(_, value)| *value).collect();
            let error = self.cases.first().and_then(|base| base.numbers.get(&quantity)?.error);
            spread.extend(Spread::new(quantity, &values, error));
            for parameter in &self.parameters {
                let at: Vec<f64> = given.iter().map(|(case, _)| case.parameters[&parameter.name]).collect();
                let correlation = spearman(&at, &values).map(|spearman| Correlation {
                    quantity,
                    parameter: parameter.name.clone(),
                    spearman,
                    rank: 0,
                });
                correlations.extend(correlation);
            }
        }
        rank(&mut correlations, |c| (c.quantity, c.spearman), |c| &mut c.rank);
        correlations.sort_by_key(|c| (c.quantity, c.rank));
        (spread, correlations)
    }

    fn sobol_indices(&self) -> Vec<SobolIndex> {
        let requested = self.question.sample.filter(|sample| sample.indices && self.has_all_cases());
        let Some(sample) = requested else { return Vec::new() };
        let mut all = Vec::new();
        for quantity in QuantityOfInterest::ALL {
            let rows: Vec<SobolRow> =
                (0..sample.count as usize).filter_map(|row| self.sobol_row(row, quantity)).collect();
            let indices = sobol_indices(&rows, sample.seed).unwrap_or_default();
            all.extend(self.parameters.iter().zip(indices).map(|(parameter, (first, total))| SobolIndex {
                quantity,
                parameter: parameter.name.clone(),
                first: first[0],
                first_interval: [first[1], first[2]],
                total: total[0],
                total_interval: [total[1], total[2]],
                is_converged: [first, total].into_iter().all(is_converged),
                rank: 0,
            }));
        }
        rank(&mut all, |s| (s.quantity, s.total), |s| &mut s.rank);
        all.sort_by_key(|s| (s.quantity, s.rank));
        all
    }

    /// A row of the design, if all of its runs gave the number.
    fn sobol_row(&self, row: usize, quantity: QuantityOfInterest) -> Option<SobolRow> {
        let width = self.parameters.len() + 2;
        let first = self.cases.iter().position(|case| matches!(case.origin, Origin::Sample { .. }))?;
        let of = |column: usize| {
            let case = self.cases.get(first + row * width + column)?;
            case.numbers.get(&quantity).map(|number| number.value)
        };
        let mixed = (2..width).map(of).collect::<Option<Vec<f64>>>()?;
        Some(SobolRow { a: of(0)?, b: of(1)?, mixed })
    }
}

fn relative_error(
    relative: &BTreeMap<QuantityOfInterest, f64>,
    quantity: QuantityOfInterest,
    value: f64,
) -> Option<f64> {
    relative.get(&quantity).map(|fraction| fraction * value.abs())
}

/// Relative error; zero over zero is zero.
fn relative_to(error: f64, value: f64) -> f64 {
    if error > 0.0 { error / value.abs() } else { 0.0 }
}

/// Index of a depth among the requested ones.
fn index_of(depth: f64, depths: &[f64]) -> Option<usize> {
    depths.iter().position(|known| known.total_cmp(&depth).is_eq())
}

/// Value of the limited number.
fn number_of(measure: LimitMeasure, numbers: &Numbers, depths: &[f64]) -> Result<Evaluated, String> {
    let (found, is_lower_bound, missing) = match measure {
        LimitMeasure::Quantity(quantity) => (
            numbers.values.get(&quantity),
            // What still grows when a run ends is the number of that run; a depth that the model cuts off is more.
            quantity == QuantityOfInterest::StressDepthMm
                && !numbers.reaches.is_empty()
                && numbers.lower_bounds.contains(&quantity),
            "the scene has no such number",
        ),
        LimitMeasure::VonMisesPaBelowDepthM(depth) => (
            index_of(depth, depths).and_then(|layer| numbers.von_mises_below_pa.get(layer)),
            false,
            "the tissue is not that deep",
        ),
    };
    found.map(|&value| Evaluated { value, is_lower_bound }).ok_or_else(|| {
        let reason = numbers.reason.clone().unwrap_or_else(|| missing.into());
        format!("{}: {reason}", numbers.ending)
    })
}
