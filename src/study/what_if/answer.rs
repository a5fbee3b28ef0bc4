//! The answer, as it is told.

use super::super::error::Quantity;
use super::case_answer::CaseAnswer;
use super::document::LimitMeasure;
use super::limit::Verdict;
use super::statistics::{Correlation, Sensitivity, SobolIndex, Spread};
use super::surrogate::Surrogate;
use serde::Serialize;
use std::collections::BTreeMap;

/// The whole answer.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// No medical device, no diagnosis.
    pub notice: &'static str,
    /// Version of the engine.
    pub engine_version: &'static str,
    /// Name of the base.
    pub scene: String,
    /// What the numbers are called, by their names with units.
    pub quantities: BTreeMap<Quantity, QuantityAnswer>,
    /// What varies.
    pub parameters: Vec<ParameterAnswer>,
    /// Where the errors of the numbers come from.
    pub error_bars: String,
    /// The cases that were run, in their order; the first is the base.
    pub cases: Vec<CaseAnswer>,
    /// How many cases the question has; there are fewer only when it was stopped.
    pub cases_asked: usize,
    /// What each parameter does by itself.
    pub sensitivities: Vec<Sensitivity>,
    /// How the numbers are spread over the sample.
    pub spread: Vec<Spread>,
    /// Which parameters the numbers go with over the sample.
    pub correlations: Vec<Correlation>,
    /// Which parameters the variance over the sample comes from; none where the question was stopped before its last case.
    pub sobol_indices: Vec<SobolIndex>,
    /// Polynomials through the cases, which propose what the model would say of others; none where cases are few.
    pub surrogates: Vec<Surrogate>,
    /// Up to which values limits are kept.
    pub limits: Vec<LimitAnswer>,
    /// How many limits the question has; there are fewer only when it was stopped.
    pub limits_asked: usize,
    /// Why it was stopped before its end: `cancelled` or `deadline`; absent when it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<&'static str>,
    /// What it took; the only part that is not the same every time.
    pub effort: Effort,
}

/// What a number is called.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuantityAnswer {
    /// Its name for people, with the threshold that it is about.
    pub title: String,
    /// Its unit.
    pub unit: &'static str,
}

impl Answer {
    /// What a number is called, and its unit.
    pub fn title(&self, quantity: Quantity) -> (&str, &'static str) {
        self.quantities.get(&quantity).map_or(quantity.title(), |q| (&q.title, q.unit))
    }
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
    /// The number's relative numerical error in the base [-]; absent where it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_error: Option<f64>,
    /// Whether the number is resolved in the base, see [`resolved`](super::Number::resolved); from an error of 1 on it never is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolved: Option<bool>,
    /// What would be found if the number were larger by its error, everywhere; absent where that is not known, or not resolved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub if_larger: Option<Verdict>,
    /// What would be found if it were smaller by its error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub if_smaller: Option<Verdict>,
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
