//! What was given up, in the summary.

use super::written::{number, seconds};
use crate::measure::eroded::{Eroded, ErodedPart};
use crate::plan::Plan;
use serde::Serialize;

/// What of one part was given up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErosionOfPart {
    /// Name of the body.
    pub body: String,
    /// Name of the part.
    pub part: String,
    /// Number of elements.
    pub elements: usize,
    /// Their volume at rest [mm³].
    pub volume_mm3: f64,
    /// Their mass, which stays with the nodes [kg].
    pub mass_kg: f64,
    /// When the first one was given up [s].
    pub since_s: f64,
}

/// Every part that lost elements, in the order of the plan.
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
    /// One sentence.
    pub fn in_words(&self) -> String {
        let elements = if self.elements == 1 { "element was" } else { "elements were" };
        format!(
            "{} {elements} given up in {} ({}), {} mm³ of it, from {} on: it tears there.",
            self.elements,
            self.part,
            self.body,
            number(self.volume_mm3),
            seconds(self.since_s)
        )
    }
}
