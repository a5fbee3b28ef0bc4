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
    /// Whether the error was estimated and leaves something of the number: only then it is a plain one.
    pub is_resolved: bool,
}

impl Shown {
    /// Of a quantity of a summary; `None` where there is none.
    pub fn of(quantity: &Value) -> Option<Self> {
        let value = quantity.get("value").and_then(Value::as_f64)?;
        let error = quantity.pointer("/error/total").and_then(Value::as_f64);
        Some(Self {
            value,
            error,
            is_resolved: quantity.pointer("/error/resolved") == Some(&Value::Bool(true)),
        })
    }

    /// What is said of its error besides the number; nothing of a resolved one.
    pub fn doubt(&self) -> Option<&'static str> {
        match (self.is_resolved, self.error) {
            (true, _) => None,
            (false, Some(_)) => Some("not resolved"),
            (false, None) => Some("error not estimated"),
        }
    }
}

/// Whether nothing touched in a run: then none of its numbers is of an impact.
pub fn is_miss(summary: &Value) -> bool {
    values(summary)["nothing_touched"] == true
}

/// What a run computed, whether or not it may be shown as results.
pub fn values(summary: &Value) -> &Value {
    if summary.get("results").is_some() { &summary["results"] } else { &summary["withheld"]["values"] }
}

/// The contact that the headline of a run's values is about.
pub fn headline_impact(values: &Value) -> Option<&Value> {
    let index = values.pointer("/headline/impact")?.as_u64()?;
    values["impacts"].get(usize::try_from(index).ok()?)
}

/// The threshold of stress that the headline of a run's values is about, with depth and volume.
pub fn headline_stress(values: &Value) -> Option<&Value> {
    let index = values.pointer("/headline/significant_stress")?.as_u64()?;
    values["tissue"]["significant_stress"].get(usize::try_from(index).ok()?)
}
