//! A row of the table: one setting, what it cost and what it found.

use super::quantity::Quantity;
use crate::study::setting::Setting;
use serde::Serialize;
use std::collections::BTreeMap;

/// One run.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// How the scene was computed.
    pub setting: Setting,
    /// The same for people, with the steps that were taken where they are much shorter than those that were asked for.
    pub name: String,
    /// `finished`, `left_out`, or the cause of the failure.
    pub ending: String,
    /// Why it was left out or failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Elements.
    pub elements: usize,
    /// Steps.
    pub steps: u64,
    /// Wall time [s].
    pub wall_s: f64,
    /// Processor time [s].
    pub cpu_s: Option<f64>,
    /// The quantities of interest, by name.
    pub values: BTreeMap<Quantity, f64>,
    /// Their relative errors [-].
    pub errors: BTreeMap<Quantity, f64>,
}

impl Row {
    /// Processor time, or wall time where the system does not tell the former [s].
    pub fn cost_s(&self) -> f64 {
        self.cpu_s.unwrap_or(self.wall_s)
    }
    /// Whether it came to its end.
    pub fn is_finished(&self) -> bool {
        self.ending == "finished"
    }
}
