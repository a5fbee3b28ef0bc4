//! The answer to a what-if question.

use super::case_answer::CaseAnswer;
use super::document::LimitMeasure;
use super::limit::Verdict;
use super::statistics::{Correlation, Sensitivity, SobolIndex, Spread};
use super::surrogate::Surrogate;
use crate::measure::{QuantityOfInterest, QuantityTitle};
use serde::Serialize;
use std::collections::BTreeMap;

/// Answer to a question, complete or stopped early.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// The disclaimer of every result.
    pub notice: &'static str,
    /// Version of the engine.
    pub engine_version: &'static str,
    /// Name of the base scene.
    pub scene: String,
    /// Titles and units of the numbers, by their names with units.
    pub quantities: BTreeMap<QuantityOfInterest, QuantityTitle>,
    /// Parameters that vary, with their ranges.
    pub parameters: Vec<ParameterAnswer>,
    /// Source of the numerical errors.
    pub error_bars: String,
    /// Completed cases in order; the first is the base.
    pub cases: Vec<CaseAnswer>,
    /// Number of cases requested; more than `cases` only if the question was stopped.
    pub requested_cases: usize,
    /// Effect of each parameter by itself.
    pub sensitivities: Vec<Sensitivity>,
    /// Distribution of the numbers over the sample.
    pub spread: Vec<Spread>,
    /// Correlation of the numbers with the parameters over the sample.
    pub correlations: Vec<Correlation>,
    /// Contributions of the parameters to the variance over the sample; empty if the question was stopped early.
    pub sobol_indices: Vec<SobolIndex>,
    /// Polynomial surrogates fitted to the cases; empty if there are too few.
    pub surrogates: Vec<Surrogate>,
    /// Parameter values up to which limits are met.
    pub limits: Vec<LimitAnswer>,
    /// Number of limits requested; more than `limits` only if the question was stopped.
    pub requested_limits: usize,
    /// Why it was stopped early: `cancelled` or `deadline`; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<&'static str>,
    /// Computational cost; the only part that is not reproducible.
    pub effort: Effort,
}

impl Answer {
    /// Title and unit of a number.
    pub fn title(&self, quantity: QuantityOfInterest) -> (&str, &'static str) {
        self.quantities
            .get(&quantity)
            .map_or((quantity.short_title(), quantity.unit()), |q| (&q.title, q.unit))
    }
}

/// A parameter and its value in the base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterAnswer {
    /// Name of the parameter.
    pub name: String,
    /// Unit of the parameter.
    pub unit: &'static str,
    /// Value of the parameter in the base.
    pub base_value: f64,
    /// Range of the parameter, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

/// Result for one limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitAnswer {
    /// Name of the parameter.
    pub parameter: String,
    /// Unit of the parameter.
    pub unit: &'static str,
    /// Number that the limit applies to.
    pub measure: LimitMeasure,
    /// Limit of the number.
    pub at_most: f64,
    /// Result of the search on the model itself.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Relative numerical error of the number in the base [-]; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_error: Option<f64>,
    /// Whether the number is resolved in the base, see [`resolved`](super::Number::resolved); never for an error of 1
    /// or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolved: Option<bool>,
    /// Result if the number were larger by its error everywhere; absent if that is unknown, or not resolved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub if_larger: Option<Verdict>,
    /// Result if the number were smaller by its error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub if_smaller: Option<Verdict>,
    /// Runs required, including cached ones.
    pub runs: u32,
}

/// Computational cost of the answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effort {
    /// Number of parallel runs.
    pub threads: usize,
    /// Number of results computed.
    pub computed: u64,
    /// Number of results found in the cache.
    pub from_cache: u64,
    /// Wall time to the first answer [s].
    pub first_answer_s: f64,
    /// Wall time to the end [s].
    pub wall_s: f64,
}

/// A part of the answer, delivered as soon as it is available.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Partial<'a> {
    /// A case. Cases that precede the error bars have none.
    Case {
        /// Total number of cases.
        of: usize,
        /// Units of the parameters, by name.
        units: BTreeMap<&'a str, &'static str>,
        /// Answer of the case.
        #[serde(flatten)]
        case: &'a CaseAnswer,
    },
    /// Relative errors [-] of the base by number, valid for all cases.
    ErrorBars {
        /// Relative errors by number [-].
        relative_errors: &'a BTreeMap<QuantityOfInterest, f64>,
    },
    /// Result for one limit.
    Limit(&'a LimitAnswer),
}
