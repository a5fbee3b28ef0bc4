//! What is handed out of a run that was recorded: a page for people, tables, and a bundle for clinical systems.
//!
//! Everything comes from the recording alone ([`RecordedRun`]), so a report of a file that somebody sends says what the run said.

pub mod csv;
pub mod fhir;
pub mod html;
mod pictures;
mod read;

pub use read::{ReadError, RecordedRun, Series};

use serde_json::Value;

/// A number of the summary with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// The number.
    pub value: f64,
    /// Its numerical error, where it was estimated.
    pub error: Option<f64>,
}

impl Shown {
    /// Of a quantity of a summary; `None` where there is none.
    pub fn of(quantity: &Value) -> Option<Self> {
        let error = quantity.pointer("/error/total").and_then(Value::as_f64);
        quantity.get("value").and_then(Value::as_f64).map(|value| Self { value, error })
    }
}

/// The contact of a summary that its headline is about: on the tissue if any is, with the largest peak force.
pub fn headline_impact(summary: &Value) -> Option<&Value> {
    let impacts = summary.pointer("/results/impacts")?.as_array()?;
    let on_tissue = |impact: &Value| impact["on_tissue"] == true;
    let any = impacts.iter().any(on_tissue);
    let force = |impact: &Value| impact.pointer("/peak_force_n/value").and_then(Value::as_f64).unwrap_or(0.0);
    impacts.iter().filter(|impact| on_tissue(impact) == any).max_by(|a, b| force(a).total_cmp(&force(b)))
}
