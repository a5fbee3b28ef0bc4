//! Answer for one case.

use super::cases::Origin;
use crate::measure::QuantityOfInterest;
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Ending of a run that finished and has numbers.
pub(super) const FINISHED: &str = "finished";
/// Ending of a run that finished without contact: there was no impact that numbers could describe.
pub(super) const NOTHING_TOUCHED: &str = "nothing_touched";

/// Answer for one case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseAnswer {
    /// Index of the case in the question; 0 is the base.
    pub index: usize,
    /// Name of the case.
    pub name: String,
    /// Origin of the case.
    pub origin: Origin,
    /// Values of all parameters, by name.
    pub parameters: BTreeMap<String, f64>,
    /// Changes of the base scene: JSON pointers and new values, sufficient to run it separately.
    pub edits: BTreeMap<String, Value>,
    /// `finished`; `nothing_touched` if it finished without contact; `withheld` if an acceptance check failed; `invalid` if the
    /// scene cannot run; otherwise the cause of the failure.
    pub ending: String,
    /// Why there are no numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Ends of the tissue at which the significant stress is as deep as anywhere, so that its depth is a lower bound.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reaches: Vec<String>,
    /// Numbers that are lower bounds: there the tissue ends, or they were still growing when the run ended with contact lasting.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub lower_bounds: BTreeSet<QuantityOfInterest>,
    /// Number of steps of the run.
    pub steps: u64,
    /// Results by their names with units; empty if the run did not finish, or nothing touched.
    pub numbers: BTreeMap<QuantityOfInterest, Number>,
}

/// A number with its numerical error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Number {
    /// Value in the unit of its name.
    pub value: f64,
    /// Numerical error, in the same unit; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Whether the mesh resolves it: the value exceeds its error, and is no pointwise peak, for which two meshes cannot
    /// show convergence. Absent if the error is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolved: Option<bool>,
}

impl CaseAnswer {
    /// Whether the run finished and its results may be shown: without contact it has none.
    pub fn has_finished(&self) -> bool {
        self.ending == FINISHED || self.ending == NOTHING_TOUCHED
    }
}

impl Number {
    /// With its error, if known, and whether the run that estimated it can resolve such a number at all.
    pub fn new(value: f64, error: Option<f64>, may_be_resolved: bool) -> Self {
        let resolved = error.map(|error| error == 0.0 || may_be_resolved && error < value.abs());
        Self { value, error, resolved }
    }
    /// Whether its error is known, and the mesh resolves it.
    pub fn is_resolved(&self) -> bool {
        self.resolved == Some(true)
    }
}
