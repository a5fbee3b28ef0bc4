//! Softened tissue in the summary.

use super::written::{seconds, volume};
use crate::measure::law_range::{LawRanges, PartRange};
use serde::Serialize;

/// Softened volume of one part, at the field times.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SofteningOfPart {
    /// Name of the body, as in the scene.
    pub body: String,
    /// Name of the part, as in the scene.
    pub part: String,
    /// Largest reference volume whose stress was reduced [mm³].
    pub softened_mm3: f64,
    /// Largest reference volume that had lost more than half of its stress [mm³].
    pub torn_mm3: f64,
    /// First field time with softened tissue [s].
    pub since_s: f64,
}

/// All parts that softened, in the order of the plan.
pub(super) fn softening(laws: &LawRanges) -> Vec<SofteningOfPart> {
    let of_part = |part: &PartRange| {
        Some(SofteningOfPart {
            body: part.body.clone(),
            part: part.part.clone(),
            softened_mm3: 1e9 * part.softened.volume(),
            torn_mm3: 1e9 * part.torn.volume(),
            since_s: part.softened.since?,
        })
    };
    laws.parts.iter().filter_map(of_part).collect()
}

impl SofteningOfPart {
    /// The softening in one sentence.
    pub fn in_words(&self) -> String {
        format!(
            "{} ({}) exceeded its strength in {} from {} on; in {} damage exceeds one half, without eroded elements.",
            self.part,
            self.body,
            volume(self.softened_mm3),
            seconds(self.since_s),
            volume(self.torn_mm3)
        )
    }
}
