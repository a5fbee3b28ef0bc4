//! The answer: composed case by case, with what the cases say together at the end.

use super::super::error::Quantity;
use super::cache::Numbers;
use super::cases::{Case, Matrix, Origin};
use super::change::BaseFacts;
use super::document::{ErrorSource, LimitDocument, LimitMeasure, WhatIfDocument};
use super::limit::{Verdict, find_limit};
use super::runner::{Answered, Memory, Runner, Task};
use super::statistics::{
    Correlation, Sensitivity, SobolIndex, SobolRow, Spread, rank, sobol_indices, spearman,
};
use crate::measure::summary::NOTICE;
use crate::scene::document::SceneDocument;
use crate::step::Interrupt;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::time::Instant;

/// The whole answer.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// No medical device, no diagnosis.
    pub notice: &'static str,
    /// Version of the engine.
    pub engine_version: &'static str,
    /// Name of the base.
    pub scene: String,
    /// What varies.
    pub parameters: Vec<ParameterAnswer>,
    /// Where the errors of the numbers come from.
    pub error_bars: String,
    /// The cases that were run, in their order; the first is the base.
    pub cases: Vec<CaseAnswer>,
    /// What each parameter does by itself.
    pub sensitivities: Vec<Sensitivity>,
    /// How the numbers are spread over the sample.
    pub spread: Vec<Spread>,
    /// Which parameters the numbers go with over the sample.
    pub correlations: Vec<Correlation>,
    /// Which parameters the variance over the sample comes from.
    pub sobol_indices: Vec<SobolIndex>,
    /// Up to which values limits are kept.
    pub limits: Vec<LimitAnswer>,
    /// Why it was stopped before its end: `cancelled` or `deadline`; absent when it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<&'static str>,
    /// What it took; the only part that is not the same every time.
    pub effort: Effort,
}

/// A parameter and its value in the base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterAnswer {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its value in the base.
    pub base_value: f64,
    /// Its range, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

/// One case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseAnswer {
    /// Its place in the question, from 0: the base.
    pub index: usize,
    /// What it is called.
    pub name: String,
    /// Where it comes from.
    pub origin: Origin,
    /// Values of all parameters, by name.
    pub parameters: BTreeMap<String, f64>,
    /// What it changes in the scene of the base: JSON pointers and new values, enough to run it by itself.
    pub edits: BTreeMap<String, Value>,
    /// `finished`; `withheld` when a gate failed; `invalid` when the scene cannot run; else the cause of the failure.
    pub ending: String,
    /// Why, when it did not finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Steps.
    pub steps: u64,
    /// The numbers, by their names with units; empty when it did not finish.
    pub numbers: BTreeMap<Quantity, Number>,
}

/// A number with its numerical error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Number {
    /// The number.
    pub value: f64,
    /// Its numerical error, in the same unit; absent where it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
}

/// What is known of a limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitAnswer {
    /// Name of the parameter.
    pub parameter: String,
    /// Its unit.
    pub unit: &'static str,
    /// The number.
    pub measure: LimitMeasure,
    /// The limit.
    pub at_most: f64,
    /// What was found on the model itself.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Runs that it took, those that were known included.
    pub runs: u32,
}

/// What the answer took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effort {
    /// Runs side by side.
    pub threads: usize,
    /// Answers that were computed.
    pub computed: u64,
    /// Answers that had been computed before.
    pub from_cache: u64,
    /// Wall time to the first answer [s].
    pub first_answer_s: f64,
    /// Wall time to the end [s].
    pub wall_s: f64,
}

/// A part of the answer, told as it comes.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Partial<'a> {
    /// A case. Cases that come before the error bars have none.
    Case {
        /// How many cases there are.
        of: usize,
        /// The case.
        #[serde(flatten)]
        case: &'a CaseAnswer,
    },
    /// Relative errors [-] of the base, by number: those of all cases.
    ErrorBars {
        /// The errors.
        relative_errors: &'a BTreeMap<Quantity, f64>,
    },
    /// A limit.
    Limit(&'a LimitAnswer),
}

/// Makes the answer.
pub(super) struct Composer<'a> {
    question: &'a WhatIfDocument,
    base: &'a SceneDocument,
    facts: &'a BaseFacts,
    count: usize,
    parameters: Vec<ParameterAnswer>,
    relative_errors: BTreeMap<Quantity, f64>,
    cases: Vec<CaseAnswer>,
    limits: Vec<LimitAnswer>,
    started: Instant,
    effort: Effort,
}

impl<'a> Composer<'a> {
    pub fn new(
        question: &'a WhatIfDocument,
        base: &'a SceneDocument,
        facts: &'a BaseFacts,
        count: usize,
    ) -> Self {
        let parameters = question.parameters.iter().map(|parameter| ParameterAnswer {
            name: parameter.name.clone(),
            unit: parameter.change.unit(),
            // The question was checked: every change fits the base.
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
            cases: Vec::new(),
            limits: Vec::new(),
            started: Instant::now(),
            effort: Effort { threads: 0, computed: 0, from_cache: 0, first_answer_s: 0.0, wall_s: 0.0 },
        }
    }

    fn note(&mut self, answered: &Answered) {
        *(if answered.from_cache { &mut self.effort.from_cache } else { &mut self.effort.computed }) += 1;
    }

    /// Takes in the error bars of the base: they are those of all cases, also of those that are there.
    pub fn take_errors(&mut self, answered: &Answered, tell: &mut dyn FnMut(Partial)) {
        self.note(answered);
        let Numbers { values, errors, .. } = &answered.numbers;
        let relative = |(quantity, error): (&Quantity, &f64)| {
            let value = values.get(quantity).filter(|value| **value != 0.0)?;
            Some((*quantity, (error / value).abs()))
        };
        self.relative_errors = errors.iter().filter_map(relative).collect();
        for case in &mut self.cases {
            for (quantity, number) in &mut case.numbers {
                number.error = relative_error(&self.relative_errors, *quantity, number.value);
            }
        }
        tell(Partial::ErrorBars { relative_errors: &self.relative_errors });
    }

    /// Takes in a case.
    pub fn take_case(&mut self, case: &Case, answered: Answered, tell: &mut dyn FnMut(Partial)) {
        self.note(&answered);
        if self.cases.is_empty() {
            self.effort.first_answer_s = self.started.elapsed().as_secs_f64();
        }
        let Numbers { ending, reason, steps, values, errors, .. } = answered.numbers;
        let number = |(quantity, value): (Quantity, f64)| {
            let own = errors.get(&quantity).copied();
            let error = own.or_else(|| relative_error(&self.relative_errors, quantity, value));
            (quantity, Number { value, error })
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
            steps,
            numbers: values.into_iter().map(number).collect(),
        };
        tell(Partial::Case { of: self.count, case: &answer });
        self.cases.push(answer);
    }

    /// Looks for a limit on the model itself.
    pub fn take_limit(
        &mut self,
        limit: &LimitDocument,
        runner: &Runner,
        threads: usize,
        tell: &mut dyn FnMut(Partial),
    ) {
        let Some(index) = self.question.parameters.iter().position(|p| p.name == limit.parameter) else {
            return;
        };
        let Some(range) = self.question.parameters[index].range() else { return };
        let (mut memory, mut runs) = (Memory::default(), 0);
        let verdict = find_limit(range, limit.at_most, limit.tolerance, &mut |value| {
            let values = BTreeMap::from([(index, value)]);
            let case = Case { name: String::new(), origin: Origin::Case, values };
            let answered = runner.answer(&Task { case: &case, with_errors: false }, threads, &mut memory);
            let answered = answered.ok_or("it was stopped")?;
            runs += 1;
            self.note(&answered);
            number_of(limit.measure, &answered.numbers, &runner.depths)
        });
        let unit = self.parameters[index].unit;
        let parameter = limit.parameter.clone();
        let answer =
            LimitAnswer { parameter, unit, measure: limit.measure, at_most: limit.at_most, verdict, runs };
        tell(Partial::Limit(&answer));
        self.limits.push(answer);
    }

    /// The whole answer.
    pub fn finish(self, interrupt: Option<Interrupt>, threads: usize) -> Answer {
        let (spread, correlations) = self.spread();
        Answer {
            notice: NOTICE,
            engine_version: env!("CARGO_PKG_VERSION"),
            scene: self.base.name.clone(),
            error_bars: self.error_bars_in_words(),
            sensitivities: self.sensitivities(),
            spread,
            correlations,
            sobol_indices: self.sobol_indices(),
            parameters: self.parameters,
            cases: self.cases,
            limits: self.limits,
            stopped: interrupt.map(|interrupt| match interrupt {
                Interrupt::Cancel => "cancelled",
                Interrupt::Deadline => "deadline",
            }),
            effort: Effort { threads, wall_s: self.started.elapsed().as_secs_f64(), ..self.effort },
        }
    }

    fn error_bars_in_words(&self) -> String {
        match self.question.error_bars {
            ErrorSource::None => "not estimated: nobody asked for error bars".into(),
            ErrorSource::Full => "of each case, from runs of it on a coarser mesh: two levels, first order assumed, factor of safety 3".into(),
            ErrorSource::Base if self.relative_errors.is_empty() => "not estimated: the base has no error bars".into(),
            ErrorSource::Base => "the relative errors of the base, taken over to every case: from runs of the base on a coarser mesh \
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
        rank(&mut all, |s| (s.quantity, s.change), |s| &mut s.rank);
        all.sort_by_key(|s| (s.quantity, s.rank));
        all
    }

    /// Cases of the sample itself, in their order.
    fn sample(&self) -> impl Iterator<Item = &CaseAnswer> {
        self.cases.iter().filter(|case| matches!(case.origin, Origin::Sample { matrix: Matrix::A, .. }))
    }

    fn spread(&self) -> (Vec<Spread>, Vec<Correlation>) {
        let (mut spread, mut correlations) = (Vec::new(), Vec::new());
        for quantity in Quantity::ALL {
            let given: Vec<(&CaseAnswer, f64)> =
                self.sample().filter_map(|case| Some((case, case.numbers.get(&quantity)?.value))).collect();
            let values: Vec<f64> = given.iter().map(|(_, value)| *value).collect();
            spread.extend(Spread::new(quantity, &values));
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
        let Some(sample) = self.question.sample.filter(|sample| sample.indices) else { return Vec::new() };
        let mut all = Vec::new();
        for quantity in Quantity::ALL {
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
                rank: 0,
            }));
        }
        rank(&mut all, |s| (s.quantity, s.total), |s| &mut s.rank);
        all.sort_by_key(|s| (s.quantity, s.rank));
        all
    }

    /// A row all of whose runs gave the number.
    fn sobol_row(&self, row: usize, quantity: Quantity) -> Option<SobolRow> {
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

fn relative_error(relative: &BTreeMap<Quantity, f64>, quantity: Quantity, value: f64) -> Option<f64> {
    relative.get(&quantity).map(|share| share * value.abs())
}

/// The number that has a limit.
fn number_of(measure: LimitMeasure, numbers: &Numbers, depths: &[f64]) -> Result<f64, String> {
    let found = match measure {
        LimitMeasure::Quantity(quantity) => numbers.values.get(&quantity),
        LimitMeasure::VonMisesPaBelowDepthM(depth) => {
            let layer = depths.iter().position(|known| known.total_cmp(&depth).is_eq());
            layer.and_then(|layer| numbers.von_mises_below_pa.get(layer))
        }
    };
    found.copied().ok_or_else(|| {
        let reason = numbers.reason.clone().unwrap_or_else(|| "the scene has no such number".into());
        format!("{}: {reason}", numbers.ending)
    })
}
