//! Eroded elements in the summary.

use super::written::{seconds, volume};
use crate::measure::eroded::{Eroded, ErodedPart};
use crate::plan::Plan;
use serde::Serialize;

/// Eroded elements of one part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErosionOfPart {
    /// Name of the body, as in the scene.
    pub body: String,
    /// Name of the part, as in the scene.
    pub part: String,
    /// Number of eroded elements.
    pub elements: usize,
    /// Their reference volume [mm³].
    pub volume_mm3: f64,
    /// Their mass, which stays with the nodes [kg].
    pub mass_kg: f64,
    /// Time of the first erosion [s].
    pub since_s: f64,
}

/// All parts that lost elements, in the order of the plan.
pub(super) fn erosion(eroded: &Eroded, plan: &Plan) -> Vec<ErosionOfPart> {
    let of_part = |(&(body, part), eroded): (&(usize, u32), &ErodedPart)| ErosionOfPart {
        body: plan.bodies[body].name.clone(),
        part: plan.bodies[body].parts[part as usize].clone(),
        elements: eroded.elements,
        volume_mm3: 1e9 * eroded.volume,
        mass_kg: eroded.mass,
        since_s: eroded.since,
    };
    eroded.parts.iter().map(of_part).collect()
}

impl ErosionOfPart {
    /// The erosion in one sentence.
    pub fn in_words(&self) -> String {
        let elements = if self.elements == 1 { "element was" } else { "elements were" };
        format!(
            "{} {elements} eroded in {} ({}), {} of it, from {} on: it ruptures there, in a volume that depends on the size of its elements.",
            self.elements,
            self.part,
            self.body,
            volume(self.volume_mm3),
            seconds(self.since_s)
        )
    }
}
