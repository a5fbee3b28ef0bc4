//! A row of the table: one setting with its cost and results.

use crate::measure::QuantityOfInterest;
use crate::study::setting::Setting;
use serde::Serialize;
use std::collections::BTreeMap;

/// One run of the study.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Numerical setting of the run.
    pub setting: Setting,
    /// Human-readable name of the setting, with the mean step if much shorter than requested.
    pub name: String,
    /// Ending: `finished`, `omitted`, or the cause of the failure.
    pub ending: String,
    /// Why it was omitted or failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Number of elements of the scene.
    pub elements: usize,
    /// Number of steps of the run.
    pub steps: u64,
    /// Wall time of the run [s].
    pub wall_s: f64,
    /// Processor time of the run [s].
    pub cpu_s: Option<f64>,
    /// Quantities of interest, by name.
    pub values: BTreeMap<QuantityOfInterest, f64>,
    /// Relative errors of these quantities [-].
    pub errors: BTreeMap<QuantityOfInterest, f64>,
}

impl Row {
    /// Processor time, or wall time if the system does not provide the former [s].
    pub fn cost_s(&self) -> f64 {
        self.cpu_s.unwrap_or(self.wall_s)
    }
    /// Whether the run finished.
    pub fn is_finished(&self) -> bool {
        self.ending == "finished"
    }
}
