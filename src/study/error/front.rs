//! Choice of a setting: the Pareto front of error and cost, and the cheapest setting for a requested error.

use super::{Reference, Row};
use crate::measure::QuantityOfInterest;
use serde::Serialize;
use std::collections::BTreeMap;

/// Relative errors for which settings are recommended [-].
pub const TARGETS: [f64; 3] = [0.01, 0.03, 0.1];

/// The cheapest setting for one quantity and one target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// QuantityOfInterest in question; absent for the headline numbers of the scene at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantity: Option<QuantityOfInterest>,
    /// Relative error that must not be exceeded, the uncertainty of the reference included [-].
    pub target: f64,
    /// Name of the setting; absent if none on the ladder reaches the target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub setting: Option<String>,
    /// Cost of the setting [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cost_s: Option<f64>,
}

/// Advice for each quantity, then for the headline numbers at once.
pub(super) fn advice(rows: &[Row], references: &BTreeMap<QuantityOfInterest, Reference>) -> Vec<Advice> {
    let quantities: Vec<QuantityOfInterest> = references.keys().copied().collect();
    if quantities.is_empty() {
        return Vec::new();
    }
    let each = quantities.iter().map(|q| (Some(*q), vec![*q]));
    let headline = QuantityOfInterest::HEADLINE.into_iter().filter(|q| references.contains_key(q)).collect();
    each.chain(std::iter::once((None, headline)))
        .flat_map(|(quantity, requested)| {
            TARGETS.map(|target| choose(rows, references, quantity, &requested, target))
        })
        .collect()
}

fn choose(
    rows: &[Row],
    references: &BTreeMap<QuantityOfInterest, Reference>,
    quantity: Option<QuantityOfInterest>,
    requested: &[QuantityOfInterest],
    target: f64,
) -> Advice {
    let reaches = |row: &&Row| {
        row.is_finished()
            && requested.iter().all(|q| certain_error(row, references, *q).is_some_and(|e| e <= target))
    };
    let best = rows.iter().filter(reaches).min_by(|a, b| a.cost_s().total_cmp(&b.cost_s()));
    Advice { quantity, target, setting: best.map(|row| row.name.clone()), cost_s: best.map(Row::cost_s) }
}

/// Upper bound of the error of a run: its distance from the reference plus the uncertainty of the latter [-].
fn certain_error(
    row: &Row,
    references: &BTreeMap<QuantityOfInterest, Reference>,
    quantity: QuantityOfInterest,
) -> Option<f64> {
    let reference = references.get(&quantity)?;
    Some(row.errors.get(&quantity)? + reference.uncertainty() / reference.value().abs())
}

impl Row {
    /// Whether no other finished run is both cheaper and at least as accurate.
    pub fn is_on_front(&self, rows: &[Self], quantity: QuantityOfInterest) -> bool {
        let Some(error) = self.errors.get(&quantity) else { return false };
        let beaten = |other: &Self| {
            other.is_finished()
                && other.errors.get(&quantity).is_some_and(|e| {
                    (*e <= *error && other.cost_s() < self.cost_s())
                        || (*e < *error && other.cost_s() <= self.cost_s())
                })
        };
        self.is_finished() && !rows.iter().any(beaten)
    }
}
