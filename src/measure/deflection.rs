//! Deflection of the tissue's skin.

use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::step::Frame;

/// The largest displacement of a node of the tissue's skin from where the scene puts it; of a tissue that nothing holds less the mean
/// displacement of its skin, which is no deflection.
#[derive(Clone, Debug, Default)]
pub struct Deflection {
    /// Sorted nodes of the skin.
    nodes: Vec<u32>,
    /// Whether a node of the tissue is held along an axis, or moved as the scene says.
    is_held: bool,
    /// Largest ‖u‖ so far [m].
    pub largest: f64,
    /// When [s].
    pub time: f64,
    /// Reference position of that node [m].
    pub position: Vec3,
    /// Largest product of the largest deflection at a time and its rate, d ḋ, so far [m²/s].
    pub largest_rate: f64,
    /// When [s].
    pub largest_rate_time: f64,
    /// Time [s] and largest ‖u‖ [m] of the latest step.
    latest: Option<(f64, f64)>,
}

impl Deflection {
    /// Of the plan's tissue skin.
    pub fn new(plan: &Plan) -> Self {
        let mut nodes: Vec<u32> = plan.measures.tissue_skin.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let holds = |node: &u32| plan.inverse_mass[*node as usize].iter().any(|m| *m == 0.0);
        let bodies = plan
            .bodies
            .iter()
            .filter(|body| body.nodes.clone().any(|node| nodes.binary_search(&node).is_ok()));
        let is_held = bodies.into_iter().any(|body| body.nodes.clone().any(|node| holds(&node)));
        Self { nodes, is_held, ..Self::default() }
    }

    /// Takes in one step.
    pub fn accumulate(&mut self, frame: &Frame) {
        let mut now = 0.0_f64;
        let start = |node: u32| frame.plan.initial_u.get(node as usize).copied().unwrap_or_default();
        // From where it was at the start: a body that starts turned or stretched is not deflected yet.
        let moved = |node: u32| frame.u[node as usize] - start(node);
        let all = self.nodes.iter().map(|&node| moved(node)).sum::<Vec3>();
        let drift = if self.is_held { Vec3::zeros() } else { all / self.nodes.len().max(1) as f64 };
        for &node in &self.nodes {
            let u = (moved(node) - drift).norm();
            now = now.max(u);
            if u > self.largest {
                (self.largest, self.time) = (u, frame.time);
                self.position = frame.plan.X[node as usize];
            }
        }
        if let Some((time, before)) = self.latest
            && frame.time > time
        {
            // d ḋ = (d²)˙ / 2 over the step.
            let product = 0.5 * (now * now - before * before) / (frame.time - time);
            if product > self.largest_rate {
                (self.largest_rate, self.largest_rate_time) = (product, frame.time);
            }
        }
        self.latest = Some((frame.time, now));
    }
}
