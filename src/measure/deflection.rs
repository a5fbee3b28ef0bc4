//! Deflection of the tissue's skin.

use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::step::Frame;

/// The largest displacement of a node of the tissue's skin.
#[derive(Clone, Debug, Default)]
pub struct Deflection {
    /// Sorted nodes of the skin.
    nodes: Vec<u32>,
    /// Largest ‖u‖ so far [m].
    pub largest: f64,
    /// When [s].
    pub time: f64,
    /// Reference position of that node [m].
    pub position: Vec3,
}

impl Deflection {
    /// Of the plan's tissue skin.
    pub fn new(plan: &Plan) -> Self {
        let mut nodes: Vec<u32> = plan.measures.tissue_skin.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        Self { nodes, ..Self::default() }
    }

    /// Takes in one step.
    pub fn accumulate(&mut self, frame: &Frame) {
        for &node in &self.nodes {
            let u = frame.u[node as usize].norm();
            if u > self.largest {
                (self.largest, self.time) = (u, frame.time);
                self.position = frame.plan.X[node as usize];
            }
        }
    }
}
