//! `/summary`: the running clinical summary.

use super::RecordError;
use super::proto::contuse::{DepthAbove, NumberError, Summary as Message};
use crate::measure::Summary;
use crate::measure::summary::{ErrorEstimate, Quantity, Shown};

/// Topic.
pub const TOPIC: &str = "/summary";
/// Schema.
pub const SCHEMA: &str = "contuse.v1.Summary";

/// The message of a summary; `time` [s] and `step` are those of the latest frame.
///
/// # Errors
/// When the summary cannot be serialised.
pub fn message(summary: &Summary, time: f64, step: u64) -> Result<Message, RecordError> {
    let mut message = Message {
        time_s: time,
        step,
        withheld: matches!(summary.results, Shown::Withheld { .. }),
        balance_error: summary.numerics.balance_error,
        numerical_contact_dissipation_j: summary.numerics.numerical_contact_dissipation_j,
        json: serde_json::to_string(summary)?,
        ..Message::default()
    };
    // A run that failed a gate gives no plain number, here neither.
    let Shown::Results(results) = &summary.results else { return Ok(message) };
    if let Some(impact) = results.headline.impact.and_then(|index| results.impacts.get(index)) {
        message.peak_force_n = impact.peak_force_n.value;
        message.impulse_n_s = impact.impulse_n_s.value;
        message.patch_area_m2 = 1e-6 * impact.patch_area_mm2.value;
        message.peak_force_error = error(&impact.peak_force_n, 1.0);
        message.impulse_error = error(&impact.impulse_n_s, 1.0);
        message.patch_area_error = error(&impact.patch_area_mm2, 1e-6);
    }
    if let Some(tissue) = &results.tissue {
        message.absorbed_energy_j = tissue.absorbed_energy_j.value;
        message.absorbed_energy_error = error(&tissue.absorbed_energy_j, 1.0);
        message.depths = tissue
            .significant_stress
            .iter()
            .map(|s| DepthAbove {
                threshold_pa: s.threshold_pa,
                depth_m: 1e-3 * s.depth_mm.as_ref().map_or(0.0, |d| d.value),
                volume_m3: 1e-9 * s.volume_mm3.value,
                depth_error: s.depth_mm.as_ref().and_then(|depth| error(depth, 1e-3)),
                volume_error: error(&s.volume_mm3, 1e-9),
            })
            .collect();
    }
    Ok(message)
}

/// The error of a number of the summary, times a factor; `None` where it was not estimated.
fn error(quantity: &Quantity, factor: f64) -> Option<NumberError> {
    match &quantity.error {
        ErrorEstimate::Estimated(e) => {
            Some(NumberError { half_width: factor * e.total, resolved: e.resolved })
        }
        ErrorEstimate::NotEstimated | ErrorEstimate::NothingTouched => None,
    }
}
