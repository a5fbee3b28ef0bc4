//! `/summary`: the running clinical summary.

use super::RecordError;
use super::proto::contuse::{DepthAbove, Summary as Message};
use crate::measure::Summary;
use crate::measure::summary::{Impact, Shown};

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
    if let Some(impact) = headline(&results.impacts) {
        message.peak_force_n = impact.peak_force_n.value;
        message.impulse_n_s = impact.impulse_n_s.value;
        message.patch_area_m2 = 1e-6 * impact.patch_area_mm2.value;
    }
    if let Some(tissue) = &results.tissue {
        message.absorbed_energy_j = tissue.absorbed_energy_j.value;
        message.depths = tissue
            .significant_stress
            .iter()
            .map(|s| DepthAbove {
                threshold_pa: s.threshold_pa,
                depth_m: 1e-3 * s.depth_mm.as_ref().map_or(0.0, |d| d.value),
                volume_m3: 1e-9 * s.volume_mm3.value,
            })
            .collect();
    }
    Ok(message)
}

/// The pair with the largest peak force of those that touch the tissue, of all when none does.
fn headline(impacts: &[Impact]) -> Option<&Impact> {
    let on_tissue = impacts.iter().any(|i| i.on_tissue);
    let candidates = impacts.iter().filter(|i| i.on_tissue == on_tissue);
    candidates.max_by(|a, b| a.peak_force_n.value.total_cmp(&b.peak_force_n.value))
}
