//! Largest von Mises stress below each of some depths below the surface, over the field times.

use super::computed::{Computed, ComputedMotion};
use super::stress_field::StressField;
use super::tissue_parts::TissueParts;
use crate::mesh::MeshError;
use crate::plan::Plan;
use crate::step::{Frame, Recorder, RecorderError};

/// Accumulates the [`StressField`] of the tissue.
pub struct DepthProfile {
    /// The depths [m], ascending.
    from: Vec<f64>,
    /// Largest stress from each of them on so far [Pa].
    peaks: Vec<f64>,
    /// The tissue and its field; `None` before the start and without a surface to measure depth from.
    tissue: Option<(TissueParts, StressField)>,
    motion: ComputedMotion,
}

/// Depth of the deepest node of the tissue below the surface [m]; `None` without tissue or surface.
pub fn deepest_node(plan: &Plan) -> Option<f64> {
    tissue(plan).ok()??.1.deepest()
}

/// The tissue and its field.
fn tissue(plan: &Plan) -> Result<Option<(TissueParts, StressField)>, MeshError> {
    let parts = TissueParts::new(&Computed::of(plan));
    let field = parts.stress_field(plan)?;
    Ok(field.map(|field| (parts, field)))
}

impl DepthProfile {
    /// A profile from these depths [m] on, ascending.
    pub fn new(from: Vec<f64>) -> Self {
        Self { peaks: vec![0.0; from.len()], from, tissue: None, motion: ComputedMotion::default() }
    }

    /// Largest von Mises stress from each depth on [Pa], as deep as the tissue extends; empty without tissue or surface.
    pub fn peaks_from_each(&self) -> Vec<f64> {
        let deepest = self.tissue.as_ref().and_then(|(_, field)| field.deepest());
        let is_inside = |from: &f64| deepest.is_some_and(|deepest| *from <= deepest);
        self.from
            .iter()
            .zip(&self.peaks)
            .take_while(|(from, _)| is_inside(from))
            .map(|(_, peak)| *peak)
            .collect()
    }
}

impl Recorder for DepthProfile {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        *self = Self::new(std::mem::take(&mut self.from));
        if !self.from.is_empty() {
            self.tissue = tissue(plan).map_err(|error| RecorderError(Box::new(error)))?;
        }
        Ok(())
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let Some((parts, field)) = self.tissue.as_mut().filter(|_| frame.is_field_time) else {
            return Ok(());
        };
        field.begin();
        let (computed, own) = (Computed::of(frame.plan), self.motion.frame(frame));
        for block in own.plan.blocks.iter().filter(|block| parts.bodies.contains(&block.body)) {
            block.for_each_moved_batch(own.points(), &mut |slots, points| {
                for image in 0..computed.images() {
                    for (lane, slot) in slots.clone().enumerate() {
                        let slot = computed.slot(block.first_slot + slot, image);
                        for q in 0..points.count {
                            field.add(slot, q, (points.von_mises[q][lane], points.volume[q][lane]));
                        }
                    }
                }
            });
        }
        field.end();
        for (peak, from) in self.peaks.iter_mut().zip(&self.from) {
            *peak = peak.max(field.largest_below(*from));
        }
        Ok(())
    }
}
