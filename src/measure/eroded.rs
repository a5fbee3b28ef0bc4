//! Eroded elements: those deformed beyond the limits of their parts, part by part.

use crate::step::Frame;
use std::collections::BTreeMap;

/// Eroded elements of one part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErodedPart {
    /// Number of eroded elements.
    pub elements: usize,
    /// Their reference volume [m³].
    pub volume: f64,
    /// Their mass, which stays with the nodes [kg].
    pub mass: f64,
    /// Time of the first erosion [s].
    pub since: f64,
}

/// Eroded elements so far.
#[derive(Clone, Debug, Default)]
pub struct Eroded {
    /// Entries by body and part index.
    pub parts: BTreeMap<(usize, u32), ErodedPart>,
    known: usize,
}

impl Eroded {
    /// Accumulates the elements eroded up to a frame.
    pub fn accumulate(&mut self, frame: &Frame) {
        let gone = frame.erosion.elements().len();
        if gone == self.known {
            return;
        }
        self.known = gone;
        let before = std::mem::take(&mut self.parts);
        for block in frame.plan.blocks.iter().filter(|block| block.parameters.erosion.is_some()) {
            let body = &frame.plan.bodies[block.body];
            for (slot, element) in block.elements.iter().enumerate() {
                if !frame.erosion.contains(*element) {
                    continue;
                }
                let key = (block.body, body.part_of[(element - body.elements.start) as usize]);
                let since = before.get(&key).map_or(frame.time, |part| part.since);
                let part = self.parts.entry(key).or_insert(ErodedPart { since, ..ErodedPart::default() });
                let volume = block.point_volumes(slot).iter().sum::<f64>();
                part.elements += 1;
                part.volume += volume;
                part.mass += volume * block.parameters.density;
            }
        }
    }
}
