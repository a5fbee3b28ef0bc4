//! Exports of a recorded run: a report page, tables, a bundle for clinical systems, fields and surfaces for other programs.
//!
//! Everything comes from the recording alone ([`RecordedRun`]), so the report of a received file states what its run
//! stated.

pub mod csv;
pub mod date;
pub mod fhir;
pub mod fields;
pub mod html;
pub mod instant;
mod numbers;
mod omissions;
mod pictures;
mod read;
mod section;
mod section_frame;
mod section_picture;
mod section_scale;
pub mod surface;
mod surface_file;

pub use read::{ReadError, RecordedRun, Series};

use crate::measure::QuantityOfInterest;
use crate::measure::summary::number;
use serde_json::Value;

/// A quantity of the summary with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// The value, in the unit of the quantity.
    pub value: f64,
    /// Its numerical error (half width), if estimated.
    pub error: Option<f64>,
    /// Whether the error was estimated and is smaller than the value; otherwise the value is shown in brackets.
    pub is_resolved: bool,
}

impl Shown {
    /// From a quantity of a summary; `None` if it has no value.
    pub fn of(quantity: &Value) -> Option<Self> {
        let value = quantity.get("value").and_then(Value::as_f64)?;
        let error = quantity.pointer("/error/total").and_then(Value::as_f64);
        Some(Self {
            value,
            error,
            is_resolved: quantity.pointer("/error/resolved") == Some(&Value::Bool(true)),
        })
    }

    /// Remark on its error; none for a resolved value.
    pub fn doubt(&self) -> Option<&'static str> {
        match (self.is_resolved, self.error) {
            (true, _) => None,
            (false, Some(_)) => Some("not resolved"),
            (false, None) => Some("error not estimated"),
        }
    }
}

/// Whether nothing touched in a run, so that its numbers describe no impact.
pub fn is_miss(summary: &Value) -> bool {
    values(summary)["nothing_touched"] == true
}

/// The computed values of a run, whether or not they are withheld.
pub fn values(summary: &Value) -> &Value {
    if summary.get("results").is_some() { &summary["results"] } else { &summary["withheld"]["values"] }
}

/// The contact that the headline of a run refers to.
pub fn headline_impact(values: &Value) -> Option<&Value> {
    let index = values.pointer("/headline/impact")?.as_u64()?;
    values["impacts"].get(usize::try_from(index).ok()?)
}

/// A quantity of interest as recorded; `None` where the run has it not.
fn recorded(values: &Value, quantity: QuantityOfInterest) -> Option<&Value> {
    use QuantityOfInterest as Of;
    let (impact, tissue) = (headline_impact(values), &values["tissue"]);
    let found = match quantity {
        Of::PeakForceN | Of::ImpulseNS | Of::LargestPatchAreaMm2 | Of::PatchAreaMm2 => {
            impact?.get(quantity.name())
        }
        Of::EnergyGivenJ | Of::AbsorbedEnergyJ | Of::DeflectionMm => tissue.get(quantity.name()),
        Of::StressDepthMm => headline_stress(values)?.get("depth_mm"),
        Of::PrincipalStrain => tissue.get("peak_principal_strain"),
        Of::PrincipalStrainInVolume => tissue.pointer("/exceeded_in_volume/principal_strain"),
    };
    found.filter(|found| found["value"].is_number())
}

/// Title of a quantity of interest, with the window, threshold or volume that it depends on.
fn title(values: &Value, quantity: QuantityOfInterest) -> String {
    let words = quantity.title();
    let words = format!("{}{}", words[..1].to_uppercase(), &words[1..]);
    let force_average = || headline_impact(values)?["force_average"].as_str();
    let threshold = || headline_stress(values)?["threshold_pa"].as_f64();
    let volume = || values.pointer("/tissue/exceeded_in_volume/volume_mm3")?.as_f64();
    let exact = match quantity {
        QuantityOfInterest::PeakForceN => force_average().map(|average| format!("{words}, {average}")),
        QuantityOfInterest::StressDepthMm => {
            threshold().map(|threshold| format!("{words} above {}", number_of_kpa(threshold)))
        }
        QuantityOfInterest::PrincipalStrainInVolume => {
            volume().map(|volume| words.replace("a volume", &format!("{} mm³", number(volume))))
        }
        _ => None,
    };
    exact.unwrap_or(words)
}

/// A stress in kilopascals.
fn number_of_kpa(pascal: f64) -> String {
    let text = number(1e-3 * pascal);
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{short} kPa")
}

/// The stress threshold that the headline of a run refers to, with depth and volume.
pub fn headline_stress(values: &Value) -> Option<&Value> {
    let index = values.pointer("/headline/significant_stress")?.as_u64()?;
    values["tissue"]["significant_stress"].get(usize::try_from(index).ok()?)
}
