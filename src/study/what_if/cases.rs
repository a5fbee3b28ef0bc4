//! The cases of a question, in the order in which they are answered.

use super::base_facts::BaseFacts;
use super::change::edits;
use super::document::WhatIfDocument;
use super::misfit::Misfit;
use super::sampling::points;
use crate::measure::summary::short;
use crate::scene::document::{ErrorBarsDocument, SceneDocument};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// Origin of a case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Origin {
    /// The unmodified base scene.
    Base,
    /// A case with explicit values.
    Case,
    /// A parameter at one end of its range.
    OneAtATime {
        /// Index of the parameter.
        parameter: usize,
        /// Whether it is at the high end.
        is_high: bool,
    },
    /// A point of the sample; for Sobol indices in one of the matrices A, B and A with columns of B (Saltelli 2010).
    Sample {
        /// Row of the matrix.
        row: usize,
        /// Matrix of the design.
        matrix: Matrix,
    },
}

/// A matrix of the sampling design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Matrix {
    /// Matrix A, the sample.
    A,
    /// Second, independent sample B.
    B,
    /// A with one column of B.
    Mixed(usize),
}

/// One case of a question.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Name of the case.
    pub name: String,
    /// Origin of the case.
    pub origin: Origin,
    /// Values by index of the parameter; all others are as in the base.
    pub values: BTreeMap<usize, f64>,
}

impl Case {
    /// Scene of the case, without its own error bars and without data needed only for recording.
    ///
    /// # Errors
    /// The parameter that does not fit the base, and why.
    pub fn scene(
        &self,
        question: &WhatIfDocument,
        base: &SceneDocument,
        facts: &BaseFacts,
    ) -> Result<SceneDocument, (usize, Misfit)> {
        let mut scene = base.clone();
        scene.solver.error_bars = ErrorBarsDocument::None;
        scene.record.fields.clear();
        for (&index, &value) in &self.values {
            question.parameters[index].change.apply(value, &mut scene, facts).map_err(|e| (index, e))?;
        }
        Ok(scene)
    }

    /// Changes of the base document: JSON pointers and new values.
    pub fn edits(
        &self,
        question: &WhatIfDocument,
        base: &SceneDocument,
        facts: &BaseFacts,
    ) -> BTreeMap<String, Value> {
        let mut scene = base.clone();
        for (&index, &value) in &self.values {
            if question.parameters[index].change.apply(value, &mut scene, facts).is_err() {
                return BTreeMap::new();
            }
        }
        let value = |scene: &SceneDocument| serde_json::to_value(scene).unwrap_or_default();
        edits(&value(base), &value(&scene)).into_iter().collect()
    }
}

/// Number of cases in a question, including the base and excluding limits.
pub fn count(question: &WhatIfDocument) -> u64 {
    let parameters = question.parameters.len() as u64;
    let sampled = question.sample.map_or(0, |sample| {
        u64::from(sample.count).saturating_mul(if sample.indices { parameters + 2 } else { 1 })
    });
    let ends = if question.one_at_a_time { 2 * parameters } else { 0 };
    sampled.saturating_add(1 + ends + question.cases.len() as u64)
}

/// All cases: the base, explicit cases, one at a time, the sample. The question must have been validated.
pub fn cases(question: &WhatIfDocument) -> Vec<Case> {
    let mut all = vec![Case { name: "base".into(), origin: Origin::Base, values: BTreeMap::new() }];
    all.extend(question.cases.iter().map(|case| {
        let index = |name: &String| question.parameters.iter().position(|p| p.name == *name);
        let values: BTreeMap<usize, f64> =
            case.set.iter().filter_map(|(name, value)| Some((index(name)?, *value))).collect();
        let name = case.name.clone().unwrap_or_else(|| name_of(question, &values));
        Case { name, origin: Origin::Case, values }
    }));
    if question.one_at_a_time {
        for (index, parameter) in question.parameters.iter().enumerate() {
            let ends = parameter.range().into_iter().flatten().enumerate();
            all.extend(ends.map(|(end, value)| {
                let values = BTreeMap::from([(index, value)]);
                let origin = Origin::OneAtATime { parameter: index, is_high: end == 1 };
                Case { name: name_of(question, &values), origin, values }
            }));
        }
    }
    all.extend(sample(question));
    all
}

/// Cases of the sample, row by row.
fn sample(question: &WhatIfDocument) -> Vec<Case> {
    let Some(sample) = question.sample else { return Vec::new() };
    let parameters = question.parameters.len();
    let dimensions = if sample.indices { 2 * parameters } else { parameters };
    let mut all = Vec::new();
    for (row, point) in
        points(sample.method, sample.count as usize, dimensions, sample.seed).iter().enumerate()
    {
        let mut add = |matrix: Matrix, probability: &dyn Fn(usize) -> f64| {
            let of = |index: usize| Some((index, question.parameters[index].quantile(probability(index))?));
            let name = match matrix {
                Matrix::A => format!("sample {}", row + 1),
                Matrix::B => format!("sample {} b", row + 1),
                Matrix::Mixed(index) => {
                    format!("sample {}, {} of b", row + 1, question.parameters[index].name)
                }
            };
            let values = (0..parameters).filter_map(of).collect();
            all.push(Case { name, origin: Origin::Sample { row, matrix }, values });
        };
        // Sample A, and for Sobol indices B and A with each column of B.
        add(Matrix::A, &|index| point[index]);
        if sample.indices {
            add(Matrix::B, &|index| point[parameters + index]);
            for mixed in 0..parameters {
                let from_b = |index: usize| point[if index == mixed { parameters + index } else { index }];
                add(Matrix::Mixed(mixed), &from_b);
            }
        }
    }
    all
}

/// Descriptive name, such as "speed 120 m/s".
fn name_of(question: &WhatIfDocument, values: &BTreeMap<usize, f64>) -> String {
    let of = |(index, value): (&usize, &f64)| {
        let parameter = &question.parameters[*index];
        let unit = parameter.change.unit();
        let unit = if unit == "-" { String::new() } else { format!(" {unit}") };
        format!("{} {}{unit}", parameter.name, short(*value))
    };
    values.iter().map(of).collect::<Vec<_>>().join(", ")
}
