//! What is said of one case.

use super::super::error::Quantity;
use super::cases::Origin;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// Ending of a run that came to its end and has numbers.
pub(super) const FINISHED: &str = "finished";
/// Ending of a run that came to its end without contact: there was no impact that numbers could be of.
pub(super) const NOTHING_TOUCHED: &str = "nothing_touched";

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
    /// `finished`; `nothing_touched` when it finished without contact; `withheld` when a gate failed; `invalid` when the scene cannot run; else the cause of the failure.
    pub ending: String,
    /// Why it has no numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Which ends of the tissue the significant stress reaches: its depth and volume are at least those.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reaches: Vec<String>,
    /// Steps.
    pub steps: u64,
    /// The numbers, by their names with units; empty when it did not finish, or nothing touched.
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
    /// Whether the mesh resolves it: it is larger than its error, and no peak at a point of which two meshes cannot tell whether it
    /// converges. Absent where the error is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolved: Option<bool>,
}

impl CaseAnswer {
    /// Whether the run came to its end, and its results may be shown: without contact it has none.
    pub fn has_finished(&self) -> bool {
        self.ending == FINISHED || self.ending == NOTHING_TOUCHED
    }
}

impl Number {
    /// With its error, where that is known, and whether the run that the error comes from may resolve such a number at all.
    pub fn new(value: f64, error: Option<f64>, may_be_resolved: bool) -> Self {
        let resolved = error.map(|error| error == 0.0 || may_be_resolved && error < value.abs());
        Self { value, error, resolved }
    }
    /// Whether its error is known, and the mesh resolves it.
    pub fn is_resolved(&self) -> bool {
        self.resolved == Some(true)
    }
}
