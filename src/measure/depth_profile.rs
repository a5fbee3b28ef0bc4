//! Von Mises stress by depth below the skin: the maximum in each layer of depth, over the field times.

use crate::mechanics::element::POINTS;
use crate::mesh::distance::DepthField;
use crate::plan::Plan;
use crate::scene::document::Role;
use crate::step::{Frame, Recorder, RecorderError};

/// Accumulates over the quadrature points of the tissue.
pub struct DepthProfile {
    /// Upper bounds of the layers [m], ascending; the last one is unbounded below.
    from: Vec<f64>,
    /// Largest von Mises stress of each layer so far [Pa].
    pub peaks: Vec<f64>,
    /// Distance to the skin; `None` before the start and without a skin.
    skin: Option<DepthField>,
    /// Indices of the tissue bodies.
    bodies: Vec<usize>,
    /// Depth of the quadrature points, 8 per slot [m]; NaN until evaluated.
    depth: Vec<f64>,
    /// Largest depth evaluated so far [m].
    deepest: f64,
}

/// Depth of the deepest quadrature point of the tissue below the skin [m], or of any at least `enough` deep; `None`
/// without tissue or skin.
pub fn deepest_point(plan: &Plan, enough: f64) -> Option<f64> {
    let skin = DepthField::new(&plan.measures.tissue_skin, &plan.X).ok()?;
    let bodies = tissue(plan);
    let mut deepest = None;
    for block in plan.blocks.iter().filter(|block| bodies.contains(&block.body)) {
        for slot in 0..block.elements.len() {
            for q in 0..block.kind.point_count() {
                let depth = skin.depth(&block.point_position(slot, q, &plan.X));
                deepest = Some(deepest.map_or(depth, |known: f64| known.max(depth)));
            }
            if deepest >= Some(enough) {
                return deepest;
            }
        }
    }
    deepest
}

/// Indices of the tissue bodies.
fn tissue(plan: &Plan) -> Vec<usize> {
    (0..plan.bodies.len()).filter(|&b| plan.bodies[b].role == Role::Tissue).collect()
}

impl DepthProfile {
    /// A profile of layers that begin at these depths [m], ascending. Points above the first are ignored.
    pub fn new(from: Vec<f64>) -> Self {
        let peaks = vec![0.0; from.len()];
        Self { peaks, from, skin: None, bodies: Vec::new(), depth: Vec::new(), deepest: f64::NEG_INFINITY }
    }

    /// Largest von Mises stress below the top of each layer [Pa], as deep as the tissue extends; empty without tissue
    /// or skin.
    pub fn peaks_from_each(&self) -> Vec<f64> {
        (0..self.from.len()).filter_map(|layer| self.peak_from(layer)).collect()
    }

    /// Largest von Mises stress below the top of a layer [Pa]; `None` if no point of the tissue lies that deep.
    pub fn peak_from(&self, layer: usize) -> Option<f64> {
        self.skin.as_ref().filter(|_| self.from.get(layer).is_some_and(|from| *from <= self.deepest))?;
        Some(self.peaks.get(layer..)?.iter().copied().fold(0.0, f64::max))
    }
}

impl Recorder for DepthProfile {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        *self = Self::new(std::mem::take(&mut self.from));
        let faces = &plan.measures.tissue_skin;
        if !faces.is_empty() && !self.from.is_empty() {
            let skin = DepthField::new(faces, &plan.X).map_err(|error| RecorderError(Box::new(error)))?;
            self.skin = Some(skin);
            self.bodies = tissue(plan);
            self.depth = vec![f64::NAN; POINTS * plan.slot_count()];
        }
        Ok(())
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let Some(skin) = self.skin.as_ref().filter(|_| frame.is_field_time) else { return Ok(()) };
        for block in frame.plan.blocks.iter().filter(|block| self.bodies.contains(&block.body)) {
            block.for_each_moved_batch(frame.points(), &mut |slots, points| {
                for (lane, slot) in slots.clone().enumerate() {
                    for q in 0..points.count {
                        let depth = &mut self.depth[POINTS * (block.first_slot + slot) + q];
                        if depth.is_nan() {
                            *depth = skin.depth(&block.point_position(slot, q, &frame.plan.X));
                            self.deepest = self.deepest.max(*depth);
                        }
                        // The deepest layer that begins above the point; none if the point is above the first.
                        let layers = self.from.partition_point(|from| from <= depth);
                        if let Some(layer) = layers.checked_sub(1) {
                            self.peaks[layer] = self.peaks[layer].max(points.von_mises[q][lane]);
                        }
                    }
                }
            });
        }
        Ok(())
    }
}
